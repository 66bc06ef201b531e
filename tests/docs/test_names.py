"""Names, signatures and files that the pages mention in code format exist as they are written."""

import re
import tomllib
from functools import cache

import pytest

import alight
from tests.docs.names import (
    COMPILER,
    PACKAGE,
    calls,
    code_spans,
    definitions,
    fits,
    import_path,
    parameters_of,
)
from tests.docs.pages import PAGES, ROOT, blocks, name_of

#: Pages about what is; the changelog is about what was.
LIVING = [page for page in PAGES if page.name != "CHANGELOG.md"]

#: Names on the pages that belong to other programs, and what readers of extending.md write.
FOREIGN = {
    "python": "prange pyproject toml etree UnboundLocalError breakpoint",
    "mitsuba": "eval mis_em mis_bsdf sh_frame sample1 sample2 scalar_rgb load_file arealight"
    " pointlight staircase2 bsdf_spheres",
    "pbrt": "uc",
    "embree": "rtcIntersect16",
    "cryptomatte": "CryptoObject00 CryptoObject02 CryptoMaterial00 CryptoMaterial02",
    "usd": "upAxis materialBind fStop focusDistance colorTemperature treatAsPoint",
    "prefixes": "is_ has_",
    "example of lanewise.md": "escape_time mandelbrot",
    "models of extending.md": "minnaert downlight kronecker headlight exponential log_error",
}
ELSEWHERE = {word.lower() for words in FOREIGN.values() for word in words.split()}

#: What a page means by the first part of a dotted name.
VARIABLES = {"film": alight.Film, "scene": alight.Scene}


@cache
def words():
    """All words of the sources and the scenes, in lower case: MTL's keys are read so."""
    files = [ROOT / "pyproject.toml", ROOT / "mkdocs.yml"]
    for folder in ("alight", "lanewise", "benchmarks"):
        for suffix in ("py", "yaml"):
            files += (ROOT / folder).rglob(f"*.{suffix}")
    return ELSEWHERE | {
        word.lower()
        for file in files
        for word in re.findall(r"[A-Za-z_]\w*", file.read_text(encoding="utf-8"))
    }


@cache
def base_names():
    """Of all Python files of the project, and of the models that readers of extending.md write."""
    # Hidden folders are no part of it: an environment has ten thousand files.
    folders = [path for path in ROOT.iterdir() if not path.name.startswith(".")]
    found = {file.name for folder in folders for file in folder.rglob("*.py")}
    return found | {f"{word}.py" for word in FOREIGN["models of extending.md"].split()}


@pytest.mark.parametrize("page", LIVING, ids=name_of)
def test_identifiers_occur_in_the_sources(page):
    missing, known = [], words()
    if page.parent.name == "learn":
        # Lessons write their own functions, and run.
        known = known | set(re.findall(r"\w+", " ".join(blocks(page, "python")).lower()))
    for span in code_spans(page):
        name = re.fullmatch(r"([A-Za-z_]\w*(?:\.\w+)*)(?:\(.*\))?", span)
        if name and not re.match(r"test_\w+$", span) and not span.endswith((".py", ".md")):
            missing += [part for part in name[1].split(".") if part.lower() not in known]
    assert not missing


@pytest.mark.parametrize("page", LIVING, ids=name_of)
def test_dotted_names_resolve(page):
    """``alight.metrics.own_error``, ``film.standard_error``: modules, attributes and fields."""
    for span in code_spans(page):
        if (
            re.fullmatch(r"(?:alight|lanewise)(?:\.\w+)+(?:\(.*\))?", span)
            and span != "alight.biases"
        ):
            import_path(span.split("(")[0])
        name = re.fullmatch(r"(film|scene)\.(\w+)(?:\.\w+)*(?:\(.*\))?", span)
        if name and name[2] not in ("yaml", "xml", "pbrt", "usd", "glb", "exr", "obj"):
            owner = VARIABLES[name[1]]
            import_path(f"{owner.__module__}.{owner.__qualname__}.{name[2]}")


@pytest.mark.parametrize("page", LIVING, ids=name_of)
def test_calls_have_the_parameters_of_their_functions(page):
    wrong = []
    for call in calls(page):
        name, arguments = call[:-1].split("(", 1)
        last = name.split(".")[-1]
        if last.lower() in ELSEWHERE or last in ("exp", "ceil"):
            continue
        # The full path names one function; a short name may be that of any.
        known = definitions().get(last, [])
        if name.startswith(("alight.", "lanewise.")):
            known = [parameters_of(import_path(name))]
        if not any(fits(arguments, parameters) for parameters in known):
            wrong.append((call, known))
    assert not wrong


@pytest.mark.parametrize("page", LIVING, ids=name_of)
def test_python_files_exist(page):
    named = [span for span in code_spans(page) if re.fullmatch(r"[\w/]+\.py", span)]
    bases = (ROOT, PACKAGE, COMPILER, ROOT / "tests", ROOT / "benchmarks", page.parent)
    missing = [
        name
        for name in named
        if not any((base / name).exists() for base in bases)
        and ("/" in name or name not in base_names())
        and name.rsplit("/", 1)[-1].removesuffix(".py") not in ELSEWHERE
    ]
    assert not missing


def test_layers_of_the_architecture_page_are_those_of_the_contract():
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    [drawn] = re.findall(r'```text title="layers"\n(.*?)\n```', text, re.DOTALL)
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    [layers] = [contract["layers"] for contract in contracts if contract["id"] == "layers"]
    assert drawn.splitlines() == [layer.replace("alight.", "") for layer in layers]


def test_the_architecture_page_names_every_folder_of_the_package():
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    named = {name.removeprefix("alight/") for name in re.findall(r"`?([\w/]+)/(?!\w)", text)}
    folders = {
        str(path.relative_to(PACKAGE))
        for depth in ("*/", "*/*/")
        for path in PACKAGE.glob(depth)
        if path.name != "__pycache__"
    }
    assert folders - named == set()
    # Of two levels no folder is named that is not there.
    there = folders | {f"tests/{path.name}" for path in (ROOT / "tests").iterdir()}
    within = {name for name in named if "/" in name and name.split("/")[0] in folders}
    assert {name for name in within if len(name.split("/")) == 2} - there == set()


def _glossary():
    """The table rows of the glossary as {column: cell}."""
    heads, rows = [], []
    for line in (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("|"):
            heads = []
        elif not heads:
            heads = cells
        elif not set(cells[0]) <= {"-"}:
            rows.append(dict(zip(heads, cells, strict=True)))
    return rows


@pytest.mark.parametrize("row", _glossary(), ids=lambda row: row.get("term", row.get("name")))
def test_every_term_of_the_glossary_names_its_code(row):
    named = re.findall(r"`((?:alight|lanewise)[\w.]+)(?:\([^`]*\))?`", row["in code"])
    assert named
    for name in named:
        import_path(name)
