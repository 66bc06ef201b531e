"""Code in the pages is right: it compiles, scenes load, and the models of extending.md work."""

import types

import numpy as np
import pytest

from alight.core.vec import Vec3
from alight.formats import loads
from alight.formats.loading import changed
from alight.rendering import main_loop
from alight.samplers.state import sampler_state
from tests.docs.pages import PAGES, ROOT, blocks, name_of

EXTENDING = ROOT / "docs" / "extending.md"
LANES = 200_000


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_python_blocks_compile(page):
    for block in blocks(page, "python"):
        compile(block, name_of(page), "exec")


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_whole_scenes_load(page):
    for block in blocks(page, "yaml"):
        if block.startswith("alight:"):
            loads(block, name_of(page))


#: Scenes by their names on the pages of their formats.
SCENES = {
    "mitsuba.md": (
        "scene.xml",
        '<scene version="3.0.0"><default name="spp" value="4"/><shape type="sphere"/></scene>',
    ),
    "pbrt.md": ("scene.pbrt", 'Camera "perspective"\nWorldBegin\nShape "sphere"\n'),
}


@pytest.mark.parametrize("page", SCENES)
def test_calls_for_files_of_others_run(page, tmp_path, monkeypatch):
    name, text = SCENES[page]
    (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    [block] = blocks(ROOT / "docs" / page, "python")
    exec(compile(block, page, "exec"), {})
    assert (tmp_path / "scene.yaml").is_file()


#: Pages whose Python shows how alight is used.
USES = ["README.md", "docs/api/laboratory.md", "docs/api/render.md", "docs/laboratory/check.md",
        "docs/laboratory/compare.md", "docs/laboratory/random-scenes.md",
        "docs/laboratory/why.md", "docs/trace.md"]  # fmt: skip


@pytest.mark.parametrize("page", USES)
def test_python_of_the_pages_runs(page, tmp_path, monkeypatch):
    """On pictures of 16x16 pixels, with a sixteenth of the samples."""
    whole = main_loop.render_film

    def small(scene, options):
        scene = changed(scene, ["film.crop=null", "film.size=[16, 16]"])
        spp = max(1, (options.spp or 64) // 16)
        return whole(scene, options.changed(spp=spp, error=None))

    monkeypatch.setattr(main_loop, "render_film", small)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.yaml").write_text("alight: 1\ncamera: {}\nenvironment: constant\n")
    for block in blocks(ROOT / page, "python"):
        exec(compile(block, page, "exec"), {})


def test_the_study_of_the_page_runs(tmp_path, monkeypatch):
    [text] = blocks(ROOT / "docs" / "studies.md", "yaml")
    # However fast the machine finds an arm, the reference knows enough to judge it.
    small = text.replace("[256, 256]}", "[16, 16]}, reference: {spp: 4096}")
    small = small.replace("[4, 16, 64]", "[2, 4]")
    assert small.count("16") == 2
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text(small, encoding="utf-8")
    [block] = blocks(ROOT / "docs" / "studies.md", "python")
    exec(compile(block, "studies.md", "exec"), {})
    assert (tmp_path / "study-mine-quick" / "report.html").is_file()


def _module(name):
    """The code block of extending.md that holds the model `name`, as a module."""
    [block] = [text for text in blocks(EXTENDING, "python") if f'type: Literal["{name}"]' in text]
    module = types.ModuleType(name)
    exec(compile(block, name, "exec"), module.__dict__)
    return module


@pytest.mark.parametrize(
    "name", ["minnaert", "downlight", "kronecker", "headlight", "exponential", "log_error"]
)
def test_models_describe_themselves(name):
    module = _module(name)
    assert 1 <= len(module.EXAMPLES) <= 6
    assert module.EXAMPLES[0].type_name() == name


def _uniform(n, seed):
    return np.random.default_rng(seed).random(n, dtype=np.float32)


@pytest.mark.parametrize("k", [1.0, 1.5, 8.0])
def test_minnaert_weight_is_value_over_density_and_energy_is_as_derived(k):
    module = _module("minnaert")
    full = np.ones(LANES, np.float32)
    params = module.Params(Vec3(full, full, full), full * np.float32(k))
    cos_o = np.float32(0.6)
    wo = Vec3(full * 0.8, full * 0.0, full * cos_o)
    u2 = _uniform(LANES, 1), _uniform(LANES, 2)
    wi, weight, pdf, _ = module.sample(params, wo, _uniform(LANES, 3), u2)
    f_cos, pdf_again = module.evaluate(params, wo, wi)
    kept = wi.z > 1e-3
    assert np.allclose(wi.x**2 + wi.y**2 + wi.z**2, 1.0, atol=1e-5)
    assert np.allclose(pdf[kept], pdf_again[kept], rtol=1e-3)
    assert np.allclose(weight.x[kept], (f_cos.x / pdf_again)[kept], rtol=1e-3)
    assert np.allclose(weight.x[kept], cos_o ** (k - 1.0), rtol=1e-4)
    # Uniform directions: the mean of 2 pi pdf is the integral of the pdf, 1.
    z = _uniform(LANES, 4)
    _, pdf = module.evaluate(params, wo, Vec3(np.sqrt(1 - z * z), full * 0.0, z))
    assert abs(2 * np.pi * pdf.mean() - 1.0) < 0.02


def test_kronecker_points_are_uniform_and_better_than_random():
    module = _module("kronecker")
    get_1d, get_2d = module.make_kernels()
    n = 4096
    zero = np.zeros(n, np.uint32)
    state = sampler_state(zero + 3, zero + 7, np.arange(n, dtype=np.uint32), zero, zero)
    points = [get_1d(state, 0), *get_2d(state, 2)]
    for x in points:
        assert x.min() >= 0.0
        assert x.max() < 1.0
        # Independent points would be off by 1 / sqrt(12 n), five times as much.
        assert abs(x.mean() - 0.5) < 0.2 / np.sqrt(12 * n)
