"""`alight.register`: a user's model is a model like ours."""

import hashlib
import os
import subprocess
import sys
import types
from typing import ClassVar, Literal

import numpy as np
import pytest
from typer.testing import CliRunner

import alight
from alight.bsdfs.matte.diffuse import Diffuse
from alight.cli.main import app
from alight.compiled.recompile import compiled_of
from alight.compiled.shapes import compile_shapes
from alight.core.errors import SceneError
from alight.core.registration import RegistrationError, _copy, unregister
from alight.core.registry import (
    FAMILIES,
    REGISTERED,
    VERSION,
    Models,
    members_of,
    modules,
    user_number,
)
from alight.core.spec import Light, Shape
from alight.formats import loads
from alight.laws.materials import Material, direction, random_numbers
from alight.scene import content_hash, flatten
from alight.shapes.model import MOST_NUMBERS
from tests.docs.pages import ROOT, blocks
from tests.extension.models import LAMBERT, SCENE, module_of

LIT = SCENE.replace("%s", "diffuse") + "integrator: %s\n"


@pytest.fixture(autouse=True)
def forget():
    """No test's models reach another one."""
    yield
    for family in FAMILIES:
        for name in list(REGISTERED[family]):
            unregister(family, name)


def registered(text=LAMBERT):
    """The script, registered."""
    return alight.register(module_of(text))


def version(name="lambert"):
    return getattr(Models("bsdfs")[name], VERSION)


# ---------------------------------------------------------------- a model like ours


def test_a_copy_of_diffuse_renders_the_same_bits_also_after_a_first_render():
    """Registered after the renderer has been used: nothing was enumerated for good."""
    expected = alight.render(loads(SCENE % "diffuse"), spp=4)
    registered()
    film = alight.render(loads(SCENE % "lambert"), spp=4)
    assert expected.image.max() > 0.1
    np.testing.assert_array_equal(film.sums, expected.sums)


def headlight(strength):
    """The integrator of the page, times a constant."""
    page = ROOT / "docs" / "extending.md"
    [text] = [text for text in blocks(page, "python") if 'type: Literal["headlight"]' in text]
    shade = "path.beta * absolute(dot(surface.ns, path.d))"
    assert shade in text
    text = text.replace(shade, f"{shade} * STRENGTH")
    return text.replace("EXAMPLES =", f"STRENGTH = {strength}\nEXAMPLES =")


def test_machine_code_of_an_earlier_version_is_not_used_again():
    """In one process: a constant changes, the functions' names and the program's models do not."""
    pictures, scene = [], None
    for strength in (1.0, 0.5):
        alight.register(module_of(headlight(strength), "headlight"))
        # What was compiled of the same scene is not used again either.
        scene = scene or loads(LIT % "headlight")
        same = (scene, loads(LIT % "headlight"))
        pictures += [alight.render(one, spp=1, threads=2).image for one in same]
    assert pictures[0].max() > 0.5
    np.testing.assert_array_equal(pictures[1], pictures[0])
    for later in pictures[2:]:
        np.testing.assert_allclose(later, 0.5 * pictures[0], rtol=1e-6)


def test_what_was_compiled_of_a_scene_is_of_the_version_of_its_models():
    registered()
    scene = loads(SCENE % "lambert")
    programs = [compiled_of(scene, (), 1).compiled.program]
    registered(LAMBERT.replace("STRENGTH = 1.0", "STRENGTH = 0.5"))
    programs.append(compiled_of(scene, (), 1).compiled.program)
    assert programs[0].registered != programs[1].registered == ((("bsdfs", "lambert", version()),))


def test_fields_of_an_integrator_are_options_of_its_program():
    text = headlight("1.0").replace(
        'type: Literal["headlight"] = "headlight"',
        'type: Literal["headlight"] = "headlight"\n    strength: float = 1.0',
    )
    text = text.replace(
        "def step(program):", "def step(program):\n    gain = program.option('strength')"
    )
    alight.register(module_of(text.replace("* STRENGTH", "* gain"), "headlight"))
    values = []
    for strength in (1.0, 0.25):
        scene = loads(LIT % f"{{type: headlight, strength: {strength}}}")
        values.append(alight.trace(scene, (8, 8)).value[0])
    assert values[1] == pytest.approx(0.25 * values[0], rel=1e-6) and values[0] > 0.5


def test_rows_grow_for_a_model_with_more_slots_than_ours():
    """The stride is the program's own: the wide model and ours beside it find their numbers."""
    wide = '**{f"further_{i}": 1 for i in range(60)}'
    registered(LAMBERT.replace('"reflectance": 3', f'"reflectance": 3, {wide}'))
    specs = Diffuse(reflectance=0.25), Models("bsdfs")["lambert"].Lambert(reflectance=0.75)
    material = Material(*specs)
    assert material.scene.materials.data.size == 2 * 64
    _, weight, _, _ = material.sample(
        direction(1.0), random_numbers(2, 0), np.array([0, 1], np.uint32)
    )
    np.testing.assert_array_equal(weight[0], np.float32([0.25, 0.75]))


def test_scene_files_are_checked_as_for_our_models():
    registered()
    with pytest.raises(SceneError, match=r"gloss\n.*must be in \[0, 1\], got 2"):
        loads(SCENE.replace("%s,", "lambert, gloss: 2,"))
    with pytest.raises(SceneError, match='unknown bsdf "lambrt"; did you mean "lambert"'):
        loads(SCENE % "lambrt")


def test_namespaces_and_names_of_modules_are_models_too():
    module = module_of(LAMBERT)
    alight.register("users_lambert")
    first = version()
    names = ("EXAMPLES", "SLOTS", "pack", "load", "evaluate", "sample", "albedo")
    declared = ("is_lossless", "is_reciprocal")
    space = types.SimpleNamespace(**{n: getattr(module, n) for n in (*names, *declared)})
    assert alight.register(space) is space
    assert version() == first
    with pytest.raises(RegistrationError, match='no module "users_lambrt" is imported'):
        alight.register("users_lambrt")


def test_registering_takes_a_copy():
    """What the script changes afterwards has no effect until it registers again."""
    module = registered()
    module.STRENGTH = 0.5
    spec = module.Lambert(reflectance=1.0)
    weight = Material(spec).sample(direction(1.0), random_numbers(1, 0))[1]
    np.testing.assert_array_equal(weight, 1.0)
    alight.register(module)
    weight = Material(spec).sample(direction(1.0), random_numbers(1, 0))[1]
    np.testing.assert_array_equal(weight, 0.5)


# ---------------------------------------------------------------- versions

EDITS = {
    "constant": ("STRENGTH = 1.0", "STRENGTH = 0.9"),
    "operation": ("INV_PI * wi.z", "INV_PI + wi.z"),
    "literal": ("wi.z, 0.0)", "wi.z, 0.5)"),
    "callee": ("_, pdf = evaluate(params, wo, wi)", "_, pdf = evaluate(params, wi, wo)"),
    "slots": ('"reflectance": 3', '"reflectance": 3, "more": 1'),
}


@pytest.mark.parametrize("edit", EDITS.values(), ids=EDITS)
def test_what_kernels_are_made_from_is_in_the_version_and_in_the_content_hash(edit):
    registered()
    scene = loads(SCENE % "lambert")
    before, content = version(), content_hash(scene)
    assert edit[0] in LAMBERT
    registered(LAMBERT.replace(*edit))
    assert version() != before
    assert content_hash(loads(SCENE % "lambert")) != content


@pytest.mark.parametrize(
    ("family", "name"), [(family, name) for family in FAMILIES for name in members_of(family)]
)
def test_all_that_others_take_from_a_model_is_in_its_version(family, name):
    """A constant such as a shape's PROJECTION decides which samples are drawn, as kernels do."""
    [model, *_] = [m for m in modules(family) if name in vars(m)] or modules(family)
    digests = {
        getattr(_copy("other", {**vars(model), name: value}, family), VERSION)
        for value in (vars(model).get(name), 0.123)
    }
    assert len(digests) == 2


def test_comments_and_registering_again_leave_the_version():
    registered()
    before = version()
    registered("# A comment.\n" + LAMBERT)
    assert version() == before


def test_closures_are_in_the_version():
    text = (
        LAMBERT
        + """
def make(factor):
    @kernel
    def scaled(params):
        return params.reflectance * factor
    return scaled
albedo = make(FACTOR)
"""
    )
    registered(text.replace("FACTOR", "1.0"))
    before = version()
    registered(text.replace("FACTOR", "0.5"))
    assert version() != before


PLUGIN_RENDER = """
import my_headlight, alight
from alight.formats import loads
print(alight.render(loads({scene!r}), spp=2, threads=2).image.max())
"""


def test_an_edited_script_is_compiled_anew_and_an_unchanged_one_is_not(tmp_path):
    """In fresh processes, from the same disk cache."""
    script = tmp_path / "my_headlight.py"
    environment = {**os.environ, "ALIGHT_CACHE": str(tmp_path / "cache"), "PYTHONPATH": str(ROOT)}

    def run(strength):
        script.write_text(headlight(strength) + "\nimport alight\nalight.register(__name__)\n")
        code = PLUGIN_RENDER.format(scene=LIT % "headlight")
        done = subprocess.run(
            [sys.executable, "-B", "-c", code], cwd=tmp_path, env=environment,
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return float(done.stdout), len(list((tmp_path / "cache").rglob("*.kernel")))

    first, kernels = run(1.0)
    assert run(1.0) == (first, kernels)
    half, more = run(0.5)
    assert half == pytest.approx(0.5 * first, rel=1e-5) and more > kernels


# ---------------------------------------------------------------- messages


def test_all_that_is_wrong_is_said_at_once():
    text = LAMBERT.replace("def albedo(", "def albdo(").replace("@kernel\ndef load", "def load")
    text = text.replace("def sample(params, wo, u, u2)", "def sample(params, wo, u)")
    with pytest.raises(RegistrationError) as caught:
        registered(text)
    message = str(caught.value)
    assert 'users_lambert: bsdf "lambert" cannot be registered' in message
    assert "albedo(params) is missing; is it albdo?  (see alight/bsdfs/matte/diffuse.py)" in message
    assert "load must be a function marked with @kernel" in message
    assert "sample must take (params, wo, u, u2), takes (params, wo, u)" in message


def test_examples_are_needed():
    with pytest.raises(RegistrationError, match=r"EXAMPLES is missing: .* \(Lambert\(\),\)"):
        registered(LAMBERT.replace("EXAMPLES = (Lambert(), Lambert(reflectance=1.0))", ""))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"lambert"', '"diffuse"', "diffuse is a name of alight's own: choose another one"),
        ('"lambert"', '"My Lambert"', 'must be of the form my_name, got "My Lambert"'),
        ('"reflectance": 3', '"reflectance": "x"', "SLOTS must map names to how many numbers"),
        ("Lambert(reflectance=1.0))", "*[Lambert()] * 6)", "must be 1 to 6 descriptions, got 7"),
    ],
)
def test_names_slots_and_examples_are_checked(old, new, message):
    assert old in LAMBERT
    with pytest.raises(RegistrationError) as caught:
        registered(LAMBERT.replace(old, new))
    assert message in str(caught.value)


def test_shapes_and_lights_need_what_their_place_asks_for():
    class Blob(Shape):
        type: Literal["blob"] = "blob"

    class Glow(Light):
        placement: ClassVar[Literal["node", "shape", "environment"]] = "shape"
        type: Literal["glow"] = "glow"

    with pytest.raises(RegistrationError, match=r"intersect\(data, k, o, d, t_max\) is missing"):
        alight.register(types.SimpleNamespace(EXAMPLES=(Blob(),)))
    point = vars(Models("lights")["point"])
    space = {**point, "EXAMPLES": (Glow(),), "DELTA": True}
    with pytest.raises(RegistrationError) as caught:
        alight.register(types.SimpleNamespace(**space))
    assert "emitted(scene, index, surface, wo) is missing" in str(caught.value)
    assert 'rays hit a light of placement "shape": DELTA must be False' in str(caught.value)
    with pytest.raises(RegistrationError, match="a model is a module, a class or a namespace"):
        alight.register(3.0)


def names_of_one_number():
    """Two names with the same number: by the birthday paradox among a few hundred."""
    by_number = {}
    for k in range(2000):
        # Checksums of neighbouring texts never agree.
        name = f"lambert_{hashlib.sha256(bytes([k % 256, k // 256])).hexdigest()[:6]}"
        by_number.setdefault(user_number(name), []).append(name)
    return next(names for names in by_number.values() if len(names) > 1)[:2]


def test_two_models_never_share_a_number():
    first, second = names_of_one_number()
    registered(LAMBERT.replace('"lambert"', f'"{first}"'))
    with pytest.raises(RegistrationError, match=f"{second} has the number of {first}, which is"):
        registered(LAMBERT.replace('"lambert"', f'"{second}"'))
    assert second not in Models("bsdfs")
    unregister("bsdfs", first)
    registered(LAMBERT.replace('"lambert"', f'"{second}"'))


def test_rows_of_shapes_are_as_long_as_kernels_read():
    class Marble(Shape):
        type: Literal["marble"] = "marble"

    sphere = vars(Models("shapes")["sphere"])
    for size, text in (
        (MOST_NUMBERS, ""),
        (MOST_NUMBERS + 1, "ball\n  the row of a marble must hold at most 64 numbers, got 65"),
    ):

        def pack(spec, matrix, size=size):
            row = sphere["pack"](sphere["EXAMPLES"][0], matrix)
            return np.pad(row, (0, size - row.size))

        alight.register(types.SimpleNamespace(**{**sphere, "EXAMPLES": (Marble(),), "pack": pack}))
        text_of_scene = (SCENE % "diffuse").replace("sphere, center: [0, 1, 0]", "marble")
        flat = flatten(loads(text_of_scene.replace(", reflectance: [0.9, 0.5, 0.1]", "")))
        if text:
            with pytest.raises(SceneError) as caught:
                compile_shapes(flat)
            assert str(caught.value) == text
        else:
            compile_shapes(flat)


# ---------------------------------------------------------------- the command line


def invoke(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


def test_plugins_of_the_command_line(tmp_path):
    script, scene = tmp_path / "my_model.py", tmp_path / "scene.yaml"
    script.write_text(LAMBERT + "\nimport alight\nalight.register(__name__)\n")
    scene.write_text(SCENE % "lambert")
    done = invoke("trace", scene, "--plugin", script, "--pixel", "8,5")
    assert done.exit_code == 0, done.output
    assert "lambert" in done.output
    unregister("bsdfs", "lambert")
    done = invoke("trace", scene, "--pixel", "8,5")
    assert done.exit_code == 2 and 'unknown bsdf "lambert"' in done.output


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "there is no file"),
        ("x = 1\n", "registers nothing; end it with alight.register(__name__)"),
        ("x = 1\ny = 1 / 0\n", "my_model.py:2: ZeroDivisionError: division by zero"),
        ("x = = 1\n", "my_model.py:1: SyntaxError"),
        ("import alight\nalight.register(__name__)\n", "EXAMPLES is missing"),
    ],
)
def test_wrong_plugins_get_a_message(tmp_path, text, message):
    script = tmp_path / "my_model.py"
    if text is not None:
        script.write_text(text)
    done = invoke("trace", "cornell-box", "--plugin", script, "--pixel", "1,1")
    assert done.exit_code == 2 and message in done.output, done.output


# ---------------------------------------------------------------- kernels that are wrong


def test_what_no_kernel_can_hold_is_told_when_it_is_registered():
    with pytest.raises(RegistrationError) as refused:
        registered(LAMBERT.replace("INV_PI * wi.z", "INV_PIE * wi.z").replace("SLOTS", "SLOT"))
    assert 'the name "INV_PIE" is not defined' in str(refused.value)
    assert "SLOTS is missing; is it SLOT?" in str(refused.value)
