"""Bodies that will not look as they should are told, and what displaces nothing is refused."""

import numpy as np
import pytest

import alight
from alight.compiled.boxes import box_of
from alight.compiled.scene import compile_scene
from alight.compiled.warnings import edges
from alight.scene.flatten import flatten

CUBE = {
    "type": "mesh",
    "vertices": [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)],
    "faces": [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ],
}  # fmt: skip
INSIDE_OUT = {**CUBE, "faces": [face[::-1] for face in CUBE["faces"]]}


def loaded(shape, **keys):
    """A scene with one body."""
    body = {"shape": shape, "bsdf": {"type": "subsurface"}, **keys.pop("node", {})}
    nodes = {"body": body, **keys.pop("others", {})}
    surroundings = {"type": "constant", "radiance": 1}
    return alight.load(
        {"alight": 1, "camera": {}, "environment": surroundings, "nodes": nodes, **keys}
    )


def warnings_of(shape, **keys):
    return compile_scene(flatten(loaded(shape, **keys)), structure="list").warnings


@pytest.mark.parametrize(
    ("shape", "advice"),
    [
        (CUBE, None),
        (INSIDE_OUT, "give its shape flip_normals: true"),
        ({**INSIDE_OUT, "flip_normals": True}, None),
        ({**CUBE, "flip_normals": True}, "leave out flip_normals"),
        ({**INSIDE_OUT, "faces": INSIDE_OUT["faces"][1:]}, None),
        ("sphere", None),
        ({"type": "sphere", "flip_normals": True}, "leave out flip_normals"),
        ({"type": "cube", "flip_normals": True}, "leave out flip_normals"),
        ("cube", None),
        ({"type": "rectangle", "flip_normals": True}, None),
    ],
)
def test_bodies_that_are_inside_out_are_told(shape, advice):
    """A mirror turns nothing inside out; what is open has no inside."""
    for scale in (1, [1, 1, -2]):
        told = warnings_of(shape, node={"transform": [{"scale": scale}]})
        found = tuple(text for text in told if "no end" not in text)
        if advice is None:
            assert found == ()
        else:
            assert len(found) == 1
            assert found[0].startswith("body: a body whose normals point inwards is black")
            assert found[0].endswith(advice)


#: A tube that is turned, and its lids: smaller than its ends as numbers of float32 are.
TILT = [{"scale": [0.3, 0.3, 2]}, {"rotate": {"axis": "x", "angle": 33}}, {"translate": [1, 2, 3]}]
LIDS = {
    "top": {"shape": "disk", "transform": [{"translate": [0, 0, 1]}, *TILT]},
    "bottom": {"shape": {"type": "disk", "flip_normals": True}, "transform": TILT},
}
UPRIGHT = {"cap": {"shape": "disk", "transform": {"translate": [0, 0, 1]}}}


@pytest.mark.parametrize(
    ("shape", "transform", "others", "told"),
    [
        ("cylinder", TILT, {}, True),
        ("cylinder", TILT, {"top": LIDS["top"]}, True),
        ("cylinder", TILT, LIDS, False),
        ("cylinder", [], {"floor": {"shape": "plane"}}, True),
        ("cylinder", [], {"floor": {"shape": "plane"}, **UPRIGHT}, False),
        ("rectangle", TILT, {}, True),
        ("disk", TILT, {}, True),
        ({**CUBE, "faces": CUBE["faces"][1:]}, TILT, {}, True),
        (CUBE, TILT, {}, False),
        ("sphere", TILT, {}, False),
    ],
)
def test_bodies_without_an_end_are_told_unless_something_may_close_them(
    shape, transform, others, told
):
    found = warnings_of(shape, node={"transform": transform}, others=others)
    assert [text[:6] for text in found if "close the shape" in text] == ["body: "] * told


def test_many_bodies_without_an_end_are_told_in_one_line():
    leaf = {"shape": "disk", "bsdf": {"type": "subsurface"}}
    others = {f"leaf{n}": {**leaf, "transform": {"translate": [9 * n, 0, 0]}} for n in (1, 2)}
    (found,) = warnings_of("disk", others=others)
    assert found.startswith("body (and 2 more): ")


def test_of_many_open_shapes_some_are_asked(monkeypatch):
    """Each is held against all others, so a field of leaves took the square of their number."""
    monkeypatch.setattr(edges, "MOST_SHAPES", 2)
    leaf = {"shape": "disk", "bsdf": {"type": "subsurface"}}
    others = {f"leaf{n}": {**leaf, "transform": {"translate": [9 * n, 0, 0]}} for n in range(1, 5)}
    (found,) = warnings_of("disk", others=others)
    assert found.startswith("body (and 1 more): ")


def test_seams_of_a_closed_mesh_are_no_openings():
    """Exporters split vertices where normals or texture coordinates jump."""
    split = [CUBE["vertices"][corner] for face in CUBE["faces"] for corner in face]
    faces = np.arange(len(split)).reshape(-1, 3).tolist()
    assert warnings_of({**CUBE, "vertices": split, "faces": faces}) == ()


@pytest.mark.parametrize(
    ("half", "x", "told"), [(2.0, 0, True), (0.4, 0, False), (2.0, 3.5, False), (2.0, -3.5, False)]
)
def test_bodies_in_fog_that_does_not_end_at_them_are_told(half, x, told):
    fog = {"type": "homogeneous", "sigma_t": 0.1, "albedo": 0.5}
    cloud = {
        "shape": {"type": "sphere", "radius": half * 2},
        "bsdf": {"type": "null"},
        "interior": fog,
        "transform": [{"translate": [x, 0, 0]}],
    }
    keys = {"others": {"cloud": cloud}, "integrator": {"type": "volpath"}}
    assert len(warnings_of("cube", **keys)) == told
    found = warnings_of("sphere", **keys)
    assert len(found) == told
    assert all("give it the interior of cloud as exterior" in text for text in found)
    assert warnings_of("sphere", node={"exterior": fog}, **keys) == ()


@pytest.mark.parametrize("key", ["scale", "midlevel", "edge"])
def test_what_displaces_nothing_is_refused(key):
    with pytest.raises(alight.SceneError, match=f"displacement_{key} does nothing"):
        loaded({**CUBE, f"displacement_{key}": 0.5}, node={"bsdf": {"type": "diffuse"}})
    loaded({**CUBE, "displacement": 0.1, f"displacement_{key}": 0.5})


@pytest.mark.parametrize("shape", [CUBE, "cube", "sphere"], ids=["mesh", "cube", "ball"])
def test_the_box_around_a_shape_is_where_it_was_put(shape):
    node = {"transform": [{"scale": [1, 2, 3]}, {"translate": [5, -7, 9]}]}
    flat = flatten(loaded(shape, node=node))
    low, high = box_of(flat, flat.shapes[0])
    np.testing.assert_allclose([low, high], [[4, -9, 6], [6, -5, 12]], atol=1e-4)
