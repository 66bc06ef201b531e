"""As deep, and as many, as is allowed: read, and its kernels written; beyond, a message."""

from __future__ import annotations

import sys

import pytest

from alight.bsdfs.adapters.normal_map import NormalMap
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.nesting import MOST_LEVELS
from alight.compiled.scene import compile_scene
from alight.core.errors import SceneError
from alight.formats import load, loads
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.sampling import sample_light
from alight.scene import flatten
from alight.scene.validation import MOST_INSTANCED, MOST_SURROUNDINGS
from alight.textures.add import Add
from alight.textures.checkerboard import Checkerboard
from alight.textures.nesting import MOST_STEPS, depth_of
from lanewise.jit import instantiate

HEAD = "alight: 1\ncamera: {type: pinhole, transform: {translate: [0, 0, 4]}}\n"
#: The compiler goes through some 50 functions of Python for each kernel inside of another.
FRAMES_OF_A_KERNEL = 50


def chain(count, key):
    """A scene of prototypes in prototypes, or of materials in materials, by name."""
    first, inside = {
        "prototypes": ("{shape: sphere}", "{instance: p%d}"),
        "bsdfs": ("{type: diffuse}", "{type: normal_map, bsdf: p%d}"),
    }[key]
    lines = [f"  p{i}: {inside % (i - 1) if i else first}\n" for i in range(count)]
    node = f"instance: p{count - 1}" if key == "prototypes" else f"shape: cube, bsdf: p{count - 1}"
    return f"{HEAD}nodes: {{a: {{{node}}}}}\n{key}:\n{''.join(reversed(lines))}"


@pytest.mark.parametrize(("key", "most"), [("prototypes", MOST_INSTANCED), ("bsdfs", MOST_LEVELS)])
def test_chains_of_names_are_as_long_as_is_said(key, most):
    compile_scene(flatten(loads(chain(most, key), "scene.yaml")), structure="list")
    for count in (most + 1, 3000):
        with pytest.raises(SceneError, match=f"{most} levels"):
            loads(chain(count, key), "scene.yaml")


def test_descriptions_made_in_python_have_the_same_limit():
    spec = Diffuse()
    for _ in range(MOST_LEVELS - 1):
        spec = NormalMap(bsdf=spec)
    with pytest.raises(SceneError, match=f"at most {MOST_LEVELS} levels deep"):
        NormalMap(bsdf=spec)


def test_deep_sums_are_measured_at_once():
    """Each level may look at its parts once: at twice each, sixty levels take forever."""
    spec, looks = Checkerboard(color0=0.0, color1=0.0), 0

    def count(frame, event, argument):
        nonlocal looks
        looks += event == "call" and frame.f_code is depth_of.__code__

    for _ in range(14):
        spec = Add(a=spec, b=0.01)
    sys.setprofile(count)
    try:
        depth_of(spec)
    finally:
        sys.setprofile(None)
    assert looks <= 100
    for _ in range((MOST_STEPS - 1) // 2 - 14):
        spec = Add(a=spec, b=0.01)
    assert depth_of(spec) == 2


def surroundings(count):
    """A scene with so many lights around it."""
    light = "{light: {type: constant, radiance: 0.1}}"
    nodes = "".join(f"  e{i}: {light}\n" for i in range(count))
    return f"{HEAD}nodes:\n  ball: {{shape: sphere}}\n{nodes}"


def depth_of_kernels(root, program):
    """How many kernels stand inside of one another when they are written."""
    deepest = 0

    def observe(node, made):
        nonlocal deepest
        frame, inside = sys._getframe(), 0
        while frame is not None:
            frame, inside = frame.f_back, inside + (frame.f_code.co_name == "make")
        deepest = max(deepest, inside)
        return made

    instantiate(root, program, compiled=False, observe=observe)
    return deepest


def test_as_many_surroundings_as_allowed_can_be_written():
    """By halves: kernels one inside of the other would exhaust the compiler's recursion."""
    scene = compile_scene(flatten(loads(surroundings(MOST_SURROUNDINGS), "a.yaml")), "list")
    for root in (sample_light, environment_radiance, environment_pdf):
        depth = depth_of_kernels(root, scene.program)
        assert depth * FRAMES_OF_A_KERNEL < sys.getrecursionlimit()
    with pytest.raises(SceneError, match=f"at most {MOST_SURROUNDINGS} lights that surround"):
        loads(surroundings(MOST_SURROUNDINGS + 1), "a.yaml")


def test_names_that_no_file_can_have_are_missing_files(tmp_path):
    for name in ("a" * 300 + ".yaml", "a" * 300 + ".gltf"):
        with pytest.raises(SceneError, match="no such"):
            load(tmp_path / name)


def test_halves_of_characters_are_no_text():
    with pytest.raises(SceneError, match="half of a character"):
        loads(HEAD + "nodes: {\udcff: {}}\n", "scene.yaml")
