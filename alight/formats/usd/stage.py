"""Opening a stage: its layers must lie within reach, and OpenUSD's complaints are reported."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import Issue, SceneError, quote, show_value
from alight.formats.reading.reach import OutOfReachError, Reach, is_file
from alight.formats.reading.report import Report
from alight.formats.usd.documents import SUFFIX, Documents, read_layer
from alight.formats.usd.modules import Sdf, Tf, Usd, UsdGeom, UsdUtils


@dataclass(frozen=True)
class Stage:
    """A stage at one time.

    Attributes
    ----------
    stage : Usd.Stage
    time : Usd.TimeCode
        The first time that has samples, or the default.
    name : str
        Of the file, for messages.
    reach : Reach
        Where files may lie.
    report : Report
    documents : Documents
        Of MaterialX, which its layers refer to.
    """

    stage: Any
    time: Any
    name: str
    reach: Reach
    report: Report
    documents: Documents

    def value(self, attribute: Any, default: Any = None) -> Any:
        """Value of an attribute; the default if there is none, or one of another type."""
        try:
            found = attribute.Get(self.time) if attribute else None
        except UnicodeDecodeError as error:
            text = f"{attribute.GetName()} must be text in UTF-8, got {show_value(error.object)}"
            self.problem(attribute.GetPrim(), text)
            return default
        if found is None:
            return default
        # Files may declare an attribute of a schema anew; then its value is of any type.
        given, wanted = str(Sdf.GetValueTypeNameForValue(found)), str(attribute.GetTypeName())
        if not given or _kind(given) != _kind(wanted):
            text = f"{attribute.GetName()} must be of type {wanted}"
            text += f", got {given}" if given else ""
            if not wanted:
                text = f"{attribute.GetName()} is of a type that OpenUSD does not know"
            self.problem(attribute.GetPrim(), text)
            return default
        if isinstance(found, float) and not math.isfinite(found):
            self.problem(attribute.GetPrim(), f"{attribute.GetName()} must be finite, got {found}")
            return default
        return found

    def alike(self, attribute: Any, default: Any) -> Any:
        """Value of an attribute that no schema declares, if it is of the kind of the default."""
        found = self.value(attribute)
        if found is None:
            return default
        if (
            isinstance(default, tuple)
            and hasattr(found, "__len__")
            and 0 < len(found) <= len(default)
        ):
            # A vector may be shorter: it counts as the first components.
            found = (*found, *default[len(found) :])
            fits = all(isinstance(c, int | float) for c in found)
        else:
            fits = isinstance(found, str if isinstance(default, str) else int | float)
            fits = fits and not isinstance(default, tuple)
        if not fits:
            wanted = "a text" if isinstance(default, str) else "a number"
            if isinstance(default, tuple):
                wanted = f"{len(default)} numbers"
            text = f"{attribute.GetName()} must be {wanted}, got {show_value(found)}"
            self.problem(attribute.GetPrim(), text)
            return default
        return found

    def table(self, primvar: Any) -> NDArray[np.float64] | None:
        """Numbers of a primvar, a row for each of its values; None if they are no numbers."""
        try:
            table = np.array(primvar.ComputeFlattened(self.time), np.float64)
        except (TypeError, ValueError):
            table = np.zeros(0)
        if not primvar.GetTypeName().isArray:
            # One value, not a list of one.
            table = table.reshape(1, -1) if table.size else table
        elif table.ndim == 1 and len(table):
            table = table[:, None]
        if table.ndim == 2 and np.isfinite(table).all():
            return table
        text = f"{primvar.GetName()} holds no rows of finite numbers: left out"
        self.report.approximate(f"{primvar.GetAttr().GetPrim().GetPath()}: {text}")
        return None

    def picture(self, authored: str, resolved: str) -> Path:
        """Where a picture lies that some layer names; `resolved` is empty if there is none.

        Raises
        ------
        OutOfReachError
            If it lies out of reach, in the same words whether it is there or not; or is missing.
        """
        if resolved:
            return self.reach.inside(resolved, shown=authored)
        refused = None
        for layer in self.stage.GetUsedLayers():
            try:
                folder = Path(layer.realPath.partition("[")[0]).parent
                self.reach.inside(authored, folder if layer.realPath else None)
            except OutOfReachError as error:
                refused = error
            else:
                refused = None
                break
        raise refused or OutOfReachError(f"no such picture: {quote(authored)}")

    def problem(self, prim: Any, message: str) -> None:
        """Report what nothing mends but an edit."""
        self.report.problem(self.name, str(prim.GetPath()), message)


#: In metres.
LARGEST_UNIT = 1e12

_NUMBERS = (
    "double",
    "float",
    "half",
    "int",
    "int64",
    "uint",
    "uint64",
    "uchar",
    "bool",
    "timecode",
)


def _kind(name: str) -> str:
    """What a type holds, whatever its precision: types of one kind can stand for each other."""
    base = name.removesuffix("[]")
    array = name[len(base) :]
    if base in _NUMBERS:
        return "number" + array
    if base in ("token", "string"):
        return "text" + array
    vector = re.fullmatch(r"(?!matrix)[a-zA-Z]+([234])[a-z]?", base)
    if vector:
        return f"vector{vector[1]}{array}"
    return ("quaternion" if base.startswith("quat") else base) + array


def open_stage(name: str, reach: Reach, report: Report, at: float | None = None) -> Stage:
    """Open a file with everything that it refers to.

    Parameters
    ----------
    name : str
        Of the file, for messages; its last part is its name in the folder of `reach`.
    reach : Reach
        Where layers and pictures may lie.
    report : Report
        Takes what is noticed.
    at : float, seconds, optional
        The time that is shown, after the first time code; that one by default.

    Raises
    ------
    SceneError
        If it is no stage, or refers to layers that are missing or lie elsewhere.
    """
    path = str((reach.folder / Path(name).name).resolve())
    documents = Documents(reach, report)
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        # Held until the stage holds them, each is read once.
        layers = _layers_within(path, name, reach, documents)
        stage = Usd.Stage.Open(path)
        del layers
    except Tf.ErrorException as error:
        raise SceneError(
            [Issue("", f"is not an OpenUSD stage: {first_line(error)}", name)]
        ) from None
    finally:
        warnings = [item.commentary for item in delegate.TakeUncoalescedDiagnostics()]
    errors = stage.GetCompositionErrors()
    torn = [first_line(error) for error in errors]
    issues = []
    for text in torn:
        if report.lenient:
            report.approximate(f"{name}: {text}: what it names is left out")
        else:
            issues.append(Issue("", f"does not fit together: {text}", name))
    if not issues:
        # What is torn comes as a warning, too.
        for text in map(first_line, warnings):
            if not any(part in text for part in torn):
                report.approximate(f"OpenUSD: {text}")
    for layer in stage.GetUsedLayers():
        real = layer.realPath
        try:
            # Layers of clips are known only now.
            reach.inside(real.partition("[")[0] or path, shown=Path(real).name)
        except OutOfReachError as error:
            issues.append(Issue("", f"layer {error}", name))
    if issues:
        raise SceneError(issues[:20])
    return Stage(stage, _time(stage, name, report, at), name, reach, report, documents)


def _time(stage: Any, name: str, report: Report, at: float | None) -> Any:
    """The time code that is shown: `at` seconds after the first one."""
    start = float(_metadata(stage, "startTimeCode", 0.0))
    moves = _metadata(stage, "endTimeCode", start) > start
    # A stage that does not say when it ends is played by whoever asks for a time of it.
    if moves or (at is not None and not stage.HasAuthoredTimeCodeRange()):
        report.count("animations")
    if at is None and not stage.HasAuthoredTimeCodeRange():
        return Usd.TimeCode.EarliestTime()
    if at is None:
        if moves:
            report.drop(
                f"times after {start:g}: the scene is shown at that one; --at SECONDS shows it "
                "at another"
            )
        return Usd.TimeCode(start)
    rate = _metadata(stage, "timeCodesPerSecond", _metadata(stage, "framesPerSecond", 24.0))
    if not isinstance(rate, int | float) or not 0.0 < rate < math.inf:
        report.problem(name, "timeCodesPerSecond", f"must be > 0, got {show_value(rate)}")
        rate = 24.0
    code = start + at * float(rate)
    if not math.isfinite(code):
        report.problem(name, "--at", f"must be a time of the stage, got {at:g} s")
        code = start
    return Usd.TimeCode(code)


def _metadata(stage: Any, name: str, default: float) -> Any:
    """Of a stage; OpenUSD's own functions fail where a file stores it in another precision."""
    return stage.GetPseudoRoot().GetAllAuthoredMetadata().get(name, default)


def _layers_within(path: str, name: str, reach: Reach, documents: Documents) -> list[Any]:
    """Open the layers that a file is made of, its own first, before OpenUSD follows any path.

    Raises
    ------
    SceneError
        If it refers to layers out of reach: of these nothing is read.

    Notes
    -----
    Backslashes in paths become slashes in memory, as OpenUSD knows them on Windows only.
    """
    first = _opened(path)
    layers, seen, refused = [] if first is None else [first], {path}, {}
    made: dict[str, Any] = {}
    for layer in layers:
        if layer.anonymous:
            continue
        if any("\\" in path for path in layer.GetCompositionAssetDependencies()):
            UsdUtils.ModifyAssetPaths(layer, lambda path: path.replace("\\", "/"))
        for authored in layer.GetCompositionAssetDependencies():
            if not authored:
                # A reference to another prim of the same layer.
                continue
            found, _ = Sdf.Layer.SplitIdentifier(layer.ComputeAbsolutePath(authored))
            if found in made:
                _put_in_place(layer, authored, made[found])
            if found in seen:
                continue
            seen.add(found)
            try:
                # A name that was not found comes back as it was.
                folder = Path(layer.realPath.partition("[")[0]).parent
                inside = reach.inside(found.partition("[")[0], folder, authored)
            except OutOfReachError as error:
                refused[authored] = f"layer {error}"
                continue
            if found.lower().endswith(SUFFIX) and is_file(inside):
                made[found], problem = read_layer(documents, inside)
                if made[found] is None:
                    refused[authored] = problem
                    continue
                _put_in_place(layer, authored, made[found])
                layers.append(made[found])
                continue
            try:
                below = _opened(found)
            except Tf.ErrorException as error:
                # Missing ones are reported when OpenUSD composes the stage.
                if is_file(Path(found.partition("[")[0])):
                    refused[authored] = f"does not fit together: {first_line(error)}"
                continue
            layers += [] if below is None else [below]
    if refused:
        raise SceneError([Issue("", text, name) for text in list(refused.values())[:20]])
    return layers


def _put_in_place(layer: Any, authored: str, other: Any) -> None:
    """Let a layer refer to one in memory instead of a file."""
    name = "" if other is None else other.identifier
    UsdUtils.ModifyAssetPaths(layer, lambda path: name if path == authored and name else path)


def _opened(path: str) -> Any:
    """A layer as its file is now; None where there is none."""
    layer = Sdf.Layer.FindOrOpen(path)
    if layer is not None:
        # One that somebody still holds may have been read from an older file.
        layer.Reload()
    return layer


def meters_per_unit(opened: Stage) -> float | None:
    """Unit of a stage in metres; None where what it says is none."""
    meters = _metadata(opened.stage, "metersPerUnit", 0.01)
    valid = isinstance(meters, int | float) and 0.0 < meters <= LARGEST_UNIT
    return float(meters) if valid else None


def to_world(opened: Stage) -> list[dict[str, Any]]:
    """Steps from a stage's space to ours: metres, +y up."""
    steps: list[dict[str, Any]] = []
    meters = meters_per_unit(opened)
    if meters is None:
        found = _metadata(opened.stage, "metersPerUnit", 0.01)
        text = f"must be > 0 and at most {LARGEST_UNIT:g}, got {show_value(found)}"
        opened.report.problem(opened.name, "metersPerUnit", text)
        meters = 1.0
    if UsdGeom.GetStageUpAxis(opened.stage) == UsdGeom.Tokens.z:
        steps.append({"rotate": {"axis": "x", "angle": -90}})
    if meters != 1.0:
        steps.append({"scale": meters})
    return steps


def world_matrix(steps: list[dict[str, Any]]) -> np.ndarray:
    """The (4, 4) matrix of what `to_world` gives."""
    matrix = np.eye(4)
    for step in steps:
        if "scale" in step:
            matrix[:3] *= step["scale"]
        else:
            # -90 degrees about x: y goes to -z, z to y.
            matrix = matrix[[0, 2, 1, 3]] * np.array([[1.0], [1.0], [-1.0], [1.0]])
    return matrix


def first_line(error: object) -> str:
    """The first of OpenUSD's complaints, without where in its own source it was noticed."""
    try:
        text = " ".join(str(error).split())
    except UnicodeDecodeError as wrong:
        # It quotes what the file holds, which need not be text.
        text = " ".join(wrong.object.decode("utf-8", "backslashreplace").split())
    found = re.search(r"in file \S+ : '(.*?)'(?: Error in |$)", text)
    text = found[1] if found else text
    return text[:300] + ("..." if len(text) > 300 else "")
