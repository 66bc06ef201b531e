"""Study files: YAML -> `Study`, with every problem and its place.

A file names scenes, arms and a ladder of samples::

    title: Direct light
    scenes: [cornell-box]
    arms:
      mis: {light_sampling: mis}
      bsdf: {light_sampling: bsdf}
    spp: [4, 16, 64]
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

from alight.core.arguments import PATH, expect
from alight.core.errors import Issue, nearest, show_value, unknown_name
from alight.lab.study import ArmSpec, ReferenceSpec, SceneSpec, Study, StudyError
from alight.scene import plain_yaml

_KEYS = {
    "title", "description", "teaches", "kind", "scenes", "arms", "baseline", "spp", "equal_time",
    "replicates", "paired", "seed", "settings",
}  # fmt: skip
_SCENE_KEYS = {"scene", "name", "label", "set", "reference", "arms", "crops", "spp"}
_REFERENCE_KEYS = {"arm", "spp", "file", "error"}
_ARM_KEYS = {"label", "declares_different", "reference", "expected_slope"}
_KINDS = ("pictures", "integrals", "acceleration")
_SUFFIXES = (".yaml", ".yml", ".json")

#: Key -> (type, what it must be).
_TYPES: dict[str, tuple[type | tuple[type, ...], str]] = {
    "title": (str, "a text"),
    "description": (str, "a text"),
    "teaches": (str, "a text"),
    "label": (str, "a text"),
    "name": (str, "a text"),
    "scene": (str, "the name of a scene or a file"),
    "file": (str, "the name of a file"),
    "arm": (str, "the name of an arm"),
    "baseline": (str, "the name of an arm"),
    "equal_time": (bool, "true or false"),
    "paired": (bool, "true or false"),
    "declares_different": (bool, "true or false"),
    "replicates": (int, "a whole number"),
    "seed": (int, "a whole number"),
    "expected_slope": ((int, float), "a number"),
    "settings": (dict, "a mapping"),
    "set": (dict, "a mapping of key paths to values"),
    "crops": (list, "a list of [x, y, width, height]"),
}


def ready_names() -> tuple[str, ...]:
    """Names of the ready studies, in the order in which they build on each other."""
    folder = resources.files("alight.lab.studies")
    files = sorted(f.name for f in folder.iterdir() if f.name.endswith(".yaml"))
    return tuple(re.sub(r"^\d+-", "", name[:-5]) for name in files)


def load_study(name: str | Path, root: Path | None = None) -> Study:
    """Read a study file, or a ready study by its name.

    Parameters
    ----------
    name : str or path
    root : Path, optional
        Where the files of its scenes may lie, see `alight.load`.

    Raises
    ------
    StudyError
        With every problem of the file.
    """
    ready = ready_names()
    path = Path(expect(name, PATH, "name", "a study, its file or the name of a ready one"))
    if str(name) in ready:
        folder = resources.files("alight.lab.studies")
        file = next(f for f in folder.iterdir() if re.sub(r"^\d+-", "", f.name) == f"{name}.yaml")
        return parse_study(file.read_text("utf-8"), f"{name}.yaml", Path())
    if not path.is_file():
        near = nearest(str(name), [*ready, *_files_beside(path)])
        hint = f'; did you mean "{near}"?' if near else ""
        message = f"no such study file{hint}  (ready: {', '.join(ready)})"
        raise StudyError([Issue("", message, str(name))])
    if path.suffix.lower() not in _SUFFIXES:
        message = f"must be a study file ({', '.join(_SUFFIXES)})"
        raise StudyError([Issue("", message, str(name))])
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise StudyError([Issue("", f"cannot be read: {error}", str(name))]) from None
    return replace(parse_study(text, str(name), path.parent), root=root)


def _files_beside(path: Path) -> list[str]:
    try:
        found = [f for f in path.parent.iterdir() if f.suffix.lower() in _SUFFIXES]
    except OSError:
        return []
    return [str(path.with_name(f.name)) for f in found]


def parse_study(text: str, name: str = "study.yaml", folder: Path = Path()) -> Study:
    """Read a study from text.

    Raises
    ------
    StudyError
        With every problem of the text.
    SceneError
        If it is not YAML.
    """
    data, places, issues = plain_yaml.parse(text, name)
    reader = _Reader(Study(Path(name).stem, file=name, places=places))
    reader.issues += issues
    study = reader.study(data, folder)
    if reader.issues:
        raise StudyError(reader.issues)
    return study.checked()


class _Reader:
    """Turns plain data into descriptions and collects problems."""

    def __init__(self, empty: Study) -> None:
        self.empty = empty
        self.issues: list[Issue] = []

    def report(self, path: str, message: str) -> None:
        self.issues.append(self.empty.issue(path, message))

    def keys(self, data: Any, path: str, known: set[str], what: str) -> dict[str, Any]:
        """Return the mapping without unknown or ill-typed keys, which are reported."""
        if not isinstance(data, Mapping):
            self.report(path, f"{what} must be a mapping, got {show_value(data)}")
            return {}
        good = {}
        for key, value in data.items():
            at = f"{path}.{key}" if path else key
            kind, text = _TYPES.get(key, (object, ""))
            if key not in known:
                self.report(at, unknown_name("key", key, known))
            elif not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
                self.report(at, f"must be {text}, got {show_value(value)}")
            else:
                good[key] = value
        return good

    def study(self, data: Any, folder: Path) -> Study:
        found = self.keys(data, "", _KEYS, "a study")
        kind = found.get("kind", "pictures")
        if kind not in _KINDS:
            self.report("kind", unknown_name("kind of study", str(kind), _KINDS))
        plain = {k: v for k, v in found.items() if k not in {"scenes", "arms", "spp"}}
        base = self.empty
        return Study(
            base.name, file=base.file, places=base.places, folder=folder,
            scenes=self.scenes(found.get("scenes", [])), arms=self.arms(found.get("arms", {})),
            spp=self.ladder(found.get("spp", list(base.spp)), "spp"), **plain,
        )  # fmt: skip

    def ladder(self, data: Any, path: str) -> tuple[int, ...]:
        if not isinstance(data, list) or not all(isinstance(n, int) for n in data):
            self.report(path, f"must be a list of whole numbers, got {show_value(data)}")
            return (1,)
        return tuple(data)

    def scenes(self, data: Any) -> list[SceneSpec]:
        if not isinstance(data, list):
            self.report("scenes", f"must be a list, got {show_value(data)}")
            return []
        return [self.scene(one, f"scenes[{i}]") for i, one in enumerate(data)]

    def scene(self, data: Any, path: str) -> SceneSpec:
        if isinstance(data, str):
            return SceneSpec(data)
        found = self.keys(data, path, _SCENE_KEYS, "a scene")
        if "scene" not in found and isinstance(data, Mapping):
            self.report(path, "scene is missing: the name of a scene or a file")
        arms = found.get("arms", [])
        if not isinstance(arms, list) or not all(isinstance(arm, str) for arm in arms):
            self.report(f"{path}.arms", f"must be a list of names, got {show_value(arms)}")
            arms = []
        return SceneSpec(
            found.get("scene", ""), found.get("name", ""), found.get("label", ""),
            found.get("set", {}), self.reference(found.get("reference", {}), f"{path}.reference"),
            tuple(arms), self.crops(found.get("crops", []), f"{path}.crops"),
            self.ladder(found["spp"], f"{path}.spp") if "spp" in found else (),
        )  # fmt: skip

    def crops(self, data: list, path: str) -> list:
        for i, crop in enumerate(data):
            whole = isinstance(crop, list) and all(isinstance(n, int) and n >= 0 for n in crop)
            if not whole or len(crop) != 4:
                self.report(f"{path}[{i}]", f"must be [x, y, width, height], got {crop!r}")
                return []
        return data

    def reference(self, data: Any, path: str) -> ReferenceSpec:
        found = self.keys(data, path, _REFERENCE_KEYS, "a reference")
        spp, error = found.get("spp"), found.get("error")
        if spp is not None and (isinstance(spp, bool) or not isinstance(spp, int) or spp < 16):
            self.report(f"{path}.spp", f"must be a whole number >= 16, got {show_value(spp)}")
            spp = None
        if error is not None:
            try:
                error = parse_share(error)
            except ValueError as problem:
                self.report(f"{path}.error", str(problem))
                error = None
        return ReferenceSpec(found.get("arm", ""), spp, found.get("file", ""), error)

    def arms(self, data: Any) -> list[ArmSpec]:
        if not isinstance(data, Mapping):
            self.report("arms", f"must map names to options, got {show_value(data)}")
            return []
        return [self.arm(name, one) for name, one in data.items()]

    def arm(self, name: str, data: Any) -> ArmSpec:
        path = f"arms.{name}"
        if data is not None and not isinstance(data, Mapping):
            self.report(path, f"must map options to values, got {show_value(data)}")
            return ArmSpec(name)
        data = data or {}
        own = self.keys({k: v for k, v in data.items() if k in _ARM_KEYS}, path, _ARM_KEYS, "")
        if own.get("reference", "own") != "own":
            text = f'must be "own" or absent, got {show_value(own["reference"])}'
            self.report(f"{path}.reference", text)
        slope = own.get("expected_slope")
        return ArmSpec(
            name, {k: v for k, v in data.items() if k not in _ARM_KEYS}, own.get("label", ""),
            own.get("declares_different", False), "reference" in own,
            None if slope is None else float(slope),
        )  # fmt: skip


def parse_share(value: Any) -> float:
    """Read ``0.005`` or ``0.5%``.

    Raises
    ------
    ValueError
        If it is neither, or not in (0, 1).

    Examples
    --------
    >>> parse_share("0.5%")
    0.005
    """
    text = str(value).strip()
    try:
        share = float(text[:-1]) / 100.0 if text.endswith("%") else float(text)
    except ValueError:
        share = -1.0
    if not 0.0 < share < 1.0:
        raise ValueError(f"must be a share in (0, 1), as 0.5% or 0.005, got {show_value(value)}")
    return share
