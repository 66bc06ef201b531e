"""docs/commands.md has every command, and every option of it."""

import re

from typer.main import get_command

from alight.cli.main import app
from tests.docs.pages import ROOT


def test_every_command_and_option_is_on_the_page():
    text = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    section = re.compile(r"^## alight ([^\n]+)\n\n```text\n(.*?)```", re.DOTALL | re.MULTILINE)
    sections = dict(section.findall(text))
    found = {}
    for name, command in get_command(app).commands.items():
        below = getattr(command, "commands", None)
        found |= {f"{name} {k}": v for k, v in below.items()} if below else {name: command}
    assert sections.keys() == found.keys(), "python docs/site/command_page.py rewrites it"
    for name, command in found.items():
        options = [option for one in command.params for option in one.opts if option[:2] == "--"]
        listed = re.findall(r"(?<=[│ ])--[a-z][a-z-]*", sections[name])
        missing = set(options) - set(listed)
        assert not missing, f"alight {name}: python docs/site/command_page.py rewrites the page"
        assert command.help.splitlines()[0].split()[0] in sections[name]
