"""Measured materials: files of metals that are known look as these metals do."""

import base64
import re

import numpy as np
import pytest

from alight.bsdfs.conductors.rough_conductor import RoughConductor
from alight.bsdfs.measured.examples import brushed, satin
from alight.bsdfs.measured.measured import Measured, _albedo_of
from alight.bsdfs.measured.measurement import read_measurement
from alight.bsdfs.measured.warp import (
    Viewed,
    Warp,
    density_at,
    invert_warp,
    sample_warp,
    warp_tables,
)
from alight.core.errors import SceneError
from alight.core.spectra import reflectance_weights
from alight.formats import dumps, loads
from alight.laws.materials import Material, direction
from alight.laws.statistics import unit_vectors
from alight.scene import flatten
from alight.shapes.surfaces import needs_tangents
from lanewise.view import View
from tests.physics.measured_files import metal, write

ETA, K = (0.143, 0.3753, 1.442), (3.983, 2.3856, 1.6034)
THETAS = np.linspace(0.0, 1.5, 13)
QUARTER = np.linspace(-np.pi, -0.5 * np.pi, 7)
#: Of those whose facets turn away from the viewer a coarse grid knows little.
HEIGHTS = (0.95, 0.6, 0.3)


@pytest.fixture(scope="module")
def fields():
    """A metal without a grain."""
    return metal(0.3, ETA, K, THETAS)


@pytest.fixture(scope="module")
def grained():
    """One with a grain, measured in one of four equal quarters."""
    return metal(0.3, ETA, K, THETAS[::2], phis=QUARTER, facets=(41, 41), colors=9, alpha_y=0.6)


def read(fields, tmp_path):
    data, _ = read_measurement(write(tmp_path / "it.bsdf", fields))
    return Measured(data=data)


def difference(found, wanted):
    """Mean of the differences over that of the values."""
    return float(np.abs(found - wanted).mean() / wanted.mean())


@pytest.mark.parametrize("cosine", HEIGHTS)
def test_values_are_those_of_the_metal(fields, cosine, tmp_path):
    wo, wi = direction(cosine, 2.0), np.abs(unit_vectors(4000, 2))
    found, _ = Material(read(fields, tmp_path)).evaluate(wo, wi)
    wanted, _ = Material(RoughConductor(eta=ETA, k=K, alpha=0.3)).evaluate(wo, wi)
    # Read from grids of 65 and of 24 points, and viewers 7 degrees apart.
    assert difference(found, wanted) < 0.04


@pytest.mark.parametrize("azimuth", [0.4, 1.2, 2.0, -2.8, -0.3])
def test_grain_lies_as_that_of_the_metal(grained, azimuth, tmp_path):
    spec = RoughConductor(eta=ETA, k=K, alpha_u=0.3, alpha_v=0.6)
    wo, wi = direction(0.7, azimuth), unit_vectors(4000, 3)
    wi[2] = np.abs(wi[2])
    found, _ = Material(read(grained, tmp_path)).evaluate(wo, wi)
    wanted, _ = Material(spec).evaluate(wo, wi)
    assert difference(found, wanted) < 0.05


@pytest.mark.parametrize("data", [satin(), brushed()], ids=["satin", "brushed"])
def test_the_albedo_is_what_is_reflected_of_light_from_above(data):
    """Samples that fail count as black, so their mean over a grid that misses them is too large."""
    n = 400
    cosine, phi = (c.ravel() for c in np.meshgrid((np.arange(n) + 0.5) / n, np.arange(n)))
    # Steps that grow with the angle: the lobe is narrow.
    cosine, phi = 1.0 - cosine**3, 2.0 * np.pi * phi / n
    sine = np.sqrt(1.0 - cosine**2)
    wi = np.array([sine * np.cos(phi), sine * np.sin(phi), cosine])
    solid_angle = 6.0 * np.pi * (1.0 - cosine) ** (2.0 / 3.0) / n**2
    f_cos, _ = Material(Measured(data=data)).evaluate(direction(1.0, 0.0), wi)
    np.testing.assert_allclose(_albedo_of(data), f_cos @ solid_angle, rtol=1e-3)


def test_only_what_has_a_grain_needs_the_tangents_of_shapes():
    # Without it, programs may take any frame about the normal.
    assert needs_tangents(Material(Measured(data=brushed())).program)
    assert not needs_tangents(Material(Measured(data=satin())).program)


def test_exchanged_directions_reflect_alike_as_far_as_was_measured(fields, tmp_path):
    material = Material(read(fields, tmp_path))
    a, b = (np.abs(unit_vectors(3000, seed)) for seed in (4, 5))
    a[2], b[2] = np.maximum(a[2], 0.3), np.maximum(b[2], 0.3)
    a, b = a / np.linalg.norm(a, axis=0), b / np.linalg.norm(b, axis=0)
    there, back = material.evaluate(a, b)[0] / b[2], material.evaluate(b, a)[0] / a[2]
    assert difference(there, back) < 0.05


def test_spectra_are_reduced_in_daylight_and_it_is_said(tmp_path):
    waves = (360.0, 500.0, 600.0, 830.0)
    index = {"eta": (0.2,) * 4, "k": (3.0,) * 4}
    small = {"thetas": (0.0, 1.0), "facets": (17, 17), "colors": 4}
    grey = metal(0.5, **index, **small, wavelengths=waves)
    same = metal(0.5, (0.2,) * 3, (3.0,) * 3, **small)
    found, notes = read_measurement(write(tmp_path / "a.bsdf", grey))
    wanted, none = read_measurement(write(tmp_path / "b.bsdf", same))
    np.testing.assert_allclose(found.arrays["rgb"], wanted.arrays["rgb"], rtol=1e-5)
    assert none == []
    assert "4 wavelengths, 360 to 830 nm" in notes[0]
    assert "clipped" not in notes[0]
    # Light at one wavelength is no colour of sRGB.
    grey["spectra"] = np.zeros((1, 2, 4, 4, 4), np.float32)
    grey["spectra"][:, :, 1] = 1.0
    found, notes = read_measurement(write(tmp_path / "a.bsdf", grey))
    assert re.search(r"clipped, by up to \d", notes[0])
    assert found.arrays["rgb"][0, 0, 0].max() == 0.0
    assert found.arrays["rgb"].min() == 0.0


@pytest.mark.parametrize(
    ("waves", "says"),
    [
        ((360.0, 500.0, 600.0, 830.0), []),
        ((410.0, 500.0, 600.0, 670.0), []),
        ((200.0, 500.0, 600.0, 2500.0), ["go beyond 360 to 830 nm"]),
        ((360.0, 500.0, 600.0, 831.0), ["go beyond 360 to 830 nm"]),
        ((450.0, 500.0, 600.0, 830.0), ["do not reach from 410 to 670 nm"]),
        ((300.0, 500.0, 550.0, 600.0), ["go beyond", "do not reach"]),
    ],
)
def test_wavelengths_that_are_not_seen_or_lack_are_told(waves, says, tmp_path):
    index = {"eta": (0.2,) * 4, "k": (3.0,) * 4}
    fields = metal(0.5, **index, thetas=(0.0, 1.0), facets=(9, 9), colors=4, wavelengths=waves)
    _, notes = read_measurement(write(tmp_path / "a.bsdf", fields))
    assert len(notes) == 1 + len(says)
    assert all(text in note for text, note in zip(says, notes, strict=False))


@pytest.mark.parametrize("waves", [(0.36, 0.5, 0.6, 0.83), (900.0, 1000.0, 1500.0, 2000.0)])
def test_wavelengths_of_which_none_is_seen_are_refused(waves, tmp_path):
    """Micrometres, or infrared light."""
    index = {"eta": (0.2,) * 4, "k": (3.0,) * 4}
    fields = metal(0.5, **index, thetas=(0.0, 1.0), facets=(9, 9), colors=4, wavelengths=waves)
    with pytest.raises(SceneError, match=r"wavelengths must be in nm, and some of them in"):
        read_measurement(write(tmp_path / "a.bsdf", fields))


def test_points_of_the_square_come_back():
    rng = np.random.default_rng(6)
    density = rng.random((2, 3, 7, 5)).astype(np.float32) ** 2
    tables = warp_tables(density)
    n = 500
    warp = Warp(
        View(tables.ravel().astype(np.float32)), np.uint32(0), np.uint32(tables.shape[2]),
        np.float32(7.0), np.float32(5.0),
    )  # fmt: skip
    first = np.zeros(n, np.uint32)
    parts = (rng.random(n).astype(np.float32) for _ in range(2))
    viewed = Viewed(first, first + np.uint32(1), first + np.uint32(3), *parts)
    u = tuple(rng.random((2, n)).astype(np.float32))
    point, pdf = sample_warp(warp, viewed, u)
    back, again = invert_warp(warp, viewed, point)
    np.testing.assert_allclose(back, u, atol=2e-5)
    np.testing.assert_allclose(again, pdf, rtol=1e-3)
    # Of samples that follow a density, the mean of its inverse is the area of the square.
    assert abs((1.0 / pdf).mean() - 1.0) < 0.2


def test_between_measured_directions_densities_are_mixed():
    rng = np.random.default_rng(7)
    tables = warp_tables(rng.random((2, 2, 3, 3)).astype(np.float32))
    size = np.uint32(tables.shape[2])
    warp = Warp(View(tables.ravel().astype(np.float32)), np.uint32(0), size, *np.float32([3, 3]))
    u = tuple(rng.random((2, 50)).astype(np.float32))

    def at(row, elevation=0.0, azimuth=0.0):
        first, one = np.full(50, row, np.uint32), np.ones(50, np.uint32)
        parts = (one * np.float32(part) for part in (elevation, azimuth))
        # Where nothing follows there is no step.
        steps = (one * np.uint32(elevation > 0.0), 2 * one * np.uint32(azimuth > 0.0))
        return density_at(warp, Viewed(first, *steps, *parts), u)

    # Rows: two elevations of an azimuth, then those of the other.
    wanted = 0.5 * (0.75 * at(0) + 0.25 * at(1)) + 0.5 * (0.75 * at(2) + 0.25 * at(3))
    np.testing.assert_allclose(at(0, 0.25, 0.5), wanted, rtol=1e-5)


@pytest.mark.parametrize("data", [satin(), brushed()])
def test_descriptions_hold_the_measurement_itself(data, tmp_path):
    scene = """{alight: 1, camera: {fov: 30}, nodes: {it: {shape: sphere, bsdf: {type: measured,
        %s}}, lamp: {light: point}}}"""
    (tmp_path / "it.bsdf").write_bytes(base64.b64decode(data.plain()))
    named = flatten(loads(scene % "file: it.bsdf", "a.yaml", tmp_path))
    (found,) = named.bsdfs
    assert found.data == data
    whole = loads(scene % f"data: {data.plain()}", "a.yaml")
    assert whole.nodes["it"].bsdf.data == data
    assert loads(dumps(whole)).nodes["it"].bsdf.data == data


WRONG = {
    "nothing": (lambda f: None, "needs the field ndf"),
    "degrees": (
        lambda f: f.update(theta_i=np.rad2deg(f["theta_i"])),
        "theta_i must be in .* radians, got",
    ),
    "more azimuths": (lambda f: f.update(phi_i=np.zeros(2, "f4")), "as many rows as phi_i"),
    "descending": (lambda f: f.update(theta_i=f["theta_i"][::-1].copy()), "theta_i must ascend"),
    "not finite": (lambda f: f.update(ndf=f["ndf"] * np.float32(np.nan)), "ndf must be finite"),
    "dark": (lambda f: f.update(sigma=0 * f["sigma"]), "sigma must be > 0 somewhere"),
    "flat": (lambda f: f.update(vndf=f["vndf"][0, 0]), "vndf must have 4 dimensions"),
    "narrow": (lambda f: f.update(ndf=f["ndf"][:1]), "ndf must have at least 2 x 2 texels"),
    "large": (lambda f: f.update(rgb=f["rgb"][..., :2].copy()), "equally large"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_measurements_are_refused(name, tmp_path):
    fields = metal(0.5, ETA, K, (0.0, 1.0), facets=(9, 9), colors=3)
    change, said = WRONG[name]
    change(fields)
    if name == "nothing":
        del fields["ndf"]
    with pytest.raises(SceneError, match=said):
        read(fields, tmp_path)


def test_broken_files_are_refused(tmp_path):
    path = write(tmp_path / "a.bsdf", metal(0.5, ETA, K, (0.0, 1.0), facets=(9, 9), colors=3))
    whole = path.read_bytes()
    for data, said in (
        (b"ply\n", "no tensor file"),
        (whole[:40], "ends within its table"),
        (whole[:-5], "reaches beyond the end"),
        (whole[:12] + b"\x07" + whole[13:], "version 7.0"),
    ):
        path.write_bytes(data)
        with pytest.raises(SceneError, match=said):
            read_measurement(path)
    with pytest.raises(SceneError, match="no such file"):
        read_measurement(tmp_path / "b.bsdf")


@pytest.mark.parametrize("turns", [2, 4])
def test_what_was_measured_in_a_part_of_a_turn_is_repeated(turns, tmp_path):
    """Half a turn of azimuths comes again turned by half a turn, a quarter mirrored besides."""
    phis = np.linspace(-np.pi, (2.0 / turns - 1.0) * np.pi, 7)
    fields = metal(0.4, ETA, K, THETAS[::4], phis=phis, facets=(13, 13), colors=7, alpha_y=0.6)
    uneven = np.random.default_rng(3).uniform(0.2, 1.0, fields["rgb"].shape)
    fields["rgb"] = np.float32(fields["rgb"] * uneven)
    material = Material(read(fields, tmp_path))
    wo, wi = np.abs(unit_vectors(400, 4)), np.abs(unit_vectors(400, 5)) * [[1.0], [-1.0], [1.0]]
    value, density = material.evaluate(*(w.astype(np.float32) for w in (wo, wi)))
    for x, y in ((-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)):
        there = (np.float32(w * [[x], [y], [1.0]]) for w in (wo, wi))
        again, dense = material.evaluate(*there)
        if turns == 4 or x == y:
            np.testing.assert_allclose(again, value, rtol=1e-3, atol=1e-4)
            np.testing.assert_allclose(dense, density, rtol=1e-3, atol=1e-4)
        else:
            assert difference(again, value) > 0.05


def test_beyond_the_measured_wavelengths_a_reflectance_is_that_of_the_last_one():
    own, wide = np.array([480.0, 550.0, 620.0]), np.array([300.0, 480.0, 550.0, 620.0, 900.0])
    values = np.array([0.2, 0.7, 0.4])
    wanted = reflectance_weights(wide) @ values[[0, 0, 1, 2, 2]]
    np.testing.assert_allclose(reflectance_weights(own) @ values, wanted, rtol=1e-9)
