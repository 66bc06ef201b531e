"""Tables of options: what a word and a keyword mean is the same, and what neither means, too."""

import dataclasses
import re
from pathlib import Path

import pytest
import typer

import alight
from alight import filters, integrators, samplers, tone_curves
from alight.cli.words import takes_words
from alight.core.errors import OptionError
from alight.options import animation, laboratory, render, resume, view
from alight.options.kinds import Anything, File, Files
from alight.options.render import RenderOptions
from alight.options.resume import ResumeOptions
from alight.options.table import PANELS, Options, documented
from alight.rendering.schedules.schedule import Uniform
from alight.rendering.schedules.stopping import Promise
from tests.options.examples import WRONG, example

TABLES = [
    render.RenderOptions, render.DisplayOptions, resume.ResumeOptions,
    laboratory.InfoOptions, laboratory.PlanOptions, laboratory.CheckOptions,
    laboratory.WhyOptions, laboratory.GuideOptions, laboratory.CompareOptions,
    laboratory.StudyOptions, laboratory.TraceOptions, laboratory.ReferenceOptions,
    laboratory.ConvertOptions, animation.AnimationOptions, view.ViewOptions,
]  # fmt: skip
OPTIONS = [(table, name) for table in TABLES for name in table.options()]
IDS = [f"{table.__name__}.{name}" for table, name in OPTIONS]
TYPED = [(t, n) for t, n in OPTIONS if not isinstance(t.options()[n].kind, Anything)]
TYPED_IDS = [f"{table.__name__}.{name}" for table, name in TYPED]


def test_every_table_is_here():
    def below(table):
        return {table}.union(*(below(one) for one in table.__subclasses__()))

    used = {t for t in below(Options) if t.__module__.startswith("alight.") and t is not Options}
    parts = {base for table in used for base in table.__mro__[1:]}
    assert used - parts <= set(TABLES)


@pytest.mark.parametrize(("table", "name"), OPTIONS, ids=IDS)
def test_an_option_says_what_it_is_and_its_default_is_allowed(table, name):
    one = table.options()[name]
    assert one.help.endswith(".")
    assert one.panel in PANELS
    one.check(one.default)
    assert one.check(one.check(one.default)) == one.check(one.default)
    assert bool(one.flags) != isinstance(one.kind, Anything) or name == "spp_per_pass"


@pytest.mark.parametrize(
    ("name", "family"),
    [("integrator", integrators), ("sampler", samplers), ("filter", filters),
     ("tone_map", tone_curves)],
)  # fmt: skip
def test_help_names_every_model_that_comes_with_alight(name, family):
    """Help is printed without importing kernels, so that it cannot ask the registry itself."""
    told = set(re.findall(r"\w+", render.RenderOptions.options()[name].help))
    own = [one for one in family.MODELS if one.__name__.startswith("alight.")]
    assert own
    assert {one.EXAMPLES[0].type_name() for one in own} <= told


@pytest.mark.parametrize(("table", "name"), TYPED, ids=TYPED_IDS)
def test_what_is_written_is_read_again(table, name):
    one = table.options()[name]
    value = one.check(example(one))
    assert value != one.check(one.default)
    assert one.check(value) == value
    if not isinstance(one.kind, File | Files):
        given = example(one)
        assert value == (tuple(given) if isinstance(given, list) else given)
    if one.flags and not one.kind.is_repeated and type(value) is not bool:
        assert one.parse(one.kind.write(value)) == value


@pytest.mark.parametrize(("table", "name"), TYPED, ids=TYPED_IDS)
def test_a_command_line_gives_the_options_back(table, name):
    """What `words` writes, a command reads."""
    one = table.options()[name]
    if not one.flags:
        return
    values = {name: example(one)} | ({"error": 0.1} if name == "max_spp" else {})
    asked, read = table(**values), []
    app = typer.Typer()
    app.command()(takes_words(table)(lambda options: read.append(options)))
    typer.main.get_command(app)(asked.words(), standalone_mode=False)
    assert read == [asked]


CASES = [
    pytest.param(table, name, python, text, id=f"{table.__name__}.{name}-{python!r}")
    for table, name in TYPED
    for python, text in WRONG[type(table.options()[name].kind)]
]


@pytest.mark.parametrize(("table", "name", "python", "text"), CASES)
def test_a_wrong_value_has_one_message(table, name, python, text):
    one = table.options()[name]
    with pytest.raises(OptionError) as refused:
        table(**{name: python})
    assert str(refused.value).startswith(f"{name}: must ") or "unknown" in str(refused.value)
    if text is not None and one.flags:
        with pytest.raises(OptionError) as typed:
            table.parsed({name: text})
        assert str(typed.value) == str(refused.value)
        assert typed.value.spelled(lambda _: one.spelling).startswith(f"{one.spelling}: ")


def test_a_misspelt_keyword_names_the_nearest():
    with pytest.raises(OptionError, match='unknown option "sppp"; did you mean "spp"'):
        alight.render("cornell-box", sppp=4)
    with pytest.raises(OptionError, match='unknown option "sead"; did you mean "seed"'):
        alight.RenderOptions().changed(sead=4)


def test_contradictions_are_refused_in_the_words_of_the_user():
    for words, message in {
        ("error", "spp"): "error and spp contradict each other; the limit is max_spp",
        ("max_spp",): "max_spp limits error; without it, give spp",
    }.items():
        with pytest.raises(OptionError) as refused:
            alight.RenderOptions(**dict.fromkeys(words, 1))
        assert str(refused.value) == message
        spelled = refused.value.spelled(lambda name: f"--{name.replace('_', '-')}")
        assert spelled == message.replace("max_spp", "--max-spp").replace(
            "error", "--error"
        ).replace(" spp", " --spp")
    with pytest.raises(OptionError, match=r"schedule decides itself .* leave out error"):
        alight.RenderOptions(schedule=Uniform(0, 4), error=0.1)
    for name, value in {"spp": 8, "max_spp": 8, "error": 0.1, "promise": Promise(0.1)}.items():
        with pytest.raises(OptionError, match=rf"schedule decides itself .* leave out {name}"):
            ResumeOptions(schedule=Uniform(0, 4), **{name: value})


def test_options_cannot_be_changed_but_copied():
    options = alight.RenderOptions(spp=4)
    with pytest.raises(dataclasses.FrozenInstanceError):
        options.spp = 8
    assert options.changed(seed=1) == alight.RenderOptions(spp=4, seed=1)
    assert options.given() == {"spp": 4}


@pytest.mark.parametrize("table", TABLES)
def test_the_documentation_names_every_option(table):
    text = documented(table)
    for name, one in table.options().items():
        assert f"\n{name} : " in text
        assert " ".join(one.help.split()[:2]).rstrip(".") in " ".join(text.split())
    assert text in table.__doc__


def test_a_size_on_paper_becomes_pixels_once():
    options = RenderOptions(size="3.5x2.5in", dpi=200)
    assert options.size == options.changed(spp=4).size == (700, 500)
    assert RenderOptions(size="2.54x5.08cm").size == (300, 600)
    assert RenderOptions(size="640x360", dpi=200).size == (640, 360)


def test_a_transparent_background_asks_for_what_it_takes():
    options = RenderOptions(background="transparent", aovs="albedo")
    assert options.aovs == options.changed(spp=4).aovs == ("albedo", "alpha")
    assert options.assignments() == ["integrator.hide_emitters=true"]
    options = RenderOptions(background="shadow", aovs="shadow,albedo")
    assert options.aovs == options.changed(spp=4).aovs == ("shadow", "albedo", "alpha")
    assert options.assignments() == ["integrator.hide_emitters=true"]


@pytest.mark.parametrize("table", TABLES)
def test_what_only_python_has_goes_last(table):
    has_flags = [bool(one.flags) for one in table.options().values()]
    assert has_flags == sorted(has_flags, reverse=True)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("progress", 3), ("cancel", 3), ("schedule", 3), ("notes", 3), ("notes", {"a": object()}),
        ("notes", {"a": Path("b")}),
    ],
)  # fmt: skip
def test_objects_that_would_end_a_render_in_its_midst_are_refused_before(name, value):
    with pytest.raises(OptionError, match=f"^{name}: must be "):
        RenderOptions(**{name: value})
