"""The program `alight`: its commands, and what they share.

Heavy modules are imported inside the commands, so that help is there at once.
"""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from alight import __version__
from alight.cli import cluster as cluster_commands
from alight.cli.check import MutantCommand, check
from alight.cli.compare import compare
from alight.cli.convert import convert
from alight.cli.doctor import doctor
from alight.cli.guide import guide
from alight.cli.info import info
from alight.cli.merge import merge
from alight.cli.models import models
from alight.cli.plan import plan
from alight.cli.reference import reference
from alight.cli.render import render
from alight.cli.reporting import reporting_errors
from alight.cli.resume import resume
from alight.cli.scene import random
from alight.cli.scenes import scenes
from alight.cli.sheet import sheet
from alight.cli.study import study
from alight.cli.tonemap import tonemap
from alight.cli.trace import trace
from alight.cli.view import view
from alight.cli.warm import warm
from alight.cli.why import why

#: What people may look for among the commands, and what it is called here.
ELSEWHERE = {
    "animate": 'an animation is "alight render SCENE --frames 0:120" or "--turntable"',
}


class Commands(TyperGroup):
    """The commands, and where to find what is none."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find the command that the first word names."""
        if args[0] in ELSEWHERE and args[0] not in self.commands:
            ctx.fail(f"No such command '{args[0]}': {ELSEWHERE[args[0]]}.")
        return super().resolve_command(ctx, args)


app = typer.Typer(
    name="alight",
    cls=Commands,
    help="Physically based rendering with error bars.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

for command in (
    render,
    plan,
    resume,
    merge,
    tonemap,
    info,
    convert,
    trace,
    scenes,
    models,
    sheet,
    study,
    reference,
    compare,
    doctor,
    warm,
    why,
    guide,
    view,
):
    app.command()(reporting_errors(command))
app.command(cls=MutantCommand)(reporting_errors(check))

scene = typer.Typer(name="scene", help="Generate scenes.", no_args_is_help=True)
scene.command()(reporting_errors(random))
app.add_typer(scene)

cluster = typer.Typer(name="cluster", help="Clusters of many machines.", no_args_is_help=True)
for command in (cluster_commands.keys, cluster_commands.status):
    cluster.command()(reporting_errors(command))
app.add_typer(cluster)


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"alight {__version__}")
        raise typer.Exit


@app.callback()
def main(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show version.")
    ] = False,
) -> None:
    """Physically based rendering with error bars."""
