"""Light that passes strands: refused where light paths would meet it on another side."""

import pytest

import alight
from alight.scene.flatten import flatten

STRAND = {
    "type": "curves",
    "points": [[0, 0, 0], [0, 0.4, 0], [0, 0.7, 0], [0, 1, 0]],
    "radii": 0.1,
}


def flat(integrator, bsdf, **others):
    return flatten(alight.load({
        "camera": {}, "integrator": {"type": integrator}, "environment": {"type": "constant"},
        "nodes": {**others, "hair": {"shape": STRAND, "bsdf": {"type": bsdf}},
                  "ball": {"shape": "sphere", "bsdf": {"type": "dielectric"}}},
    }))  # fmt: skip


@pytest.mark.parametrize("integrator", ["bidirectional", "light"])
@pytest.mark.parametrize("bsdf", ["hair", "diffuse_transmission"])
def test_light_paths_refuse_it(integrator, bsdf):
    with pytest.raises(alight.SceneError, match=rf"strands.*\(hair: {bsdf}\): use path"):
        flat(integrator, bsdf)


def test_strands_are_looked_at_beyond_the_first():
    said = ""
    try:
        flat("light", "hair", wire={"shape": STRAND, "bsdf": {"type": "diffuse"}})
    except alight.SceneError as error:
        said = str(error)
    assert "hair: hair" in said


@pytest.mark.parametrize(("integrator", "bsdf"), [("path", "hair"), ("bidirectional", "diffuse")])
def test_others_do_not(integrator, bsdf):
    assert flat(integrator, bsdf).shapes
