"""``python -m alight``: the command line."""

from alight.cli.main import app

app(prog_name="alight")
