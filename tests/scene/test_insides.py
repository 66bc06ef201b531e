"""Bodies that scatter light: what else may be inside of them."""

import pytest

import alight
from alight.core.errors import SceneError
from alight.scene import flatten


@pytest.mark.parametrize("integrator", ["path", "volpath"])
@pytest.mark.parametrize("inside", [None, "vacuum", "fog"])
def test_nothing_else_is_inside_of_a_body(inside, integrator):
    body = {"type": "subsurface", "color": 0.5, "radius": 0.1}
    interior = {} if inside is None else {"interior": inside}
    scene = {
        "alight": 1, "camera": {"type": "pinhole"}, "integrator": {"type": integrator},
        "environment": {"type": "constant", "radiance": 1.0},
        "media": {"fog": {"type": "homogeneous", "sigma_t": 1.0}},
        "nodes": {"ball": {"shape": {"type": "sphere"}, "bsdf": body, **interior}},
    }  # fmt: skip
    said = {}
    try:
        assert flatten(alight.load(scene)).bsdfs
    except SceneError as error:
        said = {issue.path: issue.message for issue in error.issues}
    if inside != "fog":
        assert said == {}
    elif integrator == "volpath":
        assert "nothing else can be there" in said["nodes.ball.interior"]
