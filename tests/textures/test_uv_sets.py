"""Meshes with several sets of texture coordinates: each texture is looked up in the set it names.

Pictures are rendered in the NumPy twin. They are compared with scenes that know one set only: with
the coordinates of another set in the place of the mesh's own, or with the same map as `to_uv`.
"""

import json

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.core.errors import SceneError
from alight.core.uv_sets import NO_SET, UV_SETS
from alight.films import fixed_point
from alight.formats import load, loads, save
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten
from alight.shapes.mesh import Mesh

SIDE, CELLS = 8, 6
RNG = np.random.default_rng(5)
#: Corners of a grid of 72 triangles in the unit square: more than are stored one by one as copies.
GRID = np.stack(np.meshgrid(*2 * [np.linspace(0.0, 1.0, CELLS + 1)]), -1).reshape(-1, 2)
#: Coordinates that no map of the others gives: each triangle has a map of its own.
FIRST = (GRID + RNG.uniform(-0.05, 0.05, GRID.shape)).round(4)
SECOND = (GRID[:, ::-1] * [1.7, -0.8] + RNG.uniform(-0.05, 0.05, GRID.shape)).round(4)
COLOURS = {"type": "bitmap", "pixels": RNG.uniform(0.1, 0.9, (5, 4, 3)).round(3).tolist()}
GREYS = {"type": "bitmap", "pixels": RNG.uniform(0.2, 0.9, (4, 6)).round(3).tolist()}
SLOPES = {"type": "bitmap", "pixels": RNG.uniform(0.25, 0.75, (4, 4, 3)).round(3).tolist()}


def grid(*sets):
    """The grid with these sets of coordinates."""
    a = np.arange(CELLS)[:, None] * (CELLS + 1) + np.arange(CELLS)
    quads = np.stack([a, a + 1, a + CELLS + 2, a + CELLS + 1], -1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    # Not flat: its own directions of u and v differ from triangle to triangle.
    height = 0.03 * np.sin(9.0 * GRID.sum(axis=1, keepdims=True))
    mesh = {"type": "mesh", "faces": faces.tolist(), "uvs": sets[0].tolist()}
    mesh["vertices"] = np.column_stack([2.0 * GRID - 1.0, height]).round(5).tolist()
    return mesh | ({"more_uvs": [table.tolist() for table in sets[1:]]} if sets[1:] else {})


def described(shape, bsdf, light=None, *, copies=False, moves=False, sun=False):
    """A scene with one shape before the camera, in light that differs from side to side.

    With the sun alone nothing is random but where in its pixel a ray passes: the frame in which
    directions are chosen does not matter.
    """
    part = {"shape": shape, "bsdf": bsdf} | ({"light": light} if light else {})
    if moves:
        near, far = {"translate": [0, 0, 0]}, {"translate": [0.2, 0, 0]}
        part["transform"] = {"keyframes": [{"time": 0, **near}, {"time": 1, **far}]}
    nodes = {"it": part}
    prototypes = {}
    if copies:
        prototypes = {"it": {"children": {"it": part}}}
        shifts = ([0, 0, 0], [9, 0, 0])
        nodes = {f"n{i}": {"instance": "it", "transform": {"translate": t}}
                 for i, t in enumerate(shifts)}  # fmt: skip
    # A mesh before it, so that no row of the tables is the first.
    other = grid(GRID, FIRST, FIRST)
    nodes = {"other": {"shape": other, "transform": {"translate": [0, 30, 0]}}, **nodes}
    camera = {"type": "orthographic", "height": 2, "transform": {"translate": [0, 0, 3]}}
    if moves:
        camera["shutter"] = [0.0, 1.0]
    world = {"type": "environment", "pixels": [[2.0, 0.5], [0.25, 1.0], [0.1, 0.1]]}
    if sun:
        nodes["sun"] = {
            "light": {"type": "directional", "irradiance": 2},
            "transform": {"rotate": {"axis": [1, -1, 0], "angle": 150}},
        }
    return {
        "alight": 1,
        "camera": camera,
        **({} if sun else {"environment": world}),
        # Light is met by chance only: how many lamps there are changes no random number.
        "integrator": {"type": "path", "max_depth": 2, "light_sampling": "bsdf"},
        "sampler": "independent",
        "film": {"size": [SIDE, SIDE]},
        "prototypes": prototypes,
        "nodes": nodes,
    }


def scene_of(*arguments, **options):
    """The same, loaded."""
    return loads(json.dumps(described(*arguments, **options)), "scene.json")


def picture(scene, spp=4):
    """Means of all pixels, in the twin."""
    compiled = compile_scene(flatten(scene), structure="list")
    settings = make_settings(compiled.integrator, seed=1, replicates=1)
    ranges = np.tile(np.array([[[0, spp]]], np.int64), ((SIDE // 8) ** 2, 1, 1))
    kernels = make_kernels(compiled, compiled=False)
    film, _ = render_tile(kernels, compiled, settings, Tile(0, 0, SIDE, SIDE), ranges)
    fixed_point.carry(film.sums)
    assert film.invalid == 0
    return fixed_point.to_float(film.sums)[:, :, 0] / spp


def diffuse(texture):
    return {"type": "diffuse", "reflectance": texture}


# ---------------------------------------------------------------- looking up


def test_colour_from_one_set_and_emission_from_another():
    """Light is a sum: of what is reflected by the first set and what shines by the third."""
    light = {"type": "area", "radiance": COLOURS}
    shining = {"type": "area", "radiance": COLOURS | {"uv_set": 2}}
    # Flat: it does not light itself.
    flat = {"vertices": np.pad(2.0 * GRID - 1.0, ((0, 0), (0, 1))).tolist()}
    both = picture(scene_of(grid(FIRST, GRID, SECOND) | flat, diffuse(GREYS), shining))
    reflected = picture(scene_of(grid(FIRST) | flat, diffuse(GREYS)))
    emitted = picture(scene_of(grid(SECOND) | flat, diffuse(0.0), light))
    assert np.ptp(emitted) > 0.3
    np.testing.assert_allclose(both, reflected + emitted, atol=2e-6)


@pytest.mark.parametrize("how", ["once", "copies", "moves"])
def test_a_mix_of_two_sets(how):
    """On a mesh in the world, on one that several instances share, and on one that moves."""
    options = {} if how == "once" else {how: True}
    mixed = {"type": "mix", "a": GREYS, "b": COLOURS | {"uv_set": 1}, "weight": 0.25}
    both = picture(scene_of(grid(FIRST, SECOND), diffuse(mixed), **options))
    a = picture(scene_of(grid(FIRST), diffuse(GREYS), **options))
    b = picture(scene_of(grid(SECOND), diffuse(COLOURS), **options))
    np.testing.assert_allclose(both, 0.75 * a + 0.25 * b, atol=2e-6)


@pytest.mark.parametrize(
    "texture",
    [
        COLOURS,
        {"type": "checkerboard", "color1": 0.9, "scale": 5},
        {"type": "noise", "space": "uv", "scale": 3, "octaves": 2},
    ],
)
def test_every_texture_with_coordinates_has_sets(texture):  # fmt: skip
    found = picture(scene_of(grid(FIRST, SECOND), diffuse(texture | {"uv_set": 1})), 1)
    expected = picture(scene_of(grid(SECOND), diffuse(texture)), 1)
    np.testing.assert_array_equal(found, expected)


def test_roughness_and_colour_of_two_sets_are_one_set_and_a_map():
    """The second set swaps u and v: the same as `to_uv` on the first, to the last bit."""

    def surface(roughness):
        return {
            "type": "principled",
            "base_color": COLOURS,
            "metallic": 0.7,
            "roughness": {"type": "channel", "texture": roughness, "channel": "g"},
        }

    swapped = GREYS | {"to_uv": {"matrix": [[0, 1, 0], [1, 0, 0]]}}
    found = picture(scene_of(grid(FIRST, FIRST[:, ::-1]), surface(GREYS | {"uv_set": 1})))
    expected = picture(scene_of(grid(FIRST), surface(swapped)))
    plain = picture(scene_of(grid(FIRST), surface(GREYS)))
    assert np.abs(plain - expected).max() > 0.02
    np.testing.assert_array_equal(found, expected)


# ---------------------------------------------------------------- bent normals


@pytest.mark.parametrize("how", ["once", "copies", "moves"])
def test_a_normal_map_turns_with_its_set(how):
    """As on a mesh whose own coordinates it uses, mirrored ones too (the second set is)."""
    options = {"sun": True} | ({} if how == "once" else {how: True})
    bent = {"type": "normal_map", "texture": SLOPES, "scale": 1.5, "bsdf": diffuse(0.8)}
    other = bent | {"texture": SLOPES | {"uv_set": 1}}
    found = picture(scene_of(grid(FIRST, SECOND), other, **options))
    expected = picture(scene_of(grid(SECOND), bent, **options))
    unturned = picture(scene_of(grid(FIRST), bent, **options))
    assert np.abs(unturned - expected).max() > 0.02
    np.testing.assert_allclose(found, expected, atol=2e-6)


def test_a_bump_map_rises_with_its_set():
    """Heights are linear in the coordinates here, so that steps of any length give their slope."""
    ramp = {"type": "bitmap", "pixels": [[0.0, 1.0]], "wrap": "clamp"}
    inside = {"to_uv": [{"scale": 0.15}, {"translate": [0.4, 0.5]}]}
    bumps = {"type": "bump_map", "texture": ramp | inside, "scale": 0.5, "bsdf": diffuse(0.8)}
    other = bumps | {"texture": ramp | inside | {"uv_set": 1}}
    found = picture(scene_of(grid(FIRST, SECOND), other, sun=True))
    expected = picture(scene_of(grid(SECOND), bumps, sun=True))
    unturned = picture(scene_of(grid(FIRST), bumps, sun=True))
    assert np.abs(unturned - expected).max() > 0.02
    # Differences of heights 2^-13 apart have four digits.
    np.testing.assert_allclose(found.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), rtol=2e-4)
    assert np.abs(found - expected).mean() < 1e-3


@pytest.mark.parametrize(
    ("relief", "texture", "colour"),
    [
        ({"type": "normal_map"}, SLOPES, {"type": "noise", "space": "uv", "scale": 3}),
        ({"type": "bump_map", "scale": 0.1}, GREYS, COLOURS),
    ],
    ids=["normals", "heights"],
)
def test_machine_code_agrees(relief, texture, colour):
    """Normals, or heights, from one set and colours from another, with copies."""
    bsdf = diffuse(colour | {"uv_set": 1})
    bent = relief | {"texture": texture | {"uv_set": 2}, "bsdf": bsdf}
    scene = scene_of(grid(FIRST, SECOND, GRID), bent, copies=True, sun=True)
    film = alight.render(scene, spp=4, seed=1, threads=1, replicates=1)
    # Along edges a ray may meet the one triangle or the other.
    difference = np.abs(film.mean - picture(scene))
    assert (difference > 1e-3).mean() < 0.02
    assert np.median(difference) < 1e-5


# ---------------------------------------------------------------- without the set


@pytest.mark.parametrize(
    "shape",
    [grid(FIRST), {"type": "sphere"},
     {"type": "mesh", "vertices": [[-1, -1, 0], [1, -1, 0], [0, 1, 0]], "faces": [[0, 1, 2]]}],
    ids=["own", "formula", "barycentric"],
)  # fmt: skip
def test_where_a_shape_lacks_the_set_its_own_is_taken(shape):
    found = picture(scene_of(shape, diffuse(COLOURS | {"uv_set": 3})), 1)
    np.testing.assert_array_equal(found, picture(scene_of(shape, diffuse(COLOURS)), 1))


def test_scenes_without_a_further_set_know_of_none():
    """Their program is what it was, and sets that nothing uses take no memory."""
    scene = compile_scene(flatten(scene_of(grid(FIRST, SECOND), diffuse(COLOURS))))
    assert UV_SETS not in scene.program.textures
    tables = scene.tables.shapes
    assert tables.uvs.size == 2 * 2 * len(GRID)
    assert tables.uv_shifts.size == 1
    with_sets = scene_of(grid(FIRST, SECOND), diffuse(COLOURS | {"uv_set": 1}))
    tables = compile_scene(flatten(with_sets)).tables.shapes
    assert tables.uvs.size == 2 * (2 + 3) * len(GRID)
    n = len(GRID)
    expected = [[0, 2 * n, 3 * n], [0, 4 * n - n, NO_SET]]
    assert tables.uv_shifts.shaped[:, :3].tolist() == expected
    assert (tables.uv_shifts.shaped[:, 3:] == NO_SET).all()


# ---------------------------------------------------------------- files


def test_sets_survive_saving(tmp_path):
    """Written out in the scene, and in a PLY file beside it."""
    scene = scene_of(grid(FIRST, GRID, SECOND), diffuse(COLOURS | {"uv_set": 2}))
    save(scene, tmp_path / "small.yaml")
    assert load(tmp_path / "small.yaml").nodes["it"].shape == scene.nodes["it"].shape
    mesh = scene.nodes["it"].shape
    assert isinstance(mesh, Mesh)
    twice = np.repeat(mesh.faces, 1, axis=0)
    many = {name: np.concatenate([getattr(mesh, name)] * 3) for name in ("vertices", "uvs")}
    sets = np.concatenate([mesh.more_uvs] * 3, axis=1)
    large = scene.nodes["it"].replaced(shape=Mesh(**many, faces=twice, more_uvs=sets))
    scene = scene.replaced(nodes={**scene.nodes, "it": large})
    save(scene, tmp_path / "large.yaml")
    again = load(tmp_path / "large.yaml")
    assert again.nodes["it"].shape.file
    a, b = (flatten(s).geometries[-1] for s in (scene, again))
    np.testing.assert_array_equal(b.more_uvs, sets)
    assert a.digest == b.digest
    # Meshes that differ in them alone are two.
    other = large.replaced(shape=large.shape.replaced(more_uvs=sets[::-1]))
    c = flatten(scene.replaced(nodes={**scene.nodes, "it": other})).geometries[-1]
    assert c.digest != a.digest


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"more_uvs": [[[0, 0], [1, 0]]]},
         "more_uvs[0]\n  must have one row per vertex (3), got 2"),
        ({"more_uvs": [[0, 0], [1, 0], [0, 1]]},
         "more_uvs\n  must be tables of numbers of equal length, shape (k, n, 2), got shape (3"),
        ({"more_uvs": [[[0, 0], [1, 0], [0, float("1e30")]]]},
         "more_uvs\n  must be finite and at most 1e+15 in size, got 1e+30 in row 2"),
        ({"more_uvs": [[[0, 0], [1, 0], [0, 1]]] * 8}, "more_uvs\n  must be 1 to 7 tables, got 8"),
        ({"uvs": None, "more_uvs": [[[0, 0], [1, 0], [0, 1]]]},
         "more_uvs\n  need uvs, the set 0, beside them"),
    ],
)  # fmt: skip
def test_what_is_no_set_is_refused(changes, message):
    mesh = {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]],
            "uvs": [[0, 0], [1, 0], [0, 1]]}  # fmt: skip
    with pytest.raises(SceneError) as caught:
        scene_of({k: v for k, v in (mesh | changes).items() if v is not None}, diffuse(0.5))
    assert message in str(caught.value)


@pytest.mark.parametrize("number", [8, -1, 0.5])
def test_sets_are_numbered_from_0_to_7(number):
    with pytest.raises(SceneError, match="uv_set"):
        scene_of(grid(FIRST), diffuse(COLOURS | {"uv_set": number}))
