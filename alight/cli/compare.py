"""``alight compare``: two pictures of any renderer, in figures and side by side."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from alight.lab.compare import PictureComparison

#: Exit code when a limit is exceeded.
FAILED = 1


def compare(
    a: Annotated[Path, typer.Argument(metavar="A", help="EXR, PNG, JPEG, NPY, HDR or PFM file.")],
    b: Annotated[Path, typer.Argument(metavar="B", help="The reference of relative figures.")],
    reference: Annotated[
        Path | None, typer.Option(help="Compare A and B each with this picture.")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help=".png or .html: side by side; .exr, .npy, .pfm: A - B."
        ),
    ] = None,
    layer: Annotated[str | None, typer.Option(help="Layer of EXR files, such as albedo.")] = None,
    exposure: Annotated[float, typer.Option(help="Stops, for what a display shows.")] = 0.0,
    skip_invalid: Annotated[
        bool, typer.Option("--skip-invalid", help="Ignore NaN and infinite pixels.")
    ] = False,
    flip: Annotated[bool, typer.Option(help="Compute FLIP (slow on large pictures).")] = True,
    fail_above: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FIGURE=NUMBER", help="Exit with code 1 above this, such as relmse=0.01."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")] = False,
) -> None:
    """Compare two pictures: errors, visible differences, and whether they exceed the noise."""
    from alight.lab.compare import compare_inputs, make_comparable, read_input
    from alight.lab.compare.figures import exceeded, parse_limits
    from alight.lab.compare.views import SUFFIXES, write_view
    from alight.lab.report.targets import check_target
    from alight.outputs.display import Display

    limits = parse_limits(fail_above or [])
    # Checks the exposure.
    Display(exposure)
    if output is not None:
        check_target(output, SUFFIXES, drawn=(".png", ".html"))
    paths = [a, b] if reference is None else [a, b, reference]
    inputs = make_comparable([read_input(path, layer) for path in paths], skip_invalid)
    found = [
        compare_inputs(one, inputs[-1], exposure=exposure, with_flip=flip) for one in inputs[:-1]
    ]
    failures = [text for one in found for text in exceeded(one, limits)]
    if output is not None:
        write_view(output, found, exposure)
    if as_json:
        typer.echo(json.dumps(_as_data(found), indent=1, allow_nan=False))
    else:
        for line in lines_of(found):
            typer.echo(line)
    for failure in failures:
        typer.echo(failure, err=True)
    if failures:
        raise typer.Exit(FAILED)


def _as_data(found: Sequence[PictureComparison]) -> Any:
    """One comparison, or those of both pictures with the reference."""
    data = [one.to_dict() for one in found]
    return data[0] if len(data) == 1 else {"comparisons": data}


def lines_of(found: Sequence[PictureComparison]) -> list[str]:
    """Write the figures as a table, and what they mean below it."""
    from alight.lab.compare.figures import NOT_ASKED
    from alight.lab.compare.views import figure_rows

    rows = figure_rows(found)
    if len(found) > 1:
        rows = [("", [one.a.name for one in found]), *rows]
    name_width = max(len(name) for name, _ in rows)
    widths = [max(len(values[i]) for _, values in rows) for i in range(len(found))]
    w, h = found[0].a.size
    heads = " and ".join(one.a.name for one in found)
    lines = [f"{heads} against {found[0].b.name}, {w} x {h} pixels", ""]
    for name, values in rows:
        cells = "   ".join(v.ljust(n) for v, n in zip(values, widths, strict=True))
        lines.append(f"{name.ljust(name_width)}   {cells}".rstrip())
    notes = [text for one in found for text in _notes_of(one, len(found) > 1)]
    notes += sorted({one.flip_note for one in found if one.flip_note not in ("", NOT_ASKED)})
    if len(found) == 2 and all(one.mse > 0.0 for one in found):
        ratio = found[1].mse / found[0].mse
        near = found[0] if ratio > 1.0 else found[1]
        notes.append(
            f"{near.a.name} is nearer: MSE {math.exp(abs(math.log(ratio))):.3g} times less"
        )
    return [*lines, *([""] if notes else []), *notes]


def _notes_of(comparison: PictureComparison, named: bool) -> list[str]:
    """Give what the verdict rests on, after the picture's name where there are two."""
    start = f"{comparison.a.name}: " if named else ""
    return [text if text.startswith(start) else start + text for text in comparison.notes]
