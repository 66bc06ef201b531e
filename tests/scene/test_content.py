"""What decides the picture: each number of a scene has a part in its hash, and in its place."""

import copy

import numpy as np
import pytest

import alight
from alight.scene import content_hash, flatten
from alight.scene.content import differences

#: One of everything that a hash may leave out: lights on shapes, inside prototypes, at points and
#: around the scene, media, motion, meshes with all arrays, displacement, textures within textures.
SCENE = {
    "alight": 1,
    "film": {"size": [8, 6], "crop": [1, 1, 5, 4], "filter": {"type": "gaussian", "radius": 1.5}},
    "integrator": {"type": "volpath", "max_depth": 5},
    "sampler": {"type": "stratified", "strata": 3},
    "camera": {
        "type": "thin_lens", "fov": 40.0, "aperture_radius": 0.1, "focus_distance": 3.0,
        "medium": "haze", "shutter": [0.25, 0.75],
        "transform": {"look_at": {"origin": [0.5, 1.0, 4.0], "target": [0.1, 0.2, 0.3]}},
    },
    "medium": "fog",
    "environment": {"type": "constant", "radiance": [0.2, 0.3, 0.4]},
    "media": {
        "fog": {"type": "homogeneous", "sigma_t": 0.5, "albedo": [0.5, 0.6, 0.7]},
        "haze": {"type": "homogeneous", "sigma_t": 0.25, "albedo": 0.3},
        "smoke": {"type": "homogeneous", "sigma_a": 0.125, "sigma_s": 0.5},
    },
    "textures": {
        "board": {"type": "checkerboard", "color0": [0.1, 0.2, 0.3], "color1": 0.7, "scale": 3.0},
        "more": {"type": "multiply", "a": "board", "b": [0.5, 0.6, 0.7]},
    },
    "bsdfs": {
        "painted": {"type": "diffuse", "reflectance": "more"},
        "mixed": {
            "type": "blend", "weight": 0.4,
            "bsdfs": ["painted", {"type": "rough_conductor", "alpha": 0.3}],
        },
    },
    "prototypes": {
        "lamp": {
            "children": {
                "bulb": {
                    "shape": {"type": "sphere", "radius": 0.125},
                    "light": {"type": "area", "radiance": [3.0, 2.0, 1.0]},
                },
                "spot": {"light": {"type": "spot", "intensity": 2.0, "cutoff_angle": 25.0}},
            }
        }
    },
    "nodes": {
        "ball": {
            "shape": {"type": "sphere", "center": [0.1, 0.2, 0.3], "radius": 0.75},
            "bsdf": {"type": "dielectric", "int_ior": 1.4},
            "interior": "smoke",
        },
        "sheet": {
            "shape": {
                "type": "mesh",
                "vertices": [[0, 0, 0], [1, 0, 0.25], [0, 1, 0.5]],
                "faces": [[0, 1, 2]],
                "uvs": [[0, 0], [1, 0.1], [0.2, 1]],
                "normals": [[0, 0.1, 1], [0.1, 0, 1], [0, 0, 1]],
                "colors": [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6], [0.7, 0.8, 0.9]],
                "displacement": "board", "displacement_scale": 0.05, "displacement_edge": 0.5,
            },
            "bsdf": "mixed",
            "light": {"type": "area", "radiance": [0.5, 0.6, 0.7]},
            "transform": {
                "keyframes": [
                    {"time": 0.0, "steps": [{"translate": [0.1, 0.2, 0.3]}]},
                    {"time": 1.0, "steps": [{"translate": [0.4, 0.5, 0.6]}]},
                ]
            },
        },
        "group": {
            "bsdf": {"type": "diffuse", "reflectance": 0.25},
            "instance": "lamp",
            "transform": [{"scale": 1.5}, {"translate": [1.0, 2.0, 3.0]}],
            "children": {"own": {"shape": {"type": "disk"}}, "point": {
                "light": {"type": "point", "intensity": [1.0, 2.0, 3.0]}}},
        },
    },
}  # fmt: skip


def leaves(value, path=()):
    """Paths of all numbers that are no indices."""
    if isinstance(value, dict):
        for key, item in value.items():
            if key not in ("alight", "faces"):
                yield from leaves(item, (*path, key))
    elif isinstance(value, list):
        for number, item in enumerate(value):
            yield from leaves(item, (*path, number))
    elif isinstance(value, int | float):
        yield path


def with_another(path):
    """The scene with one number changed a little."""
    scene = copy.deepcopy(SCENE)
    *upper, last = path
    place = scene
    for key in upper:
        place = place[key]
    place[last] = place[last] + (1 if path[0] in ("film", "sampler", "integrator") else 0.01)
    return scene


def test_each_number_has_a_part_in_the_hash():
    """Also the 0 of a coordinate, and the times of a shutter where something moves."""
    plain = content_hash(alight.load(SCENE))
    paths = list(leaves(SCENE))
    assert len(paths) > 100
    same = [path for path in paths if content_hash(alight.load(with_another(path))) == plain]
    assert same == []


@pytest.mark.parametrize(
    ("key", "value"),
    [("medium", "smoke"), ("environment", None), ("prototypes", None)],
)
def test_what_stands_in_for_what_plays_a_part(key, value):
    scene = copy.deepcopy(SCENE)
    if key == "prototypes":
        del scene["nodes"]["group"]["instance"]
    elif value is None:
        del scene[key]
    else:
        scene[key] = value
    assert content_hash(alight.load(scene)) != content_hash(alight.load(SCENE))


def test_things_stand_in_the_order_of_the_graph_and_are_called_by_their_materials():
    """What a node instances comes before its children; materials without a name have their node's.

    Cryptomattes have these names, whoever inherits the material.
    """
    flat = flatten(alight.load(SCENE))
    assert [(shape.name, shape.material) for shape in flat.shapes] == [
        ("ball", "ball"), ("sheet", "mixed"), ("group/lamp/bulb", "group"), ("group/own", "group"),
    ]  # fmt: skip
    assert [light.name for light in flat.lights] == ["group/lamp/spot", "group/point"]
    np.testing.assert_allclose(flat.shapes[2].to_world[:3, 3], [1.0, 2.0, 3.0])


@pytest.mark.parametrize("around", [None, "fog", "vacuum"])
@pytest.mark.parametrize("of_camera", [None, "haze", "vacuum"])
@pytest.mark.parametrize("outside", [None, "smoke", "vacuum"])
def test_media_are_those_that_are_said_or_those_around(around, of_camera, outside):
    """The camera's own before that of the scene, and a shape's own outside before it."""
    scene = copy.deepcopy(SCENE)
    for place, key, value in (
        (scene, "medium", around),
        (scene["camera"], "medium", of_camera),
        (scene["nodes"]["ball"], "exterior", outside),
    ):
        place.pop(key, None)
        if value is not None:
            place[key] = value
    flat = flatten(alight.load(scene))

    def named(number):
        sigma = {0.5: "fog", 0.25: "haze", 0.625: "smoke"}
        if number == 0:
            return "vacuum"
        fields = dict(flat.media[number - 1])
        total = fields["sigma_t"]
        total = np.add(fields["sigma_a"], fields["sigma_s"]) if total is None else total
        return sigma[float(np.ravel(total)[0])]

    assert named(flat.start_medium) == (of_camera or around or "vacuum")
    inside, outer = flat.shapes[0].border
    assert (named(inside), named(outer)) == ("smoke", outside or around or "vacuum")


@pytest.mark.parametrize(
    ("key", "gone", "new", "other"),
    [
        ("film.size", "is gone (was 1)", "is new (1)", "was 1, is 2"),
        ("file a.exr", "is gone", "is new", "its content has changed"),
        ("registered bsdf a", "is gone", "is new", "its content has changed"),
    ],
)
def test_a_difference_says_what_was_and_what_is(key, gone, new, other):
    """Read backwards it says the opposite, and what is the same is not said."""
    same, one = {"same": "3"}, {key: "1"}
    assert differences(same | one, same) == [f"{key}: {gone}"]
    assert differences(same, same | one) == [f"{key}: {new}"]
    assert differences(one | same, {key: "2"} | same) == [f"{key}: {other}"]
    assert differences({"b": "1"} | one, {"c": "1"} | one) == [
        "b: is gone (was 1)", "c: is new (1)",
    ]  # fmt: skip
