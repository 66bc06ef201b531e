"""Tables, dispatcher and textures: any mixture of materials gives what each gives alone."""

import numpy as np
import pytest

from alight.bsdfs import MODELS
from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.adapters.mask import Mask
from alight.bsdfs.adapters.two_sided import TwoSided
from alight.bsdfs.conductors.conductor import Conductor
from alight.bsdfs.disney.principled import Principled
from alight.bsdfs.matte.diffuse import UNIFORM, Diffuse
from alight.bsdfs.model import BSDFS, STRIDE, stride_of
from alight.bsdfs.plastics.phong import Phong
from alight.bsdfs.plastics.plastic import Plastic
from alight.bsdfs.plastics.rough_plastic import RoughPlastic
from alight.bsdfs.switch import SAME_BACK
from alight.compiled.materials import Packer, compile_materials
from alight.compiled.program import Program
from alight.core.registry import type_name_of
from alight.laws.compiled import N, rounding_of_cosine, scatter
from alight.shapes.hit import COLORS, INFO
from alight.textures import vertex_color
from alight.textures.checkerboard import Checkerboard
from alight.textures.constant import Constant
from alight.textures.fetch import color
from alight.textures.vertex_color import VertexColor
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3
from lanewise.view import View
from tests.portion import portion
from tests.sampling.materials import (
    EXAMPLES,
    Material,
    Scene,
    Shapes,
    Surface,
    random_numbers,
)
from tests.sampling.statistics import unit_vectors

# Every model, two-sided ones, and textures, in one program.
MIXED = (
    *EXAMPLES,
    Diffuse(reflectance=Checkerboard(scale=3.0, color1=(0.9, 0.1, 0.0))),
    Diffuse(reflectance=VertexColor(fallback=(0.1, 0.2, 0.3))),
    Phong(diffuse=Checkerboard(scale=2.0), specular=Constant(color=0.1)),
    TwoSided(bsdf=Phong()),
    RoughPlastic(alpha=Checkerboard(color0=0.2, color1=0.5)),
    Blend(weight=Checkerboard(scale=4.0), bsdfs=(TwoSided(bsdf=Phong()), Mask(bsdf=Plastic()))),
)


def mixed_ids(specs=MIXED):
    return np.random.default_rng(5).integers(0, len(specs), N).astype(np.uint32)


def test_no_result_is_left_out_or_stands_for_another():
    """Else the laws here would compare less than they say."""
    results = scatter(MIXED, mixed_ids(), False)
    assert results.any(axis=1).all()
    assert len(np.unique(results, axis=0)) == len(results)


TYPES = list(dict.fromkeys(spec.type_name() for spec in MIXED))
#: Three models each: twice as many take more than twice as long to compile.
PROGRAMS = {
    ", ".join(names): tuple(spec for spec in MIXED if spec.type_name() in names)
    for names in (TYPES[i : i + 3] for i in range(0, len(TYPES), 3))
} | {
    "one class": (Diffuse(),),
    "one class, two-sided and uniform": (
        TwoSided(bsdf=Diffuse(reflectance=0.2)),
        Diffuse(sampling="uniform"),
    ),
}


#: All models in one function take minutes to compile. Those of a portion are no neighbours.
ALL = pytest.param(
    tuple(spec for spec in MIXED if spec.type_name() in portion(TYPES)),
    marks=[pytest.mark.proofs, pytest.mark.timeout(1800)],
)


@pytest.mark.parametrize(
    "specs",
    [*PROGRAMS.values(), ALL],
    ids=[*PROGRAMS, "all models"],
)
def test_compiled_code_equals_the_twin(specs):
    ids = mixed_ids(specs)
    compiled, twin = scatter(specs, ids, True), scatter(specs, ids, False)
    assert np.all(np.isfinite(compiled))
    # Of directions. Where a sample fails, any will do.
    used = twin[6] > 0.0
    np.testing.assert_allclose(compiled[:2, used], twin[:2, used], atol=3e-6)
    rounding = rounding_of_cosine(twin[2, used])
    np.testing.assert_array_less(np.abs(compiled[2, used] - twin[2, used]), 3e-6 + rounding)
    # The sharpest lobe takes rounding errors of a direction to the power of 300; of what passes a
    # thin sheet some densities differ by 5e-5. Near the horizon weights are as large as the cosine.
    relative = 1e-4 + rounding / np.maximum(np.abs(twin[2, used]), 1e-3)
    weights = np.abs(compiled[3:7, used] - twin[3:7, used])
    np.testing.assert_array_less(weights, 2e-6 + relative * np.abs(twin[3:7, used]))
    np.testing.assert_allclose(compiled[3:7, ~used], twin[3:7, ~used], rtol=1e-4, atol=2e-6)
    np.testing.assert_allclose(compiled[7:14], twin[7:14], rtol=1e-4, atol=2e-6)
    np.testing.assert_array_equal(compiled[14], twin[14])


def test_a_mixture_gives_what_each_material_gives_alone():
    # What is more general where another material needs it (glass in `principled`, normals that are
    # bent, rows for anisotropy) rounds differently: those are left out of the exact mixture.
    exact = [i for i, s in enumerate(MIXED) if not rounds_differently(s)]
    ids = mixed_ids()
    together = scatter(MIXED, ids, False)
    place = np.searchsorted(exact, ids).clip(max=len(exact) - 1).astype(np.uint32)
    exactly = scatter([MIXED[i] for i in exact], place, False)
    for i, spec in enumerate(MIXED):
        mine = ids == i
        alone = scatter((spec,), np.zeros(N, np.uint32), False)[:, mine]
        if i in exact:
            np.testing.assert_array_equal(exactly[:, mine], alone, err_msg=str(spec))
        # The values and densities of given directions; rounded lobes are sharp.
        np.testing.assert_allclose(
            together[7:11, mine], alone[7:11], rtol=2e-4, atol=2e-5, err_msg=str(spec)
        )
        assert np.isfinite(together[:, mine]).all()


@pytest.mark.parametrize("first", [True, False], ids=["before", "after"])
@pytest.mark.parametrize("model", MODELS, ids=lambda model: type_name_of(model))
def test_rows_of_other_models_are_not_read(model, first):
    """What is a colour to one model would be the start of a table to another, beyond all tables."""
    spec = model.EXAMPLES[-1]
    used = Material(spec).program.bsdfs
    other = next(s for s in (Diffuse(), Phong(), Plastic()) if s.type_name() not in used)
    specs = (other, spec) if first else (spec, other)
    material, found = Material(*specs), []
    ids = np.random.default_rng(6).integers(0, 2, 256).astype(np.uint32)
    mine = ids == specs.index(spec)
    tables, stride = material.scene.materials, stride_of(material.program.bsdfs)
    kinds = tables.info.array.reshape(-1, 2)[:, 0]
    (row,) = np.flatnonzero(kinds == BSDFS[other.type_name()].number)
    for number in (0.5, 1e9):
        tables.data.array.reshape(-1, stride)[row] = number
        wo, u = unit_vectors(256, 9), random_numbers(256, 10)
        results = *material.sample(wo, u, ids), *material.evaluate(wo, unit_vectors(256, 11), ids)
        found.append(np.vstack([np.asarray(r, float).reshape(-1, 256) for r in results])[:, mine])
    np.testing.assert_array_equal(*found)


def rounds_differently(spec):
    return Material(spec).is_bent() or isinstance(spec, Principled)


@pytest.mark.parametrize("inner", [Diffuse(reflectance=0.7), Phong()])
def test_the_back_of_a_two_sided_surface_looks_like_its_front(inner):
    both, front = Material(TwoSided(bsdf=inner)), Material(inner)
    wo, wi = unit_vectors(N, 6), unit_vectors(N, 7)
    flipped = np.float32([[1.0], [1.0], [-1.0]])
    above = wo[2] > 0.0
    to_front = np.where(above, 1.0, flipped)
    for seen, expected in zip(
        both.evaluate(wo, wi), front.evaluate(wo * to_front, wi * to_front), strict=True
    ):
        np.testing.assert_array_equal(seen, expected)
    u = random_numbers(N, 8)
    wi, weight, pdf, flags = both.sample(wo, u)
    expected = front.sample(wo * to_front, u)
    np.testing.assert_array_equal(wi, expected[0] * to_front)
    for seen, wanted in zip((weight, pdf, flags), expected[1:], strict=True):
        np.testing.assert_array_equal(seen, wanted)


def test_albedo_is_the_reflected_part_of_the_light():
    specs = (Diffuse(reflectance=0.3), Phong(diffuse=0.5, specular=0.2), Conductor(eta=1.5, k=0.0))
    ids = (np.arange(N) % 3).astype(np.uint32)
    albedo = scatter(specs, ids, False)[11:14]
    for i, expected in enumerate((0.3, 0.7, 0.04)):
        np.testing.assert_allclose(albedo[:, ids == i], expected, rtol=1e-6)


# ---------------------------------------------------------------- tables


def test_slots_of_every_model_fit_its_row():
    for model in MODELS:
        if hasattr(model, "SLOTS"):
            name = model.EXAMPLES[0].type_name()
            assert sum(model.SLOTS.values()) <= stride_of([name]) == stride_of([name, "mirror"])


def test_programs_name_what_they_must_compile():
    specs = [Diffuse(), TwoSided(bsdf=Phong()), Diffuse(reflectance=Checkerboard())]
    _, bsdfs, textures = compile_materials(specs)
    assert bsdfs == ("diffuse", "phong", SAME_BACK)
    assert textures == ("constant", "checkerboard")
    assert UNIFORM in compile_materials([Diffuse(sampling="uniform")])[1]
    # A constant texture costs nothing.
    assert compile_materials([Diffuse(reflectance=Constant())])[2] == ("constant",)


def test_equal_textures_are_stored_once():
    tables, _, _ = compile_materials([Diffuse(reflectance=Checkerboard())] * 3)
    assert tables.texture_info.size == 2
    rows = tables.texture.array.reshape(3, STRIDE)
    np.testing.assert_array_equal(rows[:, 0], 1)


def test_a_scene_without_materials_has_valid_tables():
    tables, bsdfs, _ = compile_materials([])
    assert bsdfs == () and all(view.size > 0 for view in tables)


def test_unresolved_names_are_refused():
    for spec in (Diffuse(reflectance="wood"), TwoSided(bsdf="paint")):
        with pytest.raises(ValueError, match="must be resolved"):
            compile_materials([spec])


def test_a_slot_takes_as_many_numbers_as_it_has():
    with pytest.raises(ValueError, match="has 3 slots, got 2 numbers"):
        Packer({"a": 1, "b": 3}, 8).numbers("b", 1.0, 2.0)


# ---------------------------------------------------------------- textures


def fetched(texture, u, v, vertex=(0.0, 0.0, 0.0), flags=0):
    """The colour (n, 3) of a diffuse surface with a texture."""
    tables, bsdfs, textures = compile_materials([Diffuse(), Diffuse(reflectance=texture)])
    info = np.zeros(INFO, np.uint32)
    info[vertex_color.FLAGS_COLUMN] = flags
    n = len(u)
    vertex = Vec3(*(np.full(n, c, np.float32) for c in vertex))
    surface = Surface(u, v, np.zeros(n, np.uint32), np.ones(n, np.uint32), vertex)
    fetch = instantiate(color, Program(bsdfs=bsdfs, textures=textures), compiled=False)
    rgb = fetch(Scene(tables, Shapes(View(info))), surface.bsdf * STRIDE, surface)
    return np.stack([np.broadcast_to(c, n) for c in (rgb.x, rgb.y, rgb.z)], 1)


@pytest.mark.parametrize(
    "texture",
    [
        Checkerboard(color0=0.0, color1=1.0),
        Checkerboard(color0=0.0, color1=1.0, scale=(3.0, -0.5), offset=(0.25, -7.0)),
    ],
)
def test_checkerboard_alternates(texture):
    u, v = (8.0 * random_numbers(N, 9)[:2] - 4.0).astype(np.float32)
    s = texture.scale[0] * u.astype(float) + texture.offset[0]
    t = texture.scale[1] * v.astype(float) + texture.offset[1]
    inside = (np.abs(s - np.rint(s)) > 1e-5) & (np.abs(t - np.rint(t)) > 1e-5)
    expected = (np.floor(s) + np.floor(t)) % 2.0
    np.testing.assert_array_equal(fetched(texture, u, v)[inside, 0], expected[inside])


def test_vertex_color_is_interpolated_where_there_is_one():
    u = np.zeros(4, np.float32)
    texture = VertexColor(fallback=(0.9, 0.1, 0.2))
    own = fetched(texture, u, u, (0.3, 0.6, 0.1), COLORS)
    np.testing.assert_array_equal(own, np.float32([[0.3, 0.6, 0.1]] * 4))
    np.testing.assert_array_equal(fetched(texture, u, u), np.float32([[0.9, 0.1, 0.2]] * 4))


def test_vertex_color_reads_the_flag_that_shapes_write():
    assert (vertex_color.SHAPE_ROW, vertex_color.HAS_COLORS) == (INFO, COLORS)


def test_constant_texture_is_its_colour():
    u = np.zeros(4, np.float32)
    np.testing.assert_array_equal(fetched(Constant(color=0.25), u, u), 0.25)
