"""Commands that the README tells people to type exist."""

import re
import shlex
from functools import cache

import pytest
from typer.testing import CliRunner

from alight.cli.main import app
from tests.docs.pages import PAGES, ROOT, blocks, name_of, prose


def _code(page):
    """Lines of shell blocks, and short pieces of code in the text."""
    joined = (block.replace("\\\n", " ") for block in blocks(page, "bash"))
    lines = [line for block in joined for line in block.splitlines()]
    return lines + re.findall(r"`([^`\n]+)`", prose(page))


def _commands(program):
    lines = [line.split("#")[0].strip() for page in PAGES for line in _code(page)]
    return sorted({line for line in lines if line.startswith(program + " ")})


def test_make_words_exist():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    words = {line.split()[1] for line in _commands("make") if "=" not in line.split()[1]}
    assert {"demo", "test"} <= words
    missing = {word for word in words if not re.search(rf"^{word}:", makefile, re.MULTILINE)}
    assert not missing


@cache
def _options(*name):
    """What `--help` shows of a command."""
    shown = CliRunner().invoke(app, [*name, "--help"], env={"COLUMNS": "200"})
    assert shown.exit_code == 0, name
    return re.sub(r"\x1b\[[0-9;]*m", "", shown.output)


@pytest.mark.parametrize("line", _commands("alight"))
def test_alight_commands_and_options_exist(line):
    words = shlex.split(line, comments=True)[1:]
    if words[0].startswith("-"):
        return
    # `alight scene random` is a command of two words.
    name = words[:2] if words[0] in ("scene", "cluster") else words[:1]
    shown = _options(*name)
    for option in (word.split("=")[0] for word in words[1:] if word.startswith("-")):
        assert option in shown, line


def test_readme_first_screen():
    """A picture, a sentence, two commands and six lines of Python come before all else."""
    first = (ROOT / "README.md").read_text(encoding="utf-8").split("\n## ")[0]
    assert first.index("![") < first.index("make demo") < first.index("make test")
    [python] = re.findall(r"```python\n(.*?)```", first, re.DOTALL)
    assert len(python.strip().splitlines()) <= 6


def test_every_page_has_one_title():
    for page in PAGES:
        assert len(re.findall(r"^# ", prose(page), re.MULTILINE)) == 1, name_of(page)
