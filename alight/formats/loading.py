"""Loading scenes from files and by built-in names."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

from alight.core.errors import Issue, SceneError, is_at_or_below, nearest, quote
from alight.formats import mitsuba, pbrt
from alight.formats.made_up import fitted
from alight.formats.models import PARSERS, read_model, refuse_variant
from alight.formats.native import SUFFIXES
from alight.formats.parsed import Parsed
from alight.formats.reach import OutOfReachError, Reach, is_file
from alight.scene import plain_yaml
from alight.scene.build import Builder
from alight.scene.description import Scene
from alight.scene.manager import SceneManager
from alight.scene.source import Recipe, Source
from alight.scene.validation import find_problems

# Files of other programs.
FOREIGN = (".xml", pbrt.SUFFIX, *PARSERS)


def builtin_names() -> tuple[str, ...]:
    """List the names of the built-in scenes."""
    folder = resources.files("alight.scene.builtin")
    return tuple(sorted(f.name[:-5] for f in folder.iterdir() if f.name.endswith(".yaml")))


def load(
    scene: str | os.PathLike[str],
    changes: tuple[str, ...] | list[str] = (),
    *,
    definitions: Mapping[str, str] | None = None,
    lenient: bool = False,
    root: str | os.PathLike[str] | None = None,
    variant: str | None = None,
) -> Scene:
    """Load a scene and check it.

    Parameters
    ----------
    scene : str or path
        A scene file (``.yaml``, ``.yml``, ``.json``, Mitsuba's ``.xml``, pbrt's ``.pbrt``,
        ``.gltf`` or ``.glb``), a model (``.obj``, ``.ply``, ``.stl``), or the name of a built-in
        scene.
    changes : sequence of str, optional
        ``path.to.key=value`` assignments, as for ``--set``.
    definitions : mapping of str to str, optional
        Values of the ``$names`` of an XML file, as for ``-D``.
    lenient : bool, default False
        Replace what a foreign file asks for and alight lacks, instead of refusing it;
        `Scene.warnings` lists it.
    root : str or path, optional
        Folder that holds the scene file: what the file names may lie there and below, and nowhere
        else. By default the scene's own folder, as files come from strangers. What `changes`
        name may lie anywhere.
    variant : str, optional
        Which variant of its materials a glTF file shows.

    Returns
    -------
    Scene
        Ready to render; see `Scene.warnings` for what is legal but suspicious.

    Raises
    ------
    SceneError
        With every problem of the file, each with its place.

    Examples
    --------
    >>> load("cornell-box", ["film.size=[64, 64]"]).film.size
    (64, 64)
    """
    name = os.fspath(scene)
    is_builtin = name in builtin_names()
    framed = None
    if Path(name).suffix.lower() not in PARSERS:
        refuse_variant(variant, name)
    if is_builtin:
        text = resources.files("alight.scene.builtin").joinpath(f"{name}.yaml").read_text("utf-8")
        result = loads(text, f"{name}.yaml", check=not changes, definitions=definitions)
    else:
        path = Path(name)
        if path.suffix.lower() in PARSERS and is_file(path):
            _refuse_definitions(definitions or {}, name)
            reach = _reach(path.parent, root, name)
            parsed = read_model(path, name, reach, variant)
            framed = parsed.framed
            result = _built(parsed.data, parsed.issues, _source(parsed, name, reach), not changes)
        else:
            result = loads(
                _read(path),
                name,
                path.parent,
                check=not changes,
                definitions=definitions,
                lenient=lenient,
                root=root,
            )
    if changes:
        result = fitted(result, changed(result, changes), framed)
    path = name if is_builtin else str(Path(name).absolute())
    kept_root = None if root is None or is_builtin else str(Path(root).absolute())
    recipe = Recipe(path, tuple(changes), dict(definitions or {}), lenient, kept_root, variant)
    return result.from_source(replace(result.source, recipe=recipe))


def loads(
    text: str,
    name: str = "scene",
    folder: Path | None = None,
    check: bool = True,
    *,
    definitions: Mapping[str, str] | None = None,
    lenient: bool = False,
    root: str | os.PathLike[str] | None = None,
) -> Scene:
    """Load a scene from text, in the native format, in Mitsuba's, or, by its name, in pbrt's.

    Parameters
    ----------
    text : str
        Content of a scene file.
    name : str, default "scene"
        Its name, for messages.
    folder : Path, optional
        Where the files that it names are looked up; the current folder by default.
    check : bool, default True
        Whether to run the checks that need the whole scene (`find_problems`).
    definitions, lenient, root
        See `load`.

    Raises
    ------
    SceneError
        With every problem, each with its place.
    """
    reach = _reach(folder, root, name)
    data, found, source = _parse(text, name, reach, definitions or {}, lenient)
    return _built(data, found, source, check)


def _built(data: Any, found: list[Issue], source: Source, check: bool) -> Scene:
    """A scene of plain data, and problems found so far."""
    builder = Builder(found)
    scene = builder.scene(data).from_source(source)
    issues = builder.issues
    # After a wrong top level nothing is left to check.
    if isinstance(data, dict) and (check or issues):
        # Where something is wrong stands what takes its place: its problems are nobody's.
        wrong = [issue.path for issue in issues]
        issues += [
            issue
            for issue in find_problems(scene)
            if not any(is_at_or_below(path, issue.path) for path in wrong)
        ]
    if issues:
        raise SceneError([issue if issue.place else source.located(issue) for issue in issues])
    return scene


def _reach(folder: Path | None, root: str | os.PathLike[str] | None, name: str) -> Reach:
    """Where the files of a scene may lie."""
    try:
        return Reach(folder, None if root is None else Path(root))
    except OutOfReachError as error:
        raise SceneError([Issue("--root", str(error), name)]) from None


def _parse(
    text: str, name: str, reach: Reach, definitions: Mapping[str, str], lenient: bool
) -> tuple[Any, list[Issue], Source]:
    """Plain data, problems so far and the origin, whichever format the text has."""
    if mitsuba.is_xml(text):
        parsed = mitsuba.parse(text, name, reach, definitions, lenient)
        return parsed.data, parsed.issues, _source(parsed, name, reach)
    _refuse_definitions(definitions, name)
    if name.lower().endswith(pbrt.SUFFIX):
        parsed = pbrt.parse(text, name, reach, lenient)
        return parsed.data, parsed.issues, _source(parsed, name, reach)
    data, places, issues = plain_yaml.parse(text, name)
    source = Source(name, reach.folder, places)
    refused = reach.keep_inside(data) if isinstance(data, dict) else {}
    if refused:
        # Whatever else is wrong would be found by reading these files.
        located = [source.located(Issue(path, text)) for path, text in refused.items()]
        raise SceneError([*issues, *located])
    return data, list(issues), source


def _source(parsed: Parsed, name: str, reach: Reach) -> Source:
    """The origin of a scene of another program, with what has been read of its files."""
    return Source(name, reach.folder, parsed.places, parsed.remarks, held=reach.files.held)


def _refuse_definitions(definitions: Mapping[str, str], name: str) -> None:
    if definitions:
        first = next(iter(definitions))
        issue = Issue(f"-D {first}", "only XML files have parameters; use --set path=value", name)
        raise SceneError([issue])


def changed(scene: Scene, changes: tuple[str, ...] | list[str]) -> Scene:
    """Change keys of a scene, and check it again.

    Parameters
    ----------
    scene : Scene
    changes : sequence of str
        ``path.to.key=value`` assignments, as for `load`.

    Raises
    ------
    SceneError
        With every problem.
    """
    manager = SceneManager(scene)
    for assignment in changes:
        manager.set_value(_with_camera_path(manager.scene, assignment))
    issues = find_problems(manager.scene)
    if issues:
        raise SceneError([manager.scene.source.located(issue) for issue in issues])
    return manager.scene


def _with_camera_path(scene: Scene, assignment: str) -> str:
    """Put the path of a camera's node into the place of its number or its last name."""
    key, _, wanted = assignment.partition("=")
    if key.strip() != "camera":
        return assignment
    wanted = wanted.strip()
    paths = [path for path, _, node in scene.walk() if node.camera is not None]
    named = [path for path in paths if path.rpartition("/")[2] == wanted]
    if wanted.isdigit() and wanted not in paths:
        if int(wanted[:9]) >= len(paths):
            held = ", ".join(paths) or "none"
            text = f"must be below the number of camera nodes, {len(paths)}, got {wanted}"
            raise SceneError([Issue("camera", f"{text}  (cameras: {held})")])
        named = [paths[int(wanted)]]
    return f'camera="{named[0]}"' if len(named) == 1 and wanted not in paths else assignment


def _read(path: Path) -> str:
    name = str(path)
    if not is_file(path):
        raise SceneError([Issue("", _missing(path), name)])
    if path.suffix.lower() not in SUFFIXES + FOREIGN:
        kinds = ", ".join(SUFFIXES + FOREIGN)
        raise SceneError([Issue("", f"must be a scene file ({kinds}), got {quote(name)}", name)])
    try:
        size = path.stat().st_size
        if size > plain_yaml.MOST_BYTES:
            limit = plain_yaml.MOST_BYTES // 2**20
            text = (
                f"must be at most {limit} MB, got {size / 2**20:.0f} MB: put meshes into PLY files"
            )
            raise SceneError([Issue("", text, name)])
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        text = f"must be UTF-8 text, got byte 0x{error.object[error.start]:02x} at {error.start}"
        raise SceneError([Issue("", text, name)]) from None
    except OSError as error:
        raise SceneError([Issue("", f"cannot be read: {error.strerror}", name)]) from None


def _missing(path: Path) -> str:
    built_in = builtin_names()
    # Of names that no file can have the module says False, the path raises an error.
    if os.path.isdir(path):  # noqa: PTH112
        return "is a folder, not a scene file"
    candidates = {str(path.with_name(f.name)): f for f in _files_beside(path)}
    near = nearest(str(path), [*built_in, *candidates])
    hint = f'; did you mean "{near}"?' if near else ""
    return f"no such scene file{hint}  (built in: {', '.join(built_in)})"


def _files_beside(path: Path) -> list[Path]:
    try:
        return [
            entry for entry in path.parent.iterdir() if entry.suffix.lower() in SUFFIXES + FOREIGN
        ]
    except OSError:
        return []
