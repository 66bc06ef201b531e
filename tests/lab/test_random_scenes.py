"""Random scenes: a pure function of seed and kind, valid, written and read, of all models."""

import collections
import os
import subprocess
import sys
import warnings

import numpy as np
import pytest
from typer.testing import CliRunner

import alight
from alight.accel import intersect_closest
from alight.bsdfs.fibres.hair import Hair
from alight.bsdfs.nesting import scatters_inside
from alight.cli.main import app
from alight.compiled.scene import compile_scene
from alight.core.errors import OptionError
from alight.core.registration import unregister
from alight.core.registry import FAMILIES_OF_SCENES, Models, specs_of
from alight.core.spec import Integrator, Spec
from alight.formats import dumps, load, loads
from alight.lab.random_scenes import KINDS, random_scene
from alight.lab.random_scenes.chance import Chance
from alight.lab.random_scenes.kinds import summary
from alight.lab.random_scenes.materials import clear
from alight.lab.random_scenes.meshes import closed_mesh
from alight.laws import integrators as laws
from alight.laws.bodies import vec_of
from alight.laws.statistics import unit_vectors
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import content_hash, flatten
from alight.scene.validation import find_problems
from alight.shapes.arrays import TriangleShape, is_displaced
from alight.shapes.strands import StrandShape
from lanewise.jit import instantiate
from tests.extension.models import LAMBERT, module_of
from tests.fuzz.in_the_twin import SIDE, picture
from tests.portion import portion

SEEDS = range(24)
DIGEST = """
from alight.lab.random_scenes import random_scene
from alight.scene import content_hash, flatten
print(*(content_hash(flatten(random_scene(seed))) for seed in range(8)))
"""


@pytest.fixture(scope="module")
def scenes():
    """Some of each kind, some 300, by (seed, kind)."""
    return {(seed, kind): random_scene(seed, kind) for seed in SEEDS for kind in KINDS}


@pytest.fixture(scope="module")
def texts(scenes):
    """Of a third of them: reading takes its time."""
    return {place: dumps(scene) for place, scene in scenes.items() if place[0] < 8}


def used(value):
    """(family, type name) of all descriptions inside of a value."""
    if isinstance(value, dict):
        value = tuple(value.values())
    if isinstance(value, tuple):
        for item in value:
            yield from used(item)
    if isinstance(value, Spec):
        if value.family in FAMILIES_OF_SCENES:
            yield value.family, value.type_name()
        for _, field in value:
            yield from used(field)


def test_a_scene_depends_on_its_seed_and_kind_only(scenes):
    """Not on what was drawn before, on the order of sets, or on the source of random numbers."""
    for place, scene in list(scenes.items())[:: len(KINDS) + 1]:
        assert random_scene(*place) == scene
    # This process has another order of sets: pytest takes no seed for hashes.
    elsewhere = subprocess.run(
        [sys.executable, "-c", DIGEST],
        env={**os.environ, "PYTHONHASHSEED": "1"},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert elsewhere.split() == [content_hash(flatten(random_scene(seed))) for seed in range(8)]


def test_no_two_scenes_are_alike(texts):
    assert len(set(texts.values())) == len(texts)


def test_all_are_valid_and_have_light(scenes):
    wrong = [
        (*place, [f"{issue.path}: {issue.message}" for issue in found], scene.warnings)
        for place, scene in scenes.items()
        if (found := find_problems(scene)) or scene.warnings
    ]
    assert not wrong


def test_text_and_back_is_the_same_scene(scenes, texts):
    wrong = [place for place, text in texts.items() if loads(text, check=False) != scenes[place]]
    assert not wrong


@pytest.mark.parametrize("family", FAMILIES_OF_SCENES)
def test_every_registered_model_is_drawn(scenes, family):
    counts = collections.Counter(
        name
        for scene in scenes.values()
        for found, name in set(used(tuple(field for _, field in scene)))
        if found == family
    )
    # Light tracing does not find what mirrors show: scenes of any kind cannot ask for it.
    left_out = {name for name, spec in specs_of(Integrator).items() if spec.splats}
    assert set(counts) == set(Models(family)) - left_out


def test_a_model_that_is_registered_later_is_drawn_too():
    """With parameters of its own range, whatever they are called."""
    alight.register(module_of(LAMBERT))
    try:
        found = [
            bsdf
            for seed in range(60)
            for bsdf in random_scene(seed, "heap").bsdfs.values()
            if bsdf.type_name() == "lambert"
        ]
    finally:
        unregister("bsdfs", "lambert")
    assert found
    assert {bsdf.gloss for bsdf in found} - {0.0}


def test_sizes_are_from_32_to_256_or_as_asked(scenes):
    sides = np.array([scene.film.size for scene in scenes.values()])
    assert sides.min() >= 32
    assert sides.max() <= 256
    assert sides.max() > 200
    assert sides.min() < 40
    assert random_scene(3, "room", (16, 8)).film.size == (16, 8)


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_is_rendered_in_the_twin(kind):
    """Finite samples and no warning; `picture` demands more."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert picture(flatten(random_scene(1, kind, (SIDE, SIDE)))) == 0


@pytest.mark.proofs
@pytest.mark.parametrize("kind", portion(["room", "landscape", "street", "fog"]))
def test_machine_code_gives_the_twins_picture(kind):
    """Of these the models are many; a path whose choice hangs on a rounding error may differ."""
    scene = compile_scene(flatten(random_scene(2, kind, (16, 16))), structure="list")
    found, expected = (
        laws.picture(scene, Tile(0, 0, 16, 16), compiled=way).sum(axis=2) for way in (True, False)
    )
    close = np.isclose(found, expected, rtol=2e-3, atol=1e-3 * expected.mean())
    assert close.all(axis=-1).mean() > 0.9


def test_seeds_without_a_kind_are_of_all_kinds_whether_odd_or_even():
    """Constants are chosen on even seeds and judged on odd ones."""
    for first in (0, 1):
        kinds = {Chance("kind", seed).choose(tuple(KINDS)) for seed in range(first, 200, 2)}
        assert kinds == set(KINDS)


# ---------------------------------------------------------------- the command


def run(*words):
    return CliRunner().invoke(app, ["scene", "random", *words], env={"COLUMNS": "200"})


def test_the_command_prints_the_scene():
    result = run("--seed", "-7", "--kind", "fog", "--size", "40x30")
    assert result.exit_code == 0
    assert loads(result.stdout) == random_scene(-7, "fog", (40, 30))


def test_the_command_writes_the_scene_with_its_files(tmp_path):
    path = tmp_path / "scene.yaml"
    assert run("--seed", "4", "--kind", "landscape", "-o", str(path)).exit_code == 0
    expected = flatten(random_scene(4, "landscape"))
    assert content_hash(flatten(load(path))) == content_hash(expected)


def test_the_command_lists_kinds_and_names_the_nearest():
    listed = run("--kind", "list").stdout.splitlines()
    assert listed == [f"{kind:<{max(map(len, KINDS))}}  {summary(kind)}" for kind in KINDS]
    result = run("--kind", "stret")
    assert result.exit_code == 2
    assert 'did you mean "street"?' in result.stderr
    with pytest.raises(OptionError, match='unknown kind of scene "stret"'):
        random_scene(0, "stret")


def test_a_file_that_cannot_be_written_is_said(tmp_path):
    result = run("--kind", "studio", "-o", str(tmp_path / "none" / "scene.yaml"))
    assert result.exit_code == 2
    assert "cannot write" in result.stderr


def test_clear_materials_are_seen_from_either_side_of_their_boundary():
    found = [clear(Chance("clear", seed)) for seed in range(300)]
    ratios = np.array([spec.int_ior / spec.ext_ior for spec in found])
    # Denser inside, denser outside, and now and then nearly the same.
    assert (ratios > 1.1).sum() > 100
    assert (ratios < 1.0 / 1.1).sum() > 30
    assert 0 < (np.abs(np.log(ratios)) <= np.log(1.1)).sum() < 60


def test_closed_bodies_face_outwards():
    """Their volume is positive, by the divergence theorem; glass would be air in glass else."""
    for seed in range(60):
        mesh = closed_mesh(Chance("mesh", seed))
        a, b, c = np.moveaxis(np.asarray(mesh.vertices, float)[mesh.faces], 1, 0)
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() > 0.0, seed


def test_what_scatters_inside_is_in_closed_shapes_and_seen(scenes):
    """By integrators that walk, around nothing else, and not in a box of fog."""
    for place, scene in scenes.items():
        bodies = {name for name, bsdf in scene.bsdfs.items() if scatters_inside(bsdf)}
        nodes = [node for node in scene.nodes.values() if node.bsdf in bodies]
        assert len(bodies) <= 1
        assert not nodes or scene.integrator.walks_inside or not scene.integrator.needs_light
        for node in nodes:
            assert node.interior is None
            assert node.shape.closed or isinstance(node.shape, TriangleShape)
            assert not node.shape.flip_normals, place


def test_some_meshes_are_displaced_and_some_strands_are_hair(scenes):
    nodes = [(s.bsdfs.get(n.bsdf), n.shape) for s in scenes.values() for n in s.nodes.values()]
    assert sum(shape is not None and is_displaced(shape) for _, shape in nodes) > 10
    hairy = [isinstance(bsdf, Hair) for bsdf, shape in nodes if isinstance(shape, StrandShape)]
    assert 10 < sum(hairy) < len(hairy) - 10


@pytest.mark.parametrize("kind", ["room", "door"])
def test_no_light_leaves_a_closed_room(kind):
    for seed in range(6):
        flat = flatten(random_scene(seed, kind))
        if any(shape.motion is not None for shape in flat.shapes):
            continue
        scene = compile_scene(flat, structure="list")
        trace = instantiate(intersect_closest, scene.program, compiled=False)
        d = unit_vectors(2000, seed)
        for lamp in (shape.to_world for shape in flat.shapes if shape.light is not None):
            # From beside the middle of the lamp.
            normal = lamp[:3, 2] / np.linalg.norm(lamp[:3, 2])
            o = np.repeat((lamp[:3, 3] + 0.01 * normal)[:, None], 2000, axis=1)
            far = np.full(2000, np.inf, np.float32)
            with np.errstate(all="ignore"):
                hit = trace(scene.tables, vec_of(o), vec_of(d), far, np.ones(2000, bool))
            assert np.isfinite(hit.t).all(), seed
