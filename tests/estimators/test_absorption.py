"""Glass that absorbs: what comes through a body is Beer and Lambert's exponential."""

import numpy as np
import pytest
import yaml

from alight.bsdfs.dielectric import Dielectric
from alight.core.errors import SceneError
from alight.formats import loads
from tests.twin import picture_of

COLOR = [0.8, 0.5, 0.1]


def seen(bsdf):
    """The middle of a sphere of radius 1.5 under a white sky, seen from outside, in the twin."""
    scene = {
        "alight": 1,
        "camera": {
            "fov": 0.2,
            "transform": {"look_at": {"origin": [0, 0, 9], "target": [0, 0, 0]}},
        },
        "film": {"size": [4, 4]},
        "environment": {"type": "constant", "radiance": 1.0},
        "nodes": {"body": {"shape": {"type": "sphere", "radius": 1.5}, "bsdf": bsdf}},
    }
    return picture_of(loads(yaml.safe_dump(scene)), 16).mean((0, 1))


@pytest.mark.parametrize(
    "model",
    [
        {"type": "dielectric", "int_ior": 1.0, "ext_ior": 1.0},
        {"type": "principled", "base_color": 1.0, "transmission": 1.0, "ior": 1.0,
         "roughness": 0.0},
    ],
)  # fmt: skip
def test_light_through_a_body_falls_exponentially(model):
    glass = model | {"attenuation_color": COLOR, "attenuation_distance": 2.0}
    np.testing.assert_allclose(seen(glass), np.array(COLOR) ** 1.5, rtol=3e-3)


def test_infinite_distance_absorbs_nothing():
    glass = {"type": "dielectric", "int_ior": 1.0, "ext_ior": 1.0, "attenuation_color": COLOR}
    np.testing.assert_allclose(seen(glass), 1.0, rtol=1e-5)
    written = Dielectric(attenuation_color=COLOR, attenuation_distance=".inf")
    assert written.coefficients == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("distance", [0.0, -1.0, float("nan")])
def test_other_distances_are_refused(distance):
    with pytest.raises(SceneError, match="attenuation_distance"):
        Dielectric(attenuation_distance=distance)
