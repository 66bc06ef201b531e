"""Write docs/commands.md: every command with its help, as the terminal shows it.

Usage: python docs/site/command_page.py
"""

import re
import sys
from pathlib import Path

from typer.main import get_command
from typer.testing import CliRunner

from alight.cli.main import app

PAGE = Path(__file__).resolve().parents[1] / "commands.md"
WIDTH = 100
HEAD = """# Commands

Every command of `alight` with its help, as its option `--help` shows it. The options of a render
are [those of Python](api/render.md).
"""


def commands() -> list[list[str]]:
    """The words of all commands, those of two words too."""
    found = []
    for name, command in sorted(get_command(app).commands.items()):
        below = sorted(getattr(command, "commands", {}))
        found += [[name, one] for one in below] or [[name]]
    return found


def help_of(words: list[str]) -> str:
    """What a terminal of `WIDTH` columns shows."""
    shown = CliRunner().invoke(
        app, [*words, "--help"], prog_name="alight",
        env={"COLUMNS": str(WIDTH), "TERMINAL_WIDTH": str(WIDTH), "NO_COLOR": "1", "TERM": "dumb"},
    )  # fmt: skip
    plain = re.sub(r"\x1b\[[0-9;]*m", "", shown.output)
    lines = [line.rstrip() for line in plain.splitlines()]
    return "\n".join(lines).strip("\n")


def page() -> str:
    """The whole page."""
    parts = [
        f"## alight {' '.join(words)}\n\n```text\n{help_of(words)}\n```\n" for words in commands()
    ]
    return "\n".join([HEAD, *parts])


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    sys.stdout.write(f"{PAGE}\n")
