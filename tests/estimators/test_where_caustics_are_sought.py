"""Chains are followed where a material has a mirror's or clear glass's lobe, and a lamp a shape."""

import numpy as np
import pytest

from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.specular import EVENT_BITS, EVENT_MASK
from alight.compiled.casters import is_caster
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.integrators.caustics import manifold_sampling
from alight.integrators.caustics.chain_types import (
    MOST_EVENTS,
    Type,
    follows_chains,
    with_event,
)
from alight.laws.materials import Material, direction, random_numbers
from alight.scene import flatten
from lanewise.jit import kernel
from tests.sampling.materials import EXAMPLES, NAMES
from tests.twin import picture_of

SCENE = """
alight: 1
integrator: {type: path, max_depth: 6, caustics: %s}
camera: {fov: 50, transform: {look_at: {origin: [3, 0, 2], target: [0, 0, -0.5]}}}
film: {size: [8, 8]}
nodes:
  floor: {shape: rectangle, transform: [{scale: 2}, {translate: [0, 0, -1]}]}
  ball: {shape: {type: sphere, radius: 0.5}, bsdf: {type: %s}}
  lamp: {%s, transform: {translate: [0, 0, 2]}}
"""
SHINING = "shape: {type: sphere, radius: 0.3}, light: {type: area, radiance: 5}"
BULB = "light: {type: point, intensity: 5}"
SKY = "light: {type: constant, radiance: 5}"


def scene(caustics="manifold", bsdf="dielectric", lamp=SHINING):
    return loads(SCENE % (caustics, bsdf, lamp))


def program_of(*arguments):
    return compile_scene(flatten(scene(*arguments)), structure="list").program


def mirrors(material):
    """Whether some sample goes in one of finitely many directions, and not straight on."""
    found = False
    for cosine in (0.7, -0.7):
        _, _, pdf, flags = material.sample(direction(cosine), random_numbers(256, 7))
        found |= bool(((flags & (DELTA | NULL)) == DELTA)[pdf > 0.0].any())
    return found


def test_chains_are_followed_where_a_material_mirrors():
    lamp, found = program_of("manifold", "diffuse"), set()
    assert not follows_chains(lamp)
    for spec, name in zip(EXAMPLES, NAMES, strict=True):
        material = Material(spec)
        program = lamp._replace(bsdfs=material.program.bsdfs, textures=material.program.textures)
        turns = mirrors(material)
        assert follows_chains(program) or not turns, name
        # Paths are sent towards such; a lacquer without a reflectance sends nothing on.
        assert is_caster(spec) == turns or spec.specular_reflectance == (0, 0, 0), name
        found.add(turns)
    assert found == {False, True}


@pytest.mark.parametrize("lamp", [BULB, SHINING], ids=["a bulb", "a ball"])
def test_chains_lead_to_lamps(lamp):
    assert follows_chains(program_of("manifold", "dielectric", lamp))


def test_no_chain_leads_to_a_sky_without_a_sun():
    assert not follows_chains(program_of("manifold", "dielectric", SKY))


@pytest.mark.parametrize("lamp", [BULB, SHINING], ids=["a bulb", "a ball"])
def test_where_there_are_none_pictures_keep_their_bits(lamp):
    assert not follows_chains(program_of("manifold", "diffuse", lamp))
    assert not follows_chains(program_of("paths"))
    with_, without = (picture_of(scene(way, "diffuse", lamp), 2) for way in ("manifold", "paths"))
    np.testing.assert_array_equal(with_, without)


def test_the_events_of_the_longest_chain_have_bits_of_their_own():
    rng = np.random.default_rng(4)
    kinds = rng.integers(1, EVENT_MASK + 1, MOST_EVENTS).astype(np.uint32)
    type_ = Type(np.uint32(0), np.uint32(0))
    for kind in kinds:
        type_ = with_event(type_, kind)
    assert type_.count == MOST_EVENTS and EVENT_BITS * MOST_EVENTS <= 32
    read = [(int(type_.events) >> (EVENT_BITS * i)) & EVENT_MASK for i in range(MOST_EVENTS)]
    assert read == kinds.tolist()


BODY = """
alight: 1
integrator: {type: path, max_depth: 8, caustics: %s}
camera: {fov: 30, transform: {look_at: {origin: [0, 0, 4], target: [0, 0, 0]}}}
film: {size: [4, 4]}
nodes:
  body: {shape: {type: sphere, radius: 1.5}, bsdf: {type: subsurface, radius: 2}}
  bulb:
    shape: {type: sphere, radius: 0.3, center: [0, 0, 1]}
    bsdf: {type: dielectric, int_ior: 1.2}
  lamp:
    shape: {type: sphere, radius: 0.1, center: [0, 0, 1]}
    light: {type: area, radiance: 5}
"""


def test_no_chain_begins_inside_of_a_body():
    """Light that enters a body wanders: no chain leads straight on from there."""
    pictures = [picture_of(loads(BODY % way), 8) for way in ("manifold", "paths")]
    np.testing.assert_array_equal(*pictures)
    assert pictures[0].max() > 0.0


def test_directions_that_are_refused_bring_no_light(monkeypatch):
    """Those of a solution that is too dense: without the question all of them would count."""
    glass = scene(lamp=SHINING.replace("0.3", "0.05"))
    usual = picture_of(glass, 4)
    monkeypatch.setattr(manifold_sampling, "_is_kept", kernel(lambda accept, *_: accept < 0.0))
    refused = picture_of(glass, 4)
    assert (refused <= usual).all() and refused.sum() < usual.sum()
