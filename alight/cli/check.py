"""``alight check``: the laws of light transport, tested on a user's own scene and models."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from alight.cli import arguments
from alight.cli.render import DEFAULT_SCENE

if TYPE_CHECKING:
    from alight.laws.scene import Verdict

#: The value of ``--mutant`` without a name.
LIST = "list"


class MutantCommand(TyperCommand):
    """Lets ``--mutant`` come without a name, to list them."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Add the name `LIST` where there is none."""
        words = []
        for word, after in zip(args, [*args[1:], "-"], strict=True):
            words.append(word)
            if word == "--mutant" and after.startswith("-"):
                words.append(LIST)
        return super().parse_args(ctx, words)


def check(
    scene: arguments.SceneName = DEFAULT_SCENE,
    output: Annotated[
        Path,
        typer.Option("-o", "--output", metavar="FOLDER", help="Folder for pictures of failures."),
    ] = Path("check-failures"),
    level: Annotated[
        float, typer.Option(help="Probability that a scene without a bug fails.")
    ] = 0.01,
    only: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES",
            help="Comma-separated: materials, lights, numbers, paths, pictures, accelerators.",
            show_default="all",
        ),
    ] = None,
    mutant: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Plant a classic bug first; without a name, list them."),
    ] = None,
    seed: arguments.Seed = 0,
    assignments: arguments.Assignments = None,
    plugin: arguments.Plugins = None,
    define: arguments.Definitions = None,
    lenient: arguments.Lenient = False,
    root: arguments.Root = None,
    quiet: arguments.Quiet = False,
) -> None:
    """Test a scene: materials, lights, random numbers, and that all methods give one picture.

    Exit code 1 if something fails.
    """
    from alight.cli.loading import load_scene
    from alight.cli.options import parse_names
    from alight.cli.reporting import warn
    from alight.core.errors import OptionError
    from alight.laws.scene.check import PARTS, check_scene
    from alight.laws.scene.dump import write_failures

    if mutant == LIST:
        from alight.laws.mutants import mutant_lines

        typer.echo("\n".join(mutant_lines()))
        return
    if not 0.0 < level < 1.0:
        raise OptionError(f"--level: must be a number between 0 and 1, got {level:g}")
    if mutant is not None:
        options = [
            *_repeated("--set", assignments), *_repeated("--plugin", plugin),
            *_repeated("-D", define), *(["--lenient"] if lenient else []),
            *_repeated("--root", None if root is None else [root]),
            *(["--quiet"] if quiet else []), *(["--only", only] if only else []),
        ]  # fmt: skip
        numbers = ["--level", repr(level), "--seed", str(seed), "-o", str(output)]
        _check_mutant(mutant, ["check", scene, *numbers, *options])
        return
    description = load_scene(
        scene, assignments or (), plugin=plugin, define=define, lenient=lenient, root=root
    )
    for warning in description.warnings:
        warn(warning)
    begin = time.perf_counter()

    def progress(text: str) -> None:
        if not quiet:
            typer.echo(f"{time.perf_counter() - begin:5.1f} s  {text}", err=True)

    parts = parse_names(only) or PARTS
    verdict = check_scene(description, level=level, seed=seed, only=parts, progress=progress)
    for line in verdict_lines(verdict, quiet):
        typer.echo(line)
    for path in write_failures(verdict, output):
        typer.echo(f"picture: {path}")
    if not verdict.ok:
        raise typer.Exit(1)


def _check_mutant(name: str, words: list[str]) -> None:
    """Run a command line in a copy of alight with the bug."""
    from alight.laws.mutants import find_mutant, run_with

    found = find_mutant(name)
    typer.echo(f"planted: {found.words}", err=True)
    code = run_with(found, words)
    if code == 0:
        typer.echo(f"not found: {name} shows {found.shows}")
    raise typer.Exit(code)


def _repeated(option: str, values: Sequence[object] | None) -> list[str]:
    return [word for value in values or () for word in (option, str(value))]


def verdict_lines(verdict: Verdict, quiet: bool = False) -> list[str]:
    """The table: a line for each law, those that fail marked; with `quiet` only these."""
    rows = []
    for finding, p in zip(verdict.findings, verdict.corrected, strict=True):
        bad = finding in verdict.failures
        if quiet and not bad:
            continue
        judged = finding.p is not None or finding.holds is not None
        mark = "BAD" if bad else "ok" if judged else "--"
        shown = "" if p is None else "<1e-99" if p < 1e-99 else f"{p:.2g}"
        rows.append((mark, shown, finding.part, finding.law, finding.detail))
    width = max((len(row[2]) for row in rows), default=0)
    lines = [f"     p        {'part':<{width}}  law"] if rows else []
    for mark, shown, part, law, detail in rows:
        tail = f"  ({detail})" if detail else ""
        lines.append(f"{mark:<4} {shown:<8} {part:<{width}}  {law}{tail}")
    tests = sum(finding.p is not None for finding in verdict.findings)
    laws, failed = len(verdict.findings), len(verdict.failures)
    lines.append(
        f"{laws} laws, {failed} broken; {tests} p-values corrected together (Holm), "
        f"false alarm at {100 * verdict.level:g} %"
    )
    return lines
