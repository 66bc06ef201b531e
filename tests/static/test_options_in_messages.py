"""Messages name options and commands of the command line that exist."""

import ast
import re

import pytest
from typer.main import get_command

from alight.cli.main import app
from tests.docs.pages import ROOT

#: Of other programs: what a message tells users to run, and what is run for them.
FOREIGN = {"--transcode", "--formats", "--no-dashboard", "--dashboard-address"}
FILES = sorted((ROOT / "alight").rglob("*.py"))


def texts(tree):
    """Strings of a module that are not docstrings."""
    said = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in said:
            yield node.lineno, node.value


@pytest.fixture(scope="module")
def known():
    """Options of all commands, and the commands."""
    commands = get_command(app).commands
    found = {*FOREIGN, "--version", "--help"}
    stack = list(commands.values())
    while stack:
        command = stack.pop()
        stack += getattr(command, "commands", {}).values()
        for parameter in command.params:
            found |= {*parameter.opts, *parameter.secondary_opts}
    return found, set(commands)


def test_options_and_commands_that_messages_name_exist(known):
    options, commands = known
    wrong = []
    for path in FILES:
        for line, text in texts(ast.parse(path.read_text(encoding="utf-8"))):
            named = {*re.findall(r"(?<![\w-])--[a-z][a-z-]*\b", text)} - options
            named |= {
                word
                for word in re.findall(r"(?:^|[:;,(`] ?)alight ([a-z]+) [A-Z{]", text)
                if word not in commands
            }
            wrong += [f"{path.relative_to(ROOT)}:{line} {name}" for name in named]
    assert not wrong
