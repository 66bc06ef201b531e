"""Lights at the edges of their ranges, seen from themselves and from very far away."""

from __future__ import annotations

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.fields import LARGEST
from alight.core.registry import Models, modules, type_name_of
from alight.laws.lights import PLACE
from alight.laws.materials import stacked
from alight.lights.at_point import NEAREST
from alight.lights.ies import Ies
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.point import Point
from alight.lights.projector import Projector
from alight.lights.sampling import sample_light
from alight.lights.spot import Spot
from alight.scene import Node, Scene, flatten
from alight.scene.transform import rotate, translate
from alight.shapes.sphere import Sphere
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3
from tests.edges.specs import at_the_edges
from tests.edges.test_materials import directions

DISTANCES = (0.0, 1e-7, 1e-3, 1.0, 1e4, 1e9, 1e15)
UNIFORM = np.float32([0.0, 0.5, ONE_MINUS_EPSILON])
SHAPES = [e for m in modules("shapes") for e in m.EXAMPLES if e.finite]


def compiled(spec, shape=None):
    """A scene with this light, and a sphere far away."""
    turned = rotate("y", 40) @ rotate("x", 25)
    where = translate(*PLACE) @ turned if spec.placement != "environment" else turned
    nodes = {
        "light": Node(light=spec, shape=shape, transform=where),
        "far": Node(shape=Sphere(), transform=translate(0, 0, 1000)),
    }
    if spec.type_name() == "portal":
        nodes["sky"] = Node(light=Models("lights")["environment"].EXAMPLES[0])
    camera = Node(camera=Models("cameras")["pinhole"].EXAMPLES[0])
    return compile_scene(flatten(Scene(nodes=nodes, camera=camera)), structure="list")


def samples(scene, points):
    """(wi, distance, radiance, pdf) for each point (3, n) with each extreme of random numbers."""
    u = np.stack(np.meshgrid(UNIFORM, UNIFORM, UNIFORM)).reshape(3, -1)
    p = Vec3(*np.repeat(np.float32(points), u.shape[1], axis=1))
    u, n = np.tile(u, (1, points.shape[1])), points.shape[1] * u.shape[1]
    sample = instantiate(sample_light, scene.program, compiled=False)
    with np.errstate(all="ignore"):
        found = sample(scene.tables, p, p, u[0], (u[1], u[2]), np.ones(n, bool))
    distance, pdf = (np.broadcast_to(x, n) for x in (found.distance, found.pdf))
    return stacked(found.wi, n), distance, stacked(found.radiance, n), pdf


def places():
    """Points (3, n) around the light, at all distances."""
    around = [np.reshape(PLACE, (3, 1)) + distance * directions() for distance in DISTANCES]
    return np.concatenate(around, axis=1)


def check(scene):
    """Radiance and densities are finite and not negative, directions of unit length."""
    wi, distance, radiance, pdf = samples(scene, places())
    used = pdf > 0.0
    assert np.isfinite(pdf).all() and (pdf >= 0.0).all() and (distance >= 0.0).all()
    assert np.isfinite(radiance[:, used]).all() and (radiance[:, used] >= 0.0).all()
    length = np.sqrt((wi[:, used].astype(float) ** 2).sum(axis=0))
    assert np.abs(length - 1.0).max(initial=0.0) < 1e-5
    d, n = Vec3(*directions()), directions().shape[1]
    leaves = instantiate(environment_radiance, scene.program, compiled=False)
    density = instantiate(environment_pdf, scene.program, compiled=False)
    with np.errstate(all="ignore"):
        values = stacked(leaves(scene.tables, d), n), density(scene.tables, d, d)
    assert all(np.isfinite(x).all() and (np.asarray(x) >= 0.0).all() for x in values)


@pytest.mark.parametrize("model", modules("lights"), ids=type_name_of)
def test_light_is_finite_and_not_negative(model):
    for spec in dict.fromkeys([*at_the_edges(model.EXAMPLES[0]), *model.EXAMPLES]):
        check(compiled(spec, SHAPES[0] if spec.placement == "shape" else None))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.type_name())
def test_light_of_every_shape_is_finite_and_not_negative(shape):
    check(compiled(Models("lights")["area"].EXAMPLES[0], shape))


@pytest.mark.parametrize("model", [Point, Spot, Ies, Projector], ids=lambda m: m.type_name())
def test_no_light_arrives_at_the_light_itself(model):
    """There is no direction to it, and 1 / 0 times its colour would be no number."""
    spec = Models("lights")[model.type_name()].EXAMPLES[0]
    wi, _, radiance, _ = samples(compiled(spec), np.reshape(PLACE, (3, 1)))
    assert not radiance.any()
    np.testing.assert_allclose((wi**2).sum(axis=0), 1.0, rtol=1e-6)
    assert np.finfo(np.float32).max > LARGEST / NEAREST


DARK = {
    "no candela": Ies(vertical_angles=(0, 90), horizontal_angles=(0,), candela=((0, 0),)),
    "a beam between two steps of the grid": Ies(
        vertical_angles=(0.1, 0.2, 0.3), horizontal_angles=(0,), candela=((0, 9, 0),)
    ),
    "no factor": Ies(vertical_angles=(0, 90), horizontal_angles=(0,), candela=((1, 1),), scale=0),
    "black slide": Projector(pixels=((0.0, 0.0),)),
    "black spot": Spot(intensity=0.0),
    "black point": Point(intensity=0.0),
    "black sky": Models("lights")["environment"].EXAMPLES[0].replaced(pixels=((0.0, 0.0),)),
    "black surroundings": Models("lights")["constant"].EXAMPLES[0].replaced(radiance=0.0),
}


@pytest.mark.parametrize("spec", DARK.values(), ids=DARK)
def test_a_light_without_light_is_dark(spec):
    scene = compiled(spec)
    _, _, radiance, pdf = samples(scene, places())
    assert not radiance[:, pdf > 0.0].any()
    assert any("no light" in text for text in scene.warnings)
