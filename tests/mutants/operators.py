"""Small slips of the pen, as operators on the syntax tree: where they apply, and what they write.

The operators are those with which programmers' mistakes are usually modelled (DeMillo, Lipton and
Sayward 1978, Hints on Test Data Selection), chosen for what renderers get wrong. They apply to
kernel text, to the statistics that stand behind every error bar and verdict, and to what computes
in the view and in options.

Left out by rule, as no test could or should find them: docstrings and messages, annotations,
assertions, what is raised, the search for a *cheap* tree or split, of which any outcome is right
(`CHOICES`), scratch memory that is larger than it must be, and numbers that only tell nothing from
something or stand for no bound at all (`TINY`, `HUGE`).
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

#: What stands behind error bars and verdicts without being kernel text.
STATISTICS = (
    "metrics/*.py",
    "films/[dfmrs]*.py",
    "rendering/schedules/adaptive.py",
    "rendering/depth_cap.py",
    "rendering/schedules/sample_bound.py",
    "rendering/schedules/stopping.py",
    "rendering/schedules/unseen.py",
    "lab/statistics/agreement.py",
    "lab/arm_plan.py",
    "lab/statistics/block_means.py",
    "lab/statistics/decomposition.py",
    "lab/statistics/equal_time.py",
    "lab/evaluate.py",
    "lab/integrals.py",
    "lab/references.py",
    "lab/statistics/intervals.py",
    "lab/replicates/steering.py",
)

#: What computes on pages, in options, readers and writers without being either. Tests of clusters
#: and of the command line start processes that know nothing of a slip that was planted in memory:
#: their bugs are planted by hand.
PLAIN = (
    "compiled/boxes.py",
    "compiled/casters.py",
    "compiled/light_gain.py",
    "compiled/light_targets.py",
    "compiled/warnings/*.py",
    "core/distributions.py",
    "formats/geometry/bounds.py",
    "formats/geometry/displacement.py",
    "formats/gltf/accessors.py",
    "formats/gltf/animations.py",
    "formats/gltf/places.py",
    "formats/gltf/tessellate.py",
    "formats/materials/colors.py",
    "formats/materials/hair.py",
    "formats/materials/spectra.py",
    "formats/materials/steepness.py",
    "formats/materialx/pointwise.py",
    "formats/mitsuba/colors.py",
    "formats/mitsuba/daylight.py",
    "formats/mitsuba/framing.py",
    "formats/mitsuba/transforms.py",
    "formats/pbrt/heights.py",
    "formats/pbrt/lenses.py",
    "formats/pbrt/octahedral.py",
    "formats/pbrt/roughness.py",
    "formats/pbrt/transforms.py",
    "formats/usd/light_controls.py",
    "formats/usd/subdivision.py",
    "meshes/*.py",
    "options/kinds.py",
    "options/quantities.py",
    "options/table.py",
    "outputs/[adehptw]*.py",
    "rendering/unfound_light.py",
    "scene/dispersion.py",
    "scene/keyframes.py",
    "scene/motion.py",
    "scene/strands.py",
    "scene/transform.py",
    "scene/translucent_strands.py",
    "tone_curves/*.py",
    "view/layers.py",
    "view/movable.py",
    "view/pose.py",
    "view/shades.py",
)

#: (file, function): choices that cost time only, not truth.
CHOICES = {
    ("accel/splitting.py", "bin_count"),
    ("accel/splitting.py", "blocks_of"),
    ("accel/splitting.py", "cheapest_split"),
    ("accel/splitting.py", "prefers_leaf"),
    ("accel/collapse.py", "cost_of_share"),
    ("accel/collapse.py", "write_all_costs"),
    ("accel/collapse.py", "write_costs"),
    ("accel/collapse.py", "write_costs_of"),
}

#: Functions that are taken for each other.
TWINS = {
    "sin": "cos", "cos": "sin", "floor": "ceil", "ceil": "floor",
    "minimum": "maximum", "maximum": "minimum", "min": "max", "max": "min",
    "nanmin": "nanmax", "nanmax": "nanmin", "fmin": "fmax", "fmax": "fmin",
    "argmin": "argmax", "argmax": "argmin",
}  # fmt: skip

#: Of kernel text, whose files need not import the other one: max(a, b) = -min(-a, -b).
MIRRORED = {"minimum", "maximum", "horizontal_min", "horizontal_max"}

#: Calls whose first two arguments may be exchanged without a change.
SYMMETRIC = {
    "dot", "minimum", "maximum", "minimum_u32", "min", "max", "isclose", "allclose", "array_equal",
    "hypot", "logical_and", "logical_or", "length", "multiply", "add", "distance",
}  # fmt: skip

#: Arguments that nothing else could stand for: the program would not run.
HOLDERS = {"scene", "program", "settings", "tile", "film", "params", "view"}

#: Calls whose first argument is a size: one more does no harm.
SCRATCH = {"local_floats", "local_uints", "local_longs"}

#: Any number below and beyond these is as good as another 2 % larger.
TINY, HUGE = 1e-20, 1e20

NEXT_CHANNEL = {"x": "y", "y": "z", "z": "x"}


class Site(NamedTuple):
    """One place where one operator applies.

    Attributes
    ----------
    file : str
        Inside the package.
    function : str
        With the names of the functions and classes around it.
    operator : str
        What slips.
    line : int
        Where it begins in the file, from 1.
    start, end : int
        Bytes of the file that are replaced.
    old, new : str
        The text there, and what takes its place.
    turn : int
        From 1, where a function has the same slip several times.
    """

    file: str
    function: str
    operator: str
    line: int
    start: int
    end: int
    old: str
    new: str
    turn: int = 1

    @property
    def name(self) -> str:
        """Unique, and the same wherever the function stands in the file."""
        old, new = (" ".join(text.split()) for text in (self.old, self.new))
        turn = f" ({self.turn})" if self.turn > 1 else ""
        return f"{self.file} {self.function}: {old} -> {new}{turn}"

    @property
    def folder(self) -> str:
        """The part of the package."""
        return self.file.partition("/")[0]


def sites_of(package: Path) -> list[Site]:
    """Every place of a package where an operator applies, in order."""
    whole = {path for pattern in STATISTICS + PLAIN for path in package.glob(pattern)}
    found: list[Site] = []
    for path in sorted(package.rglob("*.py")):
        source = path.read_bytes()
        reader = _Reader(str(path.relative_to(package)), source)
        reader.read(ast.parse(source), (), inside=path in whole)
        found += reader.sites
    return found


def planted(source: bytes, site: Site) -> bytes:
    """The text of the file with the slip in it."""
    return source[: site.start] + site.new.encode() + source[site.end :]


class _Reader:
    """Collects the sites of one file."""

    def __init__(self, file: str, source: bytes):
        self.file, self.source = file, source
        self.sites: list[Site] = []
        self.turns: Counter[str] = Counter()
        self.line_starts = [0]
        for line in source.splitlines(keepends=True):
            self.line_starts.append(self.line_starts[-1] + len(line))

    # ------------------------------------------------------------ places

    def span(self, node: ast.expr) -> tuple[int, int]:
        start = self.line_starts[node.lineno - 1] + node.col_offset
        assert node.end_lineno is not None and node.end_col_offset is not None
        return start, self.line_starts[node.end_lineno - 1] + node.end_col_offset

    def text(self, node: ast.expr) -> str:
        start, end = self.span(node)
        return self.source[start:end].decode()

    def add(self, operator: str, function: str, node: ast.expr, new: str) -> None:
        start, end = self.span(node)
        old = self.source[start:end].decode()
        if new != old:
            site = Site(self.file, function, operator, node.lineno, start, end, old, new)
            self.turns[site.name] += 1
            self.sites.append(site._replace(turn=self.turns[site.name]))

    # ------------------------------------------------------------ the walk

    def read(self, node: ast.AST, names: tuple[str, ...], inside: bool) -> None:
        """Walk statements; expressions count where kernel text or a statistic is being read."""
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef):
                marked = inside or any(map(_marks_kernel, child.decorator_list))
                if (self.file, child.name) not in CHOICES:
                    for statement in child.body:
                        self.statement(statement, (*names, child.name), marked)
            elif isinstance(child, ast.ClassDef):
                self.read(child, (*names, child.name), inside)

    def statement(self, node: ast.AST, names: tuple[str, ...], marked: bool) -> None:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            self.read(ast.Module([node], []), names, marked)
        elif not (isinstance(node, ast.Assert | ast.Raise) or _is_docstring(node)):
            for field, child in ast.iter_fields(node):
                if field == "annotation":
                    continue
                for part in child if isinstance(child, list) else [child]:
                    if isinstance(part, ast.expr):
                        if marked:
                            self.expressions(part, names)
                    elif isinstance(part, ast.AST):
                        self.statement(part, names, marked)
            if marked and isinstance(node, ast.Assign):
                self.exchange_results(node, names)

    def expressions(self, node: ast.AST, names: tuple[str, ...], is_size: bool = False) -> None:
        if isinstance(node, ast.JoinedStr):
            return
        if isinstance(node, ast.expr):
            for operator, new in _slips(node, self.text):
                if not (is_size and _is_one_more(node, new)):
                    self.add(operator, ".".join(names), node, new)
        is_size = isinstance(node, ast.Call) and _called(node) in SCRATCH
        for child in ast.iter_child_nodes(node):
            self.expressions(child, names, is_size)

    def exchange_results(self, node: ast.Assign, names: tuple[str, ...]) -> None:
        """``sine, cosine = sincos(x)`` with its targets exchanged."""
        target = node.targets[0]
        if (
            isinstance(node.value, ast.Call)
            and _called(node.value).startswith("sincos")
            and isinstance(target, ast.Tuple)
            and len(target.elts) == 2
        ):
            first, second = map(self.text, target.elts)
            self.add("sine for cosine", ".".join(names), target, f"{second}, {first}")


def _is_one_more(node: ast.expr, new: str) -> bool:
    value = getattr(node, "value", None)
    return isinstance(value, int) and new == str(value + 1)


def _is_docstring(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _marks_kernel(decorator: ast.expr) -> bool:
    called = decorator.func if isinstance(decorator, ast.Call) else decorator
    return isinstance(called, ast.Name) and called.id in ("kernel", "specialised")


def _called(node: ast.Call) -> str:
    """The last part of the name of what is called."""
    function = node.func
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ""


def _slips(node: ast.expr, text) -> Iterator[tuple[str, str]]:
    """(operator, new text) of every slip that applies to an expression itself."""
    if isinstance(node, ast.BinOp):
        yield from _of_arithmetic(node, text)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        if not isinstance(node.operand, ast.Constant):
            yield "wrong sign", f"({text(node.operand)})"
    elif isinstance(node, ast.Call):
        yield from _of_calls(node, text)
    elif isinstance(node, ast.Constant):
        yield from _of_constants(node)
    elif isinstance(node, ast.Attribute):
        if node.attr in NEXT_CHANNEL and isinstance(node.ctx, ast.Load):
            yield "wrong channel", f"{text(node.value)}.{NEXT_CHANNEL[node.attr]}"
    elif isinstance(node, ast.Compare):
        yield from _of_comparisons(node, text)


def _of_arithmetic(node: ast.BinOp, text) -> Iterator[tuple[str, str]]:
    left, right = text(node.left), text(node.right)
    texts = (ast.Constant, ast.JoinedStr)
    for part in (node.left, node.right):
        if isinstance(part, texts) and not isinstance(getattr(part, "value", 0), int | float):
            return
    if isinstance(node.op, ast.Mult):
        yield "dropped factor", f"({left})"
        yield "dropped factor", f"({right})"
    elif isinstance(node.op, ast.Div):
        yield "dropped factor", f"({left})"
    elif isinstance(node.op, ast.Add):
        yield "wrong sign", f"(({left}) - ({right}))"
    elif isinstance(node.op, ast.Sub):
        yield "wrong sign", f"(({left}) + ({right}))"


def _of_calls(node: ast.Call, text) -> Iterator[tuple[str, str]]:
    name, function = _called(node), text(node.func)
    rest = [text(part) for part in node.args]
    rest += [f"{k.arg}={text(k.value)}" if k.arg else f"**{text(k.value)}" for k in node.keywords]
    if name in MIRRORED and isinstance(node.func, ast.Name):
        mirrored = ", ".join(f"-({part})" for part in rest)
        yield "smallest for largest", f"(-{function}({mirrored}))"
    elif name in TWINS and (isinstance(node.func, ast.Attribute) or name in ("min", "max")):
        other = function[: len(function) - len(name)] + TWINS[name]
        kind = "sine for cosine" if name in ("sin", "cos") else "smallest for largest"
        yield kind, f"{other}({', '.join(rest)})"
    starred = any(isinstance(part, ast.Starred) for part in node.args)
    if name not in SYMMETRIC and not starred:
        # A mask for a value would not run either; fma(a, b, c) is fma(b, a, c), and a number cut to
        # a range is the range's lower end cut to that between the number and the upper end.
        first = 1 if name in ("where", "fma", "clip") else 0
        for i in range(first, len(node.args) - 1):
            if rest[i] != rest[i + 1] and not HOLDERS & {rest[i], rest[i + 1]}:
                swapped = [*rest[:i], rest[i + 1], rest[i], *rest[i + 2 :]]
                yield "exchanged arguments", f"{function}({', '.join(swapped)})"


def _of_constants(node: ast.Constant) -> Iterator[tuple[str, str]]:
    value = node.value
    if isinstance(value, bool):
        return
    if isinstance(value, int):
        yield "off by one", str(value + 1)
        if value > 0:
            yield "off by one", str(value - 1)
    elif isinstance(value, float) and TINY < value < HUGE:
        yield "constant times 1.02", repr(value * 1.02)


def _of_comparisons(node: ast.Compare, text) -> Iterator[tuple[str, str]]:
    other = {ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">"}
    sign = other.get(type(node.ops[0]))
    # Between whole numbers a border matters; between lengths and angles it has measure zero.
    if sign and len(node.ops) == 1 and (_is_whole(node.left) or _is_whole(node.comparators[0])):
        yield "off by one", f"({text(node.left)} {sign} {text(node.comparators[0])})"


def _is_whole(node: ast.expr) -> bool:
    if isinstance(node, ast.Call):
        return _called(node) == "len"
    return isinstance(node, ast.Constant) and type(node.value) is int
