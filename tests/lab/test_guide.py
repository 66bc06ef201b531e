"""`alight guide`: directions, light and densities where they are known."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.lab.guide.hemisphere import hemisphere
from alight.lab.guide.incidence import FACE, arriving_light
from alight.lab.guide.vertex import vertex_of
from alight.scene import flatten

#: A camera above a floor, what it looks at, and a mirror beside.
SCENE = """alight: 1
camera: {{type: pinhole, fov: 30, transform: {{look_at: {{origin: [0, 4, 1], target: [0, 0, 0]}}}}}}
film: {{size: [16, 16]}}
integrator: {{type: path, max_depth: 3, light_sampling: {sampling}}}
nodes:
  floor:
    shape: rectangle
    bsdf: {{type: diffuse, reflectance: 0.5}}
    transform: [{{rotate: {{axis: x, angle: -90}}}}]
{rest}
"""
SKY = "  sky: {light: {type: constant, radiance: [1, 2, 3]}}"
LAMP = """
  lamp:
    shape: {{type: sphere, radius: 0.1, center: [{0}, {1}, {2}]}}
    light: {{type: area, radiance: 10}}
"""
UPWARDS = "camera.transform={look_at: {origin: [0, 4, 1], target: [0, 9, 0]}}"


def scene(rest: str, sampling: str = "bsdf") -> alight.Scene:
    """A floor and something that shines."""
    return loads(SCENE.format(sampling=sampling, rest=rest))


@pytest.mark.parametrize("upper", [True, False])
def test_a_disk_is_a_hemisphere(upper: bool) -> None:
    disk = hemisphere(128, upper=upper, bottom=0.3)
    sign = 1.0 if upper else -1.0
    np.testing.assert_allclose(np.linalg.norm(disk.w, axis=0), 1.0, atol=1e-12)
    assert np.isclose(disk.w.shape[1] * disk.solid_angle, 2.0 * np.pi, rtol=0.01)
    # Equal areas: heights are even in [0, 1], and so is their square.
    np.testing.assert_allclose(sign * disk.w[2].mean(), 0.5, atol=0.005)
    np.testing.assert_allclose((disk.w[2] ** 2).mean(), 1.0 / 3.0, atol=0.005)
    np.testing.assert_allclose(disk.w[:2].mean(axis=1), 0.0, atol=1e-12)
    # The lowest pixels are where they were asked to be, the right ones a quarter turn on.
    shown = disk.picture(disk.w.T)
    for pixel, azimuth in (((127, 64), 0.3), ((64, 127), 0.3 + 0.5 * np.pi)):
        x, y, z = shown[pixel]
        assert abs(z) < 0.1
        assert np.hypot(x - np.cos(azimuth), y - np.sin(azimuth)) < 0.05


def test_a_pixel_sees_the_floor_as_it_is() -> None:
    vertex = vertex_of(scene(SKY), (8, 8), seed=0)
    assert (vertex.shape, vertex.material, vertex.depth) == ("floor", "diffuse", 1)
    np.testing.assert_allclose(vertex.position, 0.0, atol=0.2)
    back = vertex.frame @ np.array(vertex.wo)
    camera = np.array([0.0, 4.0, 1.0]) - vertex.position
    np.testing.assert_allclose(back, camera / np.linalg.norm(camera), atol=1e-6)
    f_cos, density = vertex.scattering(hemisphere(64).w)
    cosine = hemisphere(64).w[2]
    np.testing.assert_allclose(density, cosine / np.pi, atol=1e-6)
    np.testing.assert_allclose(f_cos, np.stack([0.5 * cosine / np.pi] * 3, axis=1), atol=1e-6)


def test_a_pixel_sees_behind_a_mirror() -> None:
    mirror = """
  mirror:
    shape: rectangle
    bsdf: {type: conductor}
    transform: [{scale: 0.4}, {rotate: {axis: x, angle: -90}}, {translate: [0, 1, 0.2]}]
  ceiling:
    shape: rectangle
    transform: [{scale: 9}, {rotate: {axis: x, angle: 90}}, {translate: [0, 7, 0]}]
"""
    vertex = vertex_of(scene(SKY + mirror), (8, 8), seed=0)
    assert (vertex.shape, vertex.depth) == ("ceiling", 2)


@pytest.mark.parametrize("towards", [(0.3, 0.9, -0.2), (-0.8, 0.3, 0.4), (0.1, 0.2, -0.9)])
def test_light_arrives_from_where_it_is(towards: tuple[float, float, float]) -> None:
    d = np.array(towards) / np.linalg.norm(towards)
    compiled = compile_scene(flatten(scene(LAMP.format(*(2.0 * d)))))
    rng = np.random.default_rng(1)
    around = rng.standard_normal((3, 4000))
    around = np.concatenate([around / np.linalg.norm(around, axis=0), d[:, None]], axis=1)
    origin = np.array([0.0, 1e-4, 0.0])
    light = arriving_light(compiled, origin, around, spp=16, seed=3, threads=1)
    assert light.shape == (2, 4001, 3)
    np.testing.assert_allclose(light[:, -1], 10.0)
    # The lamp's edge, give or take a pixel of the cube.
    cosine, pixel = d @ around, np.sqrt(2.0) * np.arctan(2.0 / FACE)
    edge = np.arcsin(0.1 / 2.0)
    assert np.all(light[:, np.arccos(np.minimum(cosine, 1.0)) < edge - pixel] == 10.0)
    dark = (np.arccos(np.minimum(cosine, 1.0)) > edge + pixel) & (around[1] > 0.0)
    # Upwards there is nothing but the lamp.
    assert np.all(light[:, dark] == 0.0)


def test_where_light_is_even_a_cosine_is_the_ideal_density(tmp_path) -> None:
    target = tmp_path / "floor.png"
    found = alight.guide(scene(SKY), (8, 8), spp=4, output=target)
    (side,) = found.sides
    np.testing.assert_allclose(
        side.light, np.tile([1.0, 2.0, 3.0], (len(side.light), 1)), rtol=1e-5
    )
    np.testing.assert_allclose(side.ideal, side.of_bsdf, rtol=0.01, atol=1e-4)
    np.testing.assert_allclose(
        side.of_mixture, found.share * side.of_guide + (1.0 - found.share) * side.of_bsdf, rtol=1e-5
    )
    assert abs(found.relative_variances["BSDF"]) < 0.01
    assert not found.without_lamps
    assert target.read_bytes().startswith(b"\x89PNG")
    assert "floor (diffuse)" in str(found)
    assert "<img" in found._repr_html_()


def test_the_command_prints_numbers_and_refuses_what_is_wrong(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "floor.yaml"
    lamp = LAMP.format(1.5, 2.0, 0.0)
    file.write_text(SCENE.format(sampling="mis", rest=lamp), encoding="utf-8")
    run = CliRunner().invoke
    told = run(app, ["guide", "floor.yaml", "--pixel", "8,8", "--spp", "2", "--json", "-q"])
    assert told.exit_code == 0, told.output
    found = json.loads(told.stdout)
    assert found["shape"] == "floor" and found["without_lamps"]
    assert (tmp_path / "floor.guide.png").exists()
    for words, message in (
        (["--pixel", "99,8"], "x in [0, 15]"),
        (["--pixel", "8,8", "-o", "a.jpg"], "the maps are a .png file"),
        (["--pixel", "8,8", "--set", "integrator={type: random_walk}"], "follows no guide"),
        (["--pixel", "8,8", "--set", "integrator={type: volpath}"], "goes through media"),
        (["--pixel", "8,8", "--set", UPWARDS], "no surface that scatters"),
    ):
        refused = run(app, ["guide", "floor.yaml", *words])
        assert refused.exit_code == 2
        assert message in " ".join(refused.output.split())
