"""Spectra, indices, boxes of grids and sides of cubes, as the documentation of Mitsuba has them."""

import struct

import numpy as np
import pytest

from alight.scene.flatten import flatten
from tests.formats.mitsuba.reading import read, read_bsdf
from tests.formats.mitsuba.test_laws_of_frames import listed, step


def spectrum(kind, values, **words):
    strings = "".join(f'<string name="{n}" value="{listed(v)}"/>' for n, v in words.items())
    text = f'<string name="values" value="{listed(values)}"/>{strings}'
    return f'<spectrum name="reflectance" type="{kind}">{text}</spectrum>'


def test_regular_spectra_begin_and_end_where_the_observer_does():
    values = np.random.default_rng(3).uniform(0.1, 0.9, 9)
    wavelengths = np.linspace(360.0, 830.0, 9)
    given = spectrum("irregular", values, wavelengths=wavelengths)
    found = read_bsdf(spectrum("regular", values), 'type="diffuse"')
    expected = read_bsdf(given, 'type="diffuse"')
    np.testing.assert_allclose(found.reflectance, expected.reflectance, rtol=1e-6)
    # As pairs: a tag of its own.
    pairs = ", ".join(f"{w:.9g}:{v:.9g}" for w, v in zip(wavelengths, values, strict=True))
    third = read_bsdf(f'<spectrum name="reflectance" value="{pairs}"/>', 'type="diffuse"')
    np.testing.assert_allclose(found.reflectance, third.reflectance, rtol=1e-6)
    red, _, blue = read_bsdf(
        spectrum("regular", np.linspace(0.1, 0.9, 9)), 'type="diffuse"'
    ).reflectance
    assert red > 2.0 * blue


@pytest.mark.parametrize("digits", ["ff8000", "0a7Fc3"])
def test_colours_of_six_digits_are_parts_of_255(digits):
    parts = np.array([int(digits[i : i + 2], 16) for i in (0, 2, 4)]) / 255.0
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    word = f'<srgb name="{{}}" value="#{digits}"/>'
    found = read_bsdf(word.format("reflectance"), 'type="diffuse"').reflectance
    np.testing.assert_allclose(found, linear, rtol=1e-6)


@pytest.mark.parametrize("specular", [0.0, 0.2, 0.5, 1.0])
def test_specular_is_the_reflection_straight_on_over_eight_per_cent(specular):
    words = f'<float name="specular" value="{specular}"/>'
    ior = read_bsdf(words, 'type="principled"').ior
    assert ((ior - 1.0) / (ior + 1.0)) ** 2 == pytest.approx(0.08 * specular)


def test_the_box_of_a_grid_is_moved_as_a_whole(tmp_path):
    rng = np.random.default_rng(6)
    low, high = -rng.uniform(0.5, 2.0, 3), rng.uniform(0.5, 2.0, 3)
    head = b"VOL" + struct.pack("<B5i6f", 3, 1, 2, 2, 2, 1, *low, *high)
    (tmp_path / "a.vol").write_bytes(head + np.ones(8, "<f4").tobytes())
    (first, a), (second, b) = step("rotate", rng), step("scale", rng)
    volume = (
        '<volume name="sigma_t" type="gridvolume"><string name="filename" value="a.vol"/>'
        '<boolean name="use_grid_bbox" value="true"/>'
        f'<transform name="to_world">{first}{second}</transform></volume>'
    )
    scene = read(
        '<integrator type="volpath"/><shape type="sphere">'
        f'<medium name="interior" type="heterogeneous">{volume}</medium></shape>',
        folder=tmp_path,
    )
    [node] = scene.nodes.values()
    medium = node.interior
    corners = np.array(np.meshgrid(*[[0.0, 1.0]] * 3)).reshape(3, -1)
    matrix = np.array(medium.matrix).reshape(3, 4)
    expected = (b @ a)[:3, :3] @ (low[:, None] + corners * (high - low)[:, None])
    np.testing.assert_allclose(matrix[:, :3] @ corners + matrix[:, 3:], expected, atol=1e-5)


#: Side of the cube -> where its picture's lower left corner lies, and to where u and v lead.
SIDES = {
    (0, -1, 0): ((-1, -1, -1), (0, 0, 1), (1, 0, 0)),
    (0, 1, 0): ((1, 1, 1), (-1, 0, 0), (0, 0, -1)),
    (1, 0, 0): ((1, -1, 1), (0, 1, 0), (0, 0, -1)),
    (0, 0, 1): ((-1, -1, 1), (0, 1, 0), (1, 0, 0)),
    (-1, 0, 0): ((-1, -1, -1), (0, 1, 0), (0, 0, 1)),
    (0, 0, -1): ((-1, 1, -1), (0, -1, 0), (1, 0, 0)),
}


def test_sides_of_a_cube_show_pictures_as_in_mitsuba():
    board = '<texture type="checkerboard" name="reflectance"/>'
    scene = read(f'<shape type="cube"><bsdf type="diffuse">{board}</bsdf></shape>')
    [shape] = flatten(scene).shapes
    mesh = shape.shape
    found = {}
    for face in mesh.faces.reshape(6, 6):
        own = np.unique(face)
        at = {
            tuple(uv): mesh.vertices[i] for i, uv in zip(own, mesh.uvs[own].tolist(), strict=True)
        }
        corner = at[0.0, 0.0]
        u, v = at[1.0, 0.0] - corner, at[0.0, 1.0] - corner
        normal = tuple(np.rint(mesh.vertices[own].mean(axis=0)).astype(int).tolist())
        found[normal] = tuple(tuple((x).astype(int).tolist()) for x in (corner, u / 2, v / 2))
        np.testing.assert_allclose(at[1.0, 1.0], corner + u + v)
    assert found == SIDES
    # From inside each side looks as a picture does from its front.
    for normal, (_, u, v) in SIDES.items():
        assert tuple(-np.cross(u, v)) == normal
