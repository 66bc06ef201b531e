"""What a model says of a field, that it changes the noise only, is so; all else is the picture."""

from typing import Literal, get_args, get_origin

import numpy as np
import pytest

import alight
from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.matte.diffuse import Diffuse
from alight.compiled.scene import compile_scene
from alight.core.noise_only import noise_only_fields
from alight.core.registry import Models
from alight.core.vec import Vec3
from alight.lab.arms import load_arms, same_picture_hash, without_choices
from alight.lab.study import StudyError
from alight.lab.study_file import parse_study
from alight.laws.materials import Material, stacked
from alight.laws.statistics import unit_vectors
from alight.lights.misses import environment_radiance
from alight.scene import Node, Scene, flatten
from alight.shapes.sphere import Sphere
from lanewise.jit import instantiate

FAMILIES = ("bsdfs", "lights", "integrators", "media", "phases", "textures", "cameras", "filters")

#: Fields whose claim is tested by pictures: tests/lights, tests/guiding, tests/estimators and
#: `alight.laws.integrators`.
BY_PICTURES = {
    "light_sampling", "light_choice", "heuristic", "russian_roulette", "rr_depth", "guiding",
    "caustics",
}  # fmt: skip

N = 512


def _others(spec, name):
    """The other values of a field that is a choice."""
    kind = type(spec).model_fields[name].annotation
    if kind is bool:
        return [not getattr(spec, name)]
    if get_origin(kind) is Literal:
        return [word for word in get_args(kind) if word != getattr(spec, name)]
    return []


def _changed(family, noise_only):
    """(a description, the same with another choice) for fields that say so, or do not."""
    found = []
    for module in Models(family).values():
        for spec in module.EXAMPLES:
            for name in type(spec).model_fields:
                if name == "type" or (name in noise_only_fields(spec)) != noise_only:
                    continue
                for value in _others(spec, name):
                    copy = spec.model_copy(update={name: value})
                    found.append(pytest.param(spec, copy, id=f"{spec.type_name()}.{name}"))
    return found


@pytest.mark.parametrize(("spec", "other"), _changed("bsdfs", True))
def test_a_material_scatters_the_same(spec, other):
    wo, wi = unit_vectors(N, 1), unit_vectors(N, 2)
    one, two = (Material(each).evaluate(wo, wi)[0] for each in (spec, other))
    np.testing.assert_allclose(one, two, rtol=1e-5, atol=1e-8)


def _radiance(light):
    nodes = {"far": Node(shape=Sphere())}
    camera = Node(camera=Models("cameras")["pinhole"].EXAMPLES[0])
    scene = compile_scene(
        flatten(Scene(nodes=nodes, camera=camera, environment=light)), structure="list"
    )
    kernel = instantiate(environment_radiance, scene.program, compiled=False)
    with np.errstate(all="ignore"):
        return stacked(kernel(scene.tables, Vec3(*unit_vectors(N, 3))), N)


@pytest.mark.parametrize(("spec", "other"), _changed("lights", True))
def test_a_light_shines_the_same(spec, other):
    if spec.is_black:
        pytest.skip("a scene without light is refused")
    np.testing.assert_array_equal(_radiance(spec), _radiance(other))


def test_what_integrators_say_is_tested_elsewhere():
    said = {n for m in Models("integrators").values() for n in noise_only_fields(m.EXAMPLES[0])}
    assert said == BY_PICTURES


@pytest.mark.parametrize("family", FAMILIES)
def test_choices_of_the_noise_are_taken_out_and_no_others(family):
    for noise_only in (True, False):
        for spec, other in (case.values for case in _changed(family, noise_only)):
            assert (without_choices(spec) == without_choices(other)) == noise_only


def test_choices_inside_of_materials_are_found():
    parts = [
        (Diffuse(sampling=first), Diffuse(reflectance=0.2, sampling=second))
        for first in ("cosine", "uniform")
        for second in ("cosine", "uniform")
    ]
    plain = {str(without_choices(Blend(bsdfs=pair))) for pair in parts}
    assert len(plain) == 1
    assert "0.2" in plain.pop()


STUDY = """
scenes: [{scene: cornell-box, set: {bsdfs.white: {type: principled, metallic: 1}}}]
arms:
  with: {}
  without: {bsdfs.white.compensation: false}
"""


def test_compensation_of_facets_is_another_picture():
    """It gives light back; that of an environment map only moves samples."""
    study = parse_study(STUDY)
    with pytest.raises(StudyError, match=r"without[\s\S]*another picture.*compensation"):
        load_arms(study, study.scenes[0], quick=False)


POINT, SUN = {"type": "point", "intensity": 1}, {"type": "directional", "irradiance": 1}
WALKS, LIGHT_PATHS = {"type": "path", "caustics": "manifold"}, {"type": "bidirectional"}


@pytest.mark.parametrize("integrator", [WALKS, LIGHT_PATHS])
@pytest.mark.parametrize(
    ("light", "bsdf", "other"),
    [
        (POINT, "mirror", True), (SUN, "dielectric", True), (POINT, "plastic", True),
        (POINT, "diffuse", False), (POINT, "rough_dielectric", False), (None, "mirror", False),
    ],
)  # fmt: skip
def test_what_no_path_finds_is_another_picture(integrator, light, bsdf, other):
    def hash_of(integrator):
        return same_picture_hash(alight.load({
            "camera": {}, "environment": {"type": "constant"}, "integrator": integrator,
            "nodes": {"ball": {"shape": "sphere", "bsdf": {"type": bsdf}},
                      **({"lamp": {"light": light}} if light else {})},
        }))  # fmt: skip

    assert (hash_of({"type": "path"}) != hash_of(integrator)) == other
