"""The functions of Python and the commands: the same words, samples, texts and messages."""

import inspect
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from typer.main import get_command
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.core.errors import OptionError
from alight.films import Film
from alight.options import animation, laboratory, render, resume

#: Commands with a function of Python, and their tables.
ENTRIES = {
    "render": render.RenderOptions,
    "resume": resume.ResumeOptions,
    "info": laboratory.InfoOptions,
    "plan": laboratory.PlanOptions,
    "check": laboratory.CheckOptions,
    "why": laboratory.WhyOptions,
    "guide": laboratory.GuideOptions,
    "compare": laboratory.CompareOptions,
    "study": laboratory.StudyOptions,
    "trace": laboratory.TraceOptions,
}

#: What only a terminal has: how much is printed, in which form, and other programs that are run.
TERMINAL = {"quiet", "as_json", "help", "list_ready", "mutant"}


#: Words of a command that are keywords of another function: `alight.animate`.
ALSO = {"render": animation.AnimationOptions}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words, code=0):
    result = CliRunner().invoke(app, [str(word) for word in words])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == code, result.output
    return result


# ---------------------------------------------------------------------------- names


@pytest.mark.parametrize("name", ENTRIES)
def test_every_word_of_a_command_is_a_keyword_and_the_reverse(name):
    parameters = get_command(app).commands[name].params
    words = {p.name for p in parameters if p.param_type_name == "option"} - TERMINAL
    subjects = {"pixel"} & words
    table = ENTRIES[name].options()
    told = {**table, **ALSO.get(name, ENTRIES[name]).options()}
    assert words - subjects == {one.name for one in told.values() if one.flags}
    keywords = inspect.signature(getattr(alight, name)).parameters
    keyword_only = {n for n, p in keywords.items() if p.kind is p.KEYWORD_ONLY}
    assert keyword_only == set(table)
    assert subjects <= set(keywords)
    for p in parameters:
        if p.name in table:
            assert set(table[p.name].flags) == {*p.opts, *p.secondary_opts} or (
                "/".join([*p.opts, *p.secondary_opts]) == table[p.name].flags[0]
            )
            assert p.help == table[p.name].help


@pytest.mark.parametrize("name", ENTRIES)
def test_the_documentation_of_a_function_names_its_keywords(name):
    text = getattr(alight, name).__doc__
    assert "{options}" not in text
    for keyword in inspect.signature(getattr(alight, name)).parameters:
        assert re.search(rf"^{keyword} : ", text, re.MULTILINE), keyword


def test_the_tables_are_light():
    """`alight --help` reads them all."""
    code = (
        "import alight.cli.main, sys; "
        "print(set(sys.modules) & {'numba', 'pydantic', 'numpy', 'yaml', 'alight.scene'})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


# ---------------------------------------------------------------------------- the same samples

RENDERS = {
    "plain": {"spp": 4},
    "seed and replicates": {"spp": 6, "seed": 5, "replicates": 3, "first_sample": 2},
    "keys of the scene": {"spp": 2, "integrator": "direct", "sampler": "independent",
                          "filter": "tent", "crop": (8, 0, 8, 8),
                          "changes": ["bsdfs.white.reflectance=[0.5, 0.5, 0.5]"]},
    "an error": {"error": 0.5, "max_spp": 64},
    "adaptive": {"spp": 16, "adaptive": True, "aovs": ("depth",)},
    "of a pixel": {"error": 0.5, "metric": "pixel", "share": 0.9, "confidence": 0.9, "max_spp": 40},
}  # fmt: skip


@pytest.mark.parametrize("words", RENDERS.values(), ids=RENDERS.keys())
def test_both_ways_give_the_same_film(words, folder):
    options = alight.RenderOptions(size=(24, 16), threads=1, **words)
    run("render", "cornell-box", *options.words(), "-o", "a.alight", "-q")
    by_command = Film.load("a.alight")
    film = alight.render("cornell-box", options)
    changed = alight.render(alight.load("cornell-box"), size=(24, 16), threads=1, **words)
    for other in (film, changed):
        np.testing.assert_array_equal(other.sums, by_command.sums)
        np.testing.assert_array_equal(other.counts, by_command.counts)
        assert other.scene_hash == by_command.scene_hash
        assert other.aov_channels == by_command.aov_channels


def test_files_are_written_as_the_command_writes_them(folder):
    words = {"spp": 2, "size": 16, "exposure": "1", "tone_map": "reinhard", "threads": 1}
    (folder / "python").mkdir()
    outputs = ["python/a.png", "python/a.exr"]
    alight.render("cornell-box", output=outputs, stats="python/s.json", **words)
    run("render", "cornell-box", *alight.RenderOptions(**words).words(), "-o", "a.png", "-o",
        "a.exr", "--stats", "s.json", "-q")  # fmt: skip
    assert (folder / "a.png").read_bytes() == (folder / "python/a.png").read_bytes()
    assert (folder / "a.exr").read_bytes() == (folder / "python/a.exr").read_bytes()
    assert (folder / "python/s.json").exists()
    assert alight.render("cornell-box", **words).spp == 2
    assert sorted(path.name for path in folder.iterdir()) == ["a.exr", "a.png", "python", "s.json"]


def test_a_wrong_file_costs_no_time(folder, monkeypatch):
    monkeypatch.setattr("alight.rendering.main_loop.render_film", None)
    with pytest.raises(alight.OutputError, match=r'unknown suffix ".pgn"'):
        alight.render("cornell-box", output="a.pgn")
    with pytest.raises(OptionError, match='unknown tone map "acess"'):
        alight.render("cornell-box", tone_map="acess")


def test_what_only_says_how_a_file_is_read_is_refused_for_a_scene():
    with pytest.raises(OptionError, match="lenient: the scene is loaded already"):
        alight.render(alight.load("cornell-box"), lenient=True)


def test_a_changed_scene_is_found_again_from_its_checkpoint(folder):
    scene = alight.load("cornell-box", ["film.size=[16, 16]"])
    alight.render(scene, spp=2, integrator="direct", checkpoint="c.alight", threads=1)
    film = alight.resume("c.alight", spp=4, threads=1)
    whole = alight.render(scene, spp=4, integrator="direct", threads=1)
    np.testing.assert_array_equal(film.sums, whole.sums)


# ---------------------------------------------------------------------------- the same texts


class Page(HTMLParser):
    """Checks that every element is closed in turn, and keeps the text."""

    def __init__(self):
        super().__init__()
        self.open, self.text, self.pictures = [], "", 0

    def handle_starttag(self, tag, attrs):
        if tag == "img":
            self.pictures += 1
            assert dict(attrs)["src"].startswith("data:image/png;base64,")
            assert dict(attrs)["alt"]
        elif tag != "br":
            self.open.append(tag)
        assert tag != "b", "a name was not escaped"

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data

    @classmethod
    def of(cls, thing):
        page = cls()
        page.feed(thing._repr_html_())
        page.close()
        assert not page.open
        return page


NAMED = """alight: 1
camera: {{type: pinhole, transform: {{translate: [0, 0, 4]}}}}
film: {{size: [24, 24]}}
environment: {{type: constant, radiance: 0.2}}
bsdfs: {{"<b>{name}": {{type: diffuse}}}}
nodes:
  "<b>ball": {{shape: sphere, bsdf: "<b>{name}"}}
  "<b>lamp":
    {{shape: disk, light: {{type: area, radiance: 9}}, transform: {{translate: [0, 0, 3]}}}}
"""


@pytest.fixture
def named(folder):
    """A scene whose names would be markup if nobody escaped them."""
    (folder / "a.yaml").write_text(NAMED.format(name="white"), encoding="utf-8")
    return "a.yaml"


def test_info_prints_and_shows_the_same(named):
    found, seconds = alight.info(named, tree=True), r"seconds \S+"
    printed = run("info", named, "--tree").stdout
    assert re.sub(seconds, "", printed) == re.sub(seconds, "", f"{found}\n")
    page = Page.of(found)
    assert "<b>ball" in page.text
    assert dict(found.facts)["shapes"] in page.text
    dark = NAMED.format(name="white").split('  "<b>lamp"')[0].replace("environment", "#")
    Path("dark.yaml").write_text(dark, encoding="utf-8")
    found = alight.info("dark.yaml")
    assert found.remarks() == run("info", "dark.yaml").stderr.splitlines()
    assert "warning: the scene has no light" in Page.of(found).text


def test_plan_prints_and_shows_the_same(folder, monkeypatch):
    from alight.metrics.estimate import Estimate
    from alight.rendering import plan as module

    module = sys.modules[module.__module__] if callable(module) else module
    made = module.Plan(Estimate(100, 80, 130), Estimate(3, 2, 5), Estimate(-1, -1, -1), 0.05, 64, 2)
    monkeypatch.setattr(module, "make_plan", lambda *_, **__: made)
    assert run("plan", "cornell-box").stdout == f"{made}\n"
    assert alight.plan("cornell-box", error="3%") is made
    assert "100 per pixel (95 %: 80 to 130)" in Page.of(made).text


def test_check_prints_and_shows_the_same(named):
    verdict = alight.check(named, only="materials")
    assert run("check", named, "--only", "materials").stdout == f"{verdict}\n"
    assert bool(verdict)
    assert "material <b>white" in Page.of(verdict).text


def test_broken_laws_are_shown_with_their_pictures(folder):
    from alight.laws.scene import Finding, Verdict

    sides = {"a": np.full((4, 6, 3), 0.5), "b": np.full((4, 6, 3), 0.6), "z": np.full((4, 6), 3.0)}
    bad = [Finding("<b>part", law, holds=False, pictures=sides) for law in ("one", "two")]
    verdict = Verdict((*bad, Finding("fine", "three", p=0.5)), 0.01)
    page = Page.of(verdict)
    # Two laws of the same pictures share one.
    assert page.pictures == 1
    assert "<b>part: one" in page.text
    assert str(verdict).count("BAD") == 2
    assert "fine" not in "\n".join(verdict.lines(failures_only=True))


def test_why_prints_and_shows_the_same(named):
    words = {"size": 16, "spp": 32, "measure": False}
    found = alight.why(named, **words)
    printed = run("why", named, "--size", 16, "--spp", 32, "--no-measure", "-q").stdout
    assert printed == f"{found}\nmaps: a.why.png\n"
    page = Page.of(found)
    assert page.pictures == 1
    assert "by light" in page.text
    assert "<b>" in page.text


def test_compare_prints_and_shows_the_same(folder):
    films = [alight.render("cornell-box", spp=8, size=32, seed=s, threads=1) for s in (0, 1)]
    names = [film.save(f"<b>{i}.exr") for i, film in enumerate(films)]
    found = alight.compare(*names, flip=False, fail_above="mse=0")
    printed = run("compare", *names, "--no-flip", "--fail-above", "mse=0", code=1)
    assert printed.stdout == f"{found}\n"
    assert printed.stderr == f"{found.exceeded[0]}\n"
    page = Page.of(found)
    assert page.pictures == 3
    assert "<b>0.exr against <b>1.exr" in page.text
    # A film is compared as the file that it writes, an array without its noise.
    direct = alight.compare(*films, flip=False)
    assert direct.to_dict() == {**found.to_dict(), "a": "A", "b": "B"} | {
        key: direct.to_dict()[key] for key in ("notes", "test") if key in direct.to_dict()
    }
    bare = alight.compare(films[0].image, films[1].image, flip=False)
    assert bare.found[0].errors == found.found[0].errors
    assert bare.found[0].agreement is None
    with pytest.raises(OptionError, match="fail_above: unknown figure"):
        alight.compare(*films, fail_above="mze=1")


def test_study_prints_and_shows_the_same(folder):
    (folder / "mine.yaml").write_text(
        "title: <b>mine\n"
        "scenes: [{scene: cornell-box, label: <b>box, set: {film.size: [16, 16]}}]\n"
        "arms: {even: {}, other: {light_sampling: bsdf}}\nspp: [4, 8]\nreplicates: 8\n"
        "equal_time: false\n",
        encoding="utf-8",
    )
    found = alight.study("mine.yaml", quick=True, threads=1)
    page = Page.of(found)
    assert page.pictures == 3
    assert "<b>box, 16x16" in page.text
    assert found.page.exists()
    again = run("study", "mine.yaml", "--quick", "--threads", 1, "-q")
    assert again.stdout == ""
    printed = run("study", "mine.yaml", "--quick", "--threads", 1).stdout
    # What was measured is used again; only this run's own times differ.
    told = re.sub("CPU seconds.*", "", str(found)).replace("reference rendered", "reference cached")
    assert re.sub("CPU seconds.*", "", printed) == f"{told}\n"


def test_trace_prints_and_shows_the_same(named):
    found = alight.trace(named, (12, 12), sample=3)
    assert run("trace", named, "--pixel", "12,12", "--sample", 3).stdout == f"{found}\n"
    assert "<b>lamp" in Page.of(found).text


# ---------------------------------------------------------------------------- the same messages

MISTAKES = [
    ("render", {"spp": 0}), ("render", {"error": "much"}), ("render", {"confidence": 2.0}),
    ("render", {"metric": "psnr"}), ("render", {"every": "soon"}), ("render", {"time_limit": 0}),
    ("render", {"aovs": "albdo"}), ("render", {"size": "big"}), ("render", {"criterion": "none"}),
    ("render", {"max_spp": 3}), ("plan", {"error": 11.0}), ("check", {"level": 1.0}),
    ("check", {"only": "material"}), ("why", {"spp": 16}), ("why", {"size": 4}),
    ("trace", {"sample": -1}), ("info", {"plugins": "none.py"}),
]  # fmt: skip


@pytest.mark.parametrize(("name", "words"), MISTAKES)
def test_a_mistake_has_one_message_in_both(name, words, folder):
    subjects = ["cornell-box", *([(0, 0)] if name == "trace" else [])]
    with pytest.raises(OptionError) as refused:
        getattr(alight, name)(*subjects, **words)
    table = ENTRIES[name].options()
    flags = [x for k, v in words.items() for x in (table[k].spelling, v)]
    typed = run(
        name, "cornell-box", *(["--pixel", "0,0"] if name == "trace" else []), *flags, code=2
    )
    spelled = refused.value.spelled(lambda option: table[option].spelling)
    assert typed.stderr == f"error: {spelled}\n"
