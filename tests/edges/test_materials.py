"""Materials at the edges of their ranges, in directions at the edges of the hemisphere."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest

from alight.bsdfs import MODELS
from alight.bsdfs.disney.principled import Principled
from alight.bsdfs.dispatch import albedo_bsdf, evaluate_bsdf, sample_bsdf
from alight.bsdfs.model import stride_of
from alight.bsdfs.switch import models_of
from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.registry import type_name_of
from alight.laws.materials import Material
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3
from tests.edges.specs import at_the_edges
from tests.sampling.materials import EXAMPLES, random_numbers
from tests.sampling.statistics import unit_vectors

COSINES = (1.0, 0.5, 1e-3, 1e-6, 1e-12, 0.0)
AZIMUTHS = (0.0, 0.6, 0.5 * np.pi, np.pi)
UNIFORM = np.float32([0.0, 1e-7, 0.5, ONE_MINUS_EPSILON])
#: Each of their descriptions takes tables that are slow to make.
TABLED = ("rough_plastic", "principled", "coated_conductor", "plastic", "subsurface")


def directions():
    """(3, n) float32 unit vectors: overhead, slanted, grazing and in the surface, on both sides."""
    cosine, azimuth = (a.ravel() for a in np.meshgrid((*COSINES, *(-c for c in COSINES)), AZIMUTHS))
    sine = np.sqrt(1.0 - cosine * cosine)
    found = np.float32([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine])
    return np.unique(found, axis=1)


def specs_of(model, examples):
    """The model's descriptions at their edges, each once."""
    return list(dict.fromkeys(spec for e in examples for spec in at_the_edges(e)))


def check(specs):
    """Values and densities are finite and not negative; samples are unit directions."""
    material, d = Material(*specs, uv=(0.3, 0.4)), directions()
    wo, wi = np.repeat(d, d.shape[1], axis=1), np.tile(d, (1, d.shape[1]))
    u = np.stack(np.meshgrid(UNIFORM, UNIFORM, UNIFORM)).reshape(3, -1)
    seen, u = np.repeat(d, u.shape[1], axis=1), np.tile(u, (1, d.shape[1]))
    for number, spec in enumerate(specs):
        text = str(spec)
        ids = np.full(wo.shape[1], number, np.uint32)
        for values in material.evaluate(wo, wi, ids):
            assert np.isfinite(values).all() and (values >= 0.0).all(), text
        drawn, *rest = material.sample(seen, u, np.full(seen.shape[1], number, np.uint32))
        for values in rest:
            assert np.isfinite(values).all() and (values >= 0).all(), text
        length = np.sqrt((drawn.astype(float) ** 2).sum(axis=0))
        assert np.abs(length - 1.0).max() < 1e-5, text


@pytest.mark.parametrize("model", MODELS, ids=type_name_of)
def test_scattering_is_finite_and_not_negative(model):
    check(model.EXAMPLES[:1] if type_name_of(model) in TABLED else specs_of(model, model.EXAMPLES))


@pytest.mark.proofs
@pytest.mark.parametrize(
    "model", [m for m in MODELS if type_name_of(m) in TABLED], ids=type_name_of
)
def test_scattering_with_tables_is_finite_and_not_negative(model):
    check(specs_of(model, model.EXAMPLES))


def test_principled_is_finite_where_a_lobe_has_nothing():
    """Tints that are black, and metal that leaves glass no share: in one program with glass."""
    glass = {"transmission": 1.0, "roughness": 0.5}
    check(
        [
            Principled(specular_color=0.0),
            Principled(specular_color=0.0, thin=True, transmission=0.7, clearcoat=0.3),
            Principled(specular=0.0, **glass),
            Principled(metallic=1.0, ior=5.0, **glass),
            Principled(specular_color=0.0, base_color=0.0, **glass),
            Principled(anisotropy=0.5, anisotropy_rotation=1e15),
        ]
    )


KERNELS = {
    "evaluate": (evaluate_bsdf, lambda wo, wi, u: (wo, wi)),
    "sample": (sample_bsdf, lambda wo, wi, u: (wo, u[0], (u[1], u[2]))),
    "albedo": (albedo_bsdf, lambda wo, wi, u: (wo,)),
}


@pytest.mark.parametrize("name", KERNELS)
def test_models_read_rows_of_their_own_kind_only(name):
    """What is a colour in a row of one kind may start a table in a row of another."""
    material, n = Material(*EXAMPLES), 512
    kinds = material.scene.materials.info.array[::2]
    numbers, asked = defaultdict(set), set()
    for model in models_of(material.program):
        numbers[model.load].add(model.number)
    stride = stride_of(material.program.bsdfs)

    def observe(node, made):
        if node not in numbers:
            return made

        def load(scene, base, surface):
            found = set(kinds[np.asarray(base) // stride].tolist())
            assert len(found) == 1, node.__module__
            asked.update(found & numbers[node])
            return made(scene, base, surface)

        return load

    root, arguments = KERNELS[name]
    run = instantiate(root, material.program, compiled=False, observe=observe)
    surface = material.surface(n, (np.arange(n) % len(EXAMPLES)).astype(np.uint32))
    wo, wi = Vec3(*unit_vectors(n, 1)), Vec3(*unit_vectors(n, 2))
    with np.errstate(all="ignore"):
        run(material.scene, surface, *arguments(wo, wi, random_numbers(n, 3)), np.arange(n) % 3 > 0)
    # Some call that of another model, which then reads their rows.
    assert asked == set().union(*numbers.values())
