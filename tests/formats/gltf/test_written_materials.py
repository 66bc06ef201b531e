"""Materials of other models, written to glTF and read again."""

import json
import math

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.core.spec import Texture
from alight.films import fixed_point
from alight.formats import load, loads
from alight.formats.gltf.write import write
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten
from tests.formats.gltf.written import GREY, SQUARE, again


def test_a_metal_keeps_its_colour_and_roughness(tmp_path):
    bsdf = {"type": "rough_conductor", "eta": [0.2, 1.0, 3.0], "k": [4.0, 2.0, 0.0], "alpha": 0.25}
    found, _, lost = again(bsdf | {"specular_reflectance": [1.0, 0.5, 1.0]}, tmp_path)
    expected = [(0.64 + 16) / (1.44 + 16), 0.5 * 4 / 8, 4 / 16]
    assert found.base_color == pytest.approx(expected)
    assert (found.metallic, found.roughness) == (1.0, pytest.approx(0.5))
    assert "rough_conductor: Schlick's formula takes the place of its index of refraction" in lost
    tint = {"specular_reflectance": GREY | {"color_space": "srgb"}}
    found, _, _ = again({"type": "conductor", "metal": "gold", **tint}, tmp_path)
    assert found.roughness == 0.0
    assert found.base_color.type == "multiply"


def test_lacquered_metals_have_a_coat(tmp_path):
    """The metal has the colour that it has below the coat."""
    bsdf = {"type": "coated_conductor", "eta": [3.0] * 3, "k": [0.0] * 3, "int_ior": 1.5,
            "alpha": 0.25, "coat_alpha": 0.04, "thickness": 1.0}  # fmt: skip
    found, _, lost = again(bsdf, tmp_path)
    assert found.base_color == pytest.approx([1 / 9] * 3)
    assert (found.metallic, found.roughness) == (1.0, pytest.approx(0.5))
    assert (found.clearcoat, found.clearcoat_roughness) == (1.0, pytest.approx(0.2))
    assert "coated_conductor: the thickness of its coat" in lost


def test_bodies_keep_their_colour_and_coat(tmp_path):
    bsdf = {"type": "subsurface", "color": [0.9, 0.5, 0.25], "ior": 1.3, "roughness": 0.3}
    found, _, lost = again(bsdf, tmp_path)
    assert found.base_color == pytest.approx([0.9, 0.5, 0.25])
    assert (found.roughness, found.ior) == (pytest.approx(0.3), pytest.approx(1.3))
    assert "subsurface: no light is scattered below the surface, its colour is diffuse" in lost


@pytest.mark.parametrize(("along", "across"), [(0.64, 0.16), (0.16, 0.64)])
def test_brushed_metals_keep_both_roughnesses(along, across, tmp_path):
    bsdf = {"type": "rough_conductor", "alpha_u": along, "alpha_v": across}
    found, _, _ = again(bsdf, tmp_path)
    alpha, strength = found.roughness**2, found.anisotropy
    assert alpha == pytest.approx(0.16)
    assert alpha + (1.0 - alpha) * strength**2 == pytest.approx(0.64)
    assert found.anisotropy_rotation == pytest.approx(0.0 if along > across else math.pi / 2)


def picture(scene):
    """Mean radiance of a scene in even light of radiance 1, in the twin."""
    compiled = compile_scene(flatten(scene), structure="list")
    settings = make_settings(compiled.integrator, seed=1, replicates=1)
    kernels = make_kernels(compiled, compiled=False)
    ranges = np.array([[[0, 32]]], np.int64)
    film, _ = render_tile(kernels, compiled, settings, Tile(0, 0, 8, 8), ranges)
    fixed_point.carry(film.sums)
    return fixed_point.to_float(film.sums)[:, :, 0].mean(axis=(0, 1)) / 32


BODY = {"attenuation_color": [0.5, 0.25, 1.0], "attenuation_distance": 2.0}
ALIKE = {
    "conductor": {"type": "conductor", "metal": "copper"},
    "mirror": {"type": "mirror", "reflectance": [0.9, 0.6, 0.2]},
    "plastic": {"type": "plastic", "diffuse_reflectance": [0.6, 0.2, 0.1], "int_ior": 1.8},
    "glass": {"type": "dielectric", "int_ior": 1.4, **BODY},
    "pane": {"type": "thin_dielectric", "int_ior": 2.0, "specular_transmittance": [1, 0.5, 0.25]},
    "nothing": {"type": "null"},
}


@pytest.mark.parametrize("kind", ALIKE)
def test_smooth_materials_look_the_same_head_on(kind, tmp_path):
    """A plate, or a body of glass 1 m thick, in light that fades from above to below."""
    nodes = {"front": {"shape": SQUARE, "bsdf": ALIKE[kind]}}
    if kind == "glass":
        turn = [{"rotate": {"axis": "y", "angle": 180}}, {"translate": [0, 0, -1]}]
        nodes["back"] = {"shape": SQUARE, "bsdf": ALIKE[kind], "transform": turn}
    around = {"type": "environment", "pixels": [[1.0], [0.0]]}
    camera = {"type": "orthographic", "height": 0.1, "transform": {"translate": [0, 0, 3]}}
    # The plate lies on its back, and the camera looks down on it.
    down = {"rotate": {"axis": "x", "angle": -90}}
    camera["transform"] = [camera["transform"], down]
    nodes = {"all": {"children": nodes, "transform": down}}
    head = {"alight": 1, "camera": camera, "film": {"size": [8, 8]}, "nodes": nodes,
            "environment": around, "integrator": {"type": "path", "max_depth": 16}}  # fmt: skip
    first = loads(json.dumps(head), "scene.json")
    write(flatten(first), tmp_path / "a.glb")
    second = load(tmp_path / "a.glb")
    # glTF has no surroundings, and knows nothing of paths.
    second = second.replaced(environment=first.environment, integrator=first.integrator,
                             film=first.film)  # fmt: skip
    one, other = picture(first), picture(second)
    if kind != "nothing":
        assert one.max() > 0.03
    np.testing.assert_allclose(other, one, rtol=0.004, atol=2e-3)


@pytest.mark.parametrize("opacity", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("radiance", [[1.0, 2.0, 3.0], 0.5])
def test_what_shines_through_a_cut_surface_is_as_bright_again(opacity, radiance, tmp_path):
    """The file cuts out of the light what it cuts out of the surface."""
    mask = {"type": "mask", "opacity": opacity, "bsdf": {"type": "diffuse"}}
    light = {"type": "area", "radiance": radiance}
    _, flat, _ = again(mask, tmp_path, light)
    found = flat.shapes[0].light.radiance
    found = found.mean() if isinstance(found, Texture) else found
    np.testing.assert_allclose(np.broadcast_to(found, 3), np.broadcast_to(radiance, 3), rtol=1e-6)


def test_a_back_that_differs_is_told_to_be_lost(tmp_path):
    """The file says only that there is one."""
    diffuse = {"type": "diffuse"}
    _, _, lost = again({"type": "two_sided", "bsdf": diffuse}, tmp_path)
    assert lost == []
    _, _, lost = again({"type": "two_sided", "bsdf": diffuse, "back": {"type": "mirror"}}, tmp_path)
    assert lost == ["two_sided: the back looks like the front"]
