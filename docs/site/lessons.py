"""Hook of mkdocs: the code of the lessons runs when the site is built, with its output below it.

A lesson is a page of Markdown as Jupytext reads it: each fenced block of Python is a cell, and all
cells of a page share one namespace. Every lesson is offered as a notebook, too.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import linecache
import re
from functools import cache
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from mkdocs.structure.files import Files

FOLDER, OVERVIEW = "learn", "index.md"
_CELL = re.compile(r"^```python\n(.*?)^```\n", re.DOTALL | re.MULTILINE)
_SOLUTIONS = re.compile(r"^## Solutions\n", re.MULTILINE)
_SOLUTION = re.compile(r"^### (.*)\n", re.MULTILINE)


class Output(NamedTuple):
    """What a notebook shows below a cell."""

    text: str
    html: str
    figures: tuple[tuple[str, bytes], ...]


# ---------------------------------------------------------------------------------- the notebook


def cells_of(text: str) -> list[tuple[str, str]]:
    """The page as pairs of "markdown" or "code" and its source, empty ones left out."""
    pieces = _CELL.split(text)
    kinds = ["code" if k % 2 else "markdown" for k in range(len(pieces))]
    pairs = [(kind, piece.strip("\n")) for kind, piece in zip(kinds, pieces, strict=True)]
    return [(kind, piece) for kind, piece in pairs if piece]


def notebook_of(text: str) -> str:
    """The page as a Jupyter notebook (format 4.5) without outputs."""
    cells = []
    for k, (kind, source) in enumerate(cells_of(text)):
        cell: dict[str, Any] = {"cell_type": kind, "id": f"cell-{k}", "metadata": {}}
        if kind == "code":
            cell |= {"execution_count": None, "outputs": []}
        cells.append(cell | {"source": source.splitlines(keepends=True)})
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    metadata = {"kernelspec": kernel, "language_info": {"name": "python"}}
    notebook = {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(notebook, indent=1, ensure_ascii=False)


# ------------------------------------------------------------------------------------ running it


@cache
def run(text: str, name: str) -> tuple[Output, ...]:
    """Run the cells of a page in order and give what each of them shows.

    As in a notebook that is the printed text, the last expression, and the figures of Matplotlib
    that were drawn.

    Raises
    ------
    Exception
        Whatever a cell raises; a lesson asserts what it says.
    """
    import matplotlib as mpl

    mpl.use("Agg")
    space: dict[str, Any] = {"__name__": "__main__"}
    codes = [source for kind, source in cells_of(text) if kind == "code"]
    with mpl.rc_context({"figure.figsize": (7, 3), "savefig.dpi": 144, "font.size": 9}):
        return tuple(_run_cell(code, f"{name}, cell {k}", space) for k, code in enumerate(codes, 1))


def _run_cell(source: str, place: str, space: dict[str, Any]) -> Output:
    # Tracebacks look up their lines here.
    linecache.cache[place] = (len(source), None, source.splitlines(keepends=True), place)
    body = ast.parse(source, place)
    last = None
    if isinstance(body.body[-1], ast.Expr):
        last = ast.Expression(body.body.pop().value)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(body, place, "exec"), space)
        value = None if last is None else eval(compile(last, place, "eval"), space)
    html = value._repr_html_() if hasattr(value, "_repr_html_") else ""
    if value is not None and not html:
        printed.write(repr(value))
    return Output(printed.getvalue().rstrip(), html, _figures())


def _figures() -> tuple[tuple[str, bytes], ...]:
    """What each open figure is called, and its PNG; closes them."""
    import matplotlib.pyplot as plt

    found = []
    for number in plt.get_fignums():
        figure, data = plt.figure(number), io.BytesIO()
        figure.savefig(data, format="png", bbox_inches="tight")
        titles = [figure.get_suptitle(), *(axes.get_title() for axes in figure.axes)]
        found.append(("; ".join(filter(None, titles)) or "figure", data.getvalue()))
    plt.close("all")
    return tuple(found)


# ---------------------------------------------------------------------------------- on the site


def on_files(files: Files, config: Any) -> Files:
    """Run the lessons; their figures and notebooks join the files of the site."""
    from mkdocs.structure.files import File  # the tests do without mkdocs

    for file in list(files.documentation_pages()):
        path = PurePosixPath(file.src_uri)
        if path.parts[0] != FOLDER or path.name == OVERVIEW:
            continue
        notebook = notebook_of(file.content_string)
        files.append(File.generated(config, f"{FOLDER}/{path.stem}.ipynb", content=notebook))
        for cell, output in enumerate(run(file.content_string, path.stem)):
            for k, (_, data) in enumerate(output.figures):
                name = _figure_name(path.stem, cell, k)
                files.append(File.generated(config, f"{FOLDER}/{name}", content=data))
    return files


def on_page_markdown(markdown: str, page: Any, **_: object) -> str:
    """Put outputs below their cells, and fold the solutions."""
    path = PurePosixPath(page.file.src_uri)
    if path.parts[0] != FOLDER or path.name == OVERVIEW:
        return markdown
    outputs = iter(enumerate(run(page.file.content_string, path.stem)))

    def with_output(cell: re.Match[str]) -> str:
        number, output = next(outputs)
        return cell[0] + _shown(output, path.stem, number)

    text = _CELL.sub(with_output, markdown)
    title, _, rest = text.partition("\n")
    link = f"[Open as a notebook]({path.stem}.ipynb){{ download }}"
    return f"{title}\n\n{link}\n{_folded(rest)}"


def _figure_name(lesson: str, cell: int, k: int) -> str:
    return f"{lesson}-{cell}-{k}.png"


def _shown(output: Output, lesson: str, cell: int) -> str:
    parts = []
    if output.text:
        parts.append(f"```text\n{output.text}\n```")
    if output.html:
        parts.append(f"<div>{output.html}</div>")
    for k, (title, _) in enumerate(output.figures):
        alt = re.sub(r"[\[\]$\\]", "", title)
        parts.append(f"![{alt}]({_figure_name(lesson, cell, k)})")
    return "".join(f"\n{part}\n" for part in parts)


def _folded(text: str) -> str:
    """The page with each solution in a box that opens by a click."""
    pieces = _SOLUTIONS.split(text)
    if len(pieces) != 2:
        return text
    before, solutions = pieces
    _, *parts = _SOLUTION.split(solutions)
    boxes = []
    for title, body in zip(parts[::2], parts[1::2], strict=True):
        inside = "\n".join(f"    {line}" if line else "" for line in body.strip("\n").splitlines())
        boxes.append(f'??? success "{title}"\n\n{inside}\n')
    return f"{before}## Solutions\n\n" + "\n".join(boxes)
