"""Loading scenes from files and by built-in names."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

from alight.core.arguments import PATH, expect, known_words
from alight.core.errors import (
    Issue,
    OptionError,
    SceneError,
    is_at_or_below,
    show_value,
)
from alight.formats.geometry.bounds import Bounds
from alight.formats.objects import name_of, parse_object
from alight.formats.objects.pieces import SMOOTH, Look
from alight.formats.readers import READERS, read_model
from alight.formats.reading.reach import OutOfReachError, Reach, is_file
from alight.formats.reading.shown import Shown
from alight.formats.scene_text import PBRT, builtin_names, is_xml, read_text
from alight.formats.scenes.made_up import fitted
from alight.formats.scenes.missing import replace_missing
from alight.formats.scenes.parsed import Parsed
from alight.scene import plain_yaml
from alight.scene.build import FORMAT_VERSION, Builder
from alight.scene.checked import checked_files
from alight.scene.description import Scene
from alight.scene.manager import SceneManager
from alight.scene.source import Recipe, Source
from alight.scene.validation import find_problems


@known_words()
def load(
    scene: Any,
    changes: tuple[str, ...] | list[str] = (),
    *,
    definitions: Mapping[str, str] | None = None,
    lenient: bool = False,
    root: str | os.PathLike[str] | None = None,
    variant: str | None = None,
    scene_name: str | None = None,
    animation: str | None = None,
    at: float | None = None,
    up: str | None = None,
    smooth: float = SMOOTH,
    color_map: str = "viridis",
    color_range: tuple[float, float] | None = None,
    point_radius: float | None = None,
) -> Scene:
    """Load a scene and check it.

    Parameters
    ----------
    scene : path, str, dict or object
        A scene file (``.yaml``, ``.yml``, ``.json``, Mitsuba's ``.xml``, pbrt's ``.pbrt``,
        ``.gltf`` or ``.glb``), a model (``.obj``, ``.ply``, ``.stl``), materials (``.mtlx``), the
        name of a built-in scene, or a dictionary that holds what a native file says.

        Or an object: a ``Trimesh``, ``Scene`` or ``PointCloud`` of trimesh; a data set of PyVista
        or VTK, coloured by its active scalars; a ``TriangleMesh`` or ``PointCloud`` of Open3D;
        arrays ``(vertices, faces)`` or ``(vertices, faces, paint)``, where paint is colours or
        numbers, of the vertices or of the faces; an array of points, shape (n, 3). Colours are
        those of a display. A studio and a camera stand around an object.
    changes : sequence of str, optional
        ``path.to.key=value`` assignments, as for ``--set``.
    definitions : mapping of str to str, optional
        Values of the ``$names`` of an XML file, as for ``-D``.
    lenient : bool, default False
        Replace what a foreign file asks for and alight lacks, and files that are missing, instead
        of refusing the scene; `Scene.warnings` lists it.
    root : str or path, optional
        Folder that holds the scene file: what the file names may lie there and below, and nowhere
        else. By default the scene's own folder, as files come from strangers. What `changes` and
        dictionaries name may lie anywhere.
    variant : str, optional
        Which variant of its materials a glTF file shows, or which material a MaterialX file.
    scene_name : str, optional
        Which of its scenes a glTF file shows: name or number, from 0.
    animation : str, optional
        Which of its animations `at` is a time of in a glTF file: name or number; the first one by
        default.
    at : float, seconds, optional
        When a glTF or OpenUSD file is shown, from the beginning of its animation. By default glTF
        files are shown at rest, OpenUSD files at their first time.
    up : {"y", "z"}, optional
        Axis of an object that points up. By default as its package shows it: z for PyVista and
        VTK, y for the others.
    smooth : float, degrees, default 30
        An object's edges whose faces differ by less are shaded smooth, where it has no normals.
    color_map : str, default "viridis"
        How an object's numbers become colours: viridis, grey, or any map of Matplotlib where that
        is installed.
    color_range : (float, float), optional
        Numbers at the ends of the colour map; by default the lowest and the highest.
    point_radius : float, metres, optional
        Radius of the ball that stands for a point; by default neighbours touch.

    Returns
    -------
    Scene
        Ready to render; see `Scene.warnings` for what is legal but suspicious.

    Raises
    ------
    SceneError
        With every problem of the file, each with its place.
    OptionError
        If an option does not fit the scene.

    Examples
    --------
    >>> load("cornell-box", ["film.size=[64, 64]"]).film.size
    (64, 64)
    >>> load(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])).nodes["mesh"].bsdf
    'mesh'
    """
    _check_arguments(changes, definitions, root)
    look = Look(up, smooth, color_map, color_range, point_radius)
    if not isinstance(scene, str | os.PathLike):
        reading = {
            "definitions": definitions, "lenient": lenient, "root": root, "variant": variant,
            "scene_name": scene_name, "animation": animation, "at": at,
        }  # fmt: skip
        return _loaded_object(scene, changes, look, reading)
    if look.given:
        text = "is for objects of other packages, not for files"
        raise OptionError(text, look.given[0])
    name = os.fspath(scene)
    is_builtin = name in builtin_names()
    framed = None
    shown = Shown(variant, scene_name, animation, at)
    if Path(name).suffix.lower() not in READERS:
        shown.refuse(name)
    if is_builtin:
        text = resources.files("alight.scene.builtin").joinpath(f"{name}.yaml").read_text("utf-8")
        result = loads(text, f"{name}.yaml", check=not changes, definitions=definitions)
    else:
        path, given = Path(name), definitions or {}
        reach = _reach(path.parent, root, name)
        if path.suffix.lower() in READERS and is_file(path):
            _refuse_definitions(given, name)
            parsed = read_model(path, name, reach, shown, lenient)
            framed = parsed.framed
            result = _built(parsed.data, parsed.issues, _source(parsed, name, reach), not changes)
        else:
            result, framed = _loaded(read_text(path), name, reach, not changes, given, lenient)
    if changes:
        result = fitted(result, changed(result, changes), framed)
    path = name if is_builtin else str(Path(name).absolute())
    kept_root = None if root is None or is_builtin else str(Path(root).absolute())
    chosen = (lenient, kept_root, variant, scene_name, animation, at)
    recipe = Recipe(path, tuple(changes), dict(definitions or {}), *chosen)
    return result.from_source(replace(result.source, recipe=recipe))


def load_again(how: Recipe) -> Scene:
    """Load a scene as it was loaded before, or with the recipe changed.

    Parameters
    ----------
    how : Recipe
        Of `Source.recipe`.

    Returns
    -------
    Scene
        Without what was changed in Python afterwards.

    Raises
    ------
    SceneError
        As of `load`.
    """
    return load(
        how.path,
        how.changes,
        definitions=how.definitions,
        lenient=how.lenient,
        root=how.root,
        variant=how.variant,
        scene_name=how.scene_name,
        animation=how.animation,
        at=how.at,
    )


def _check_arguments(changes: Any, definitions: Any, root: Any) -> None:
    expect(definitions, (Mapping, type(None)), "definitions", "a mapping of names to values")
    expect(root, (*PATH, type(None)), "root", "the path of a folder")
    if isinstance(changes, Mapping):
        text = "must list path.to.key=value assignments; alight.changed takes values by key paths"
        raise OptionError(text, "changes")
    _check_assignments(changes)


def _loaded_object(
    value: Any, changes: tuple[str, ...] | list[str], look: Look, reading: Mapping[str, Any]
) -> Scene:
    """The scene of a dictionary, or of an object of another package."""
    for name, given in reading.items():
        if given or (given is not None and name == "at"):
            raise OptionError("says how a file is read, and there is none", name)
    if isinstance(value, Scene):
        raise SceneError([Issue("scene", "is loaded already; change it by alight.changed")])
    if isinstance(value, Mapping):
        if look.given:
            raise OptionError(
                "is for objects of other packages, not for dictionaries", look.given[0]
            )
        data = {"alight": FORMAT_VERSION, **value}
        result, framed = _built(data, [], Source("", None), not changes), None
    else:
        parsed = parse_object(value, look)
        name = name_of(value)
        source = _source(parsed, name, Reach())
        result, framed = _built(parsed.data, parsed.issues, source, not changes), parsed.framed
    return fitted(result, changed(result, changes), framed) if changes else result


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
    return _loaded(text, name, reach, check, definitions or {}, lenient)[0]


def _loaded(
    text: str, name: str, reach: Reach, check: bool, definitions: Mapping[str, str], lenient: bool
) -> tuple[Scene, Bounds | None]:
    """A scene of a text, and what its camera must see where the file has none."""
    if is_xml(text):
        from alight.formats import mitsuba

        parsed = mitsuba.parse(text, name, reach, definitions, lenient)
        source = _source(parsed, name, reach)
        return _built(parsed.data, parsed.issues, source, check), parsed.framed
    data, found, source = _parse(text, name, reach, definitions, lenient)
    return _built(data, found, source, check), None


def _built(data: Any, found: list[Issue], source: Source, check: bool) -> Scene:
    """A scene of plain data, and problems found so far."""
    builder = Builder(found)
    scene = builder.scene(data).from_source(source)
    issues, files = builder.issues, source.files()
    # After a wrong top level nothing is left to check.
    if isinstance(data, dict) and (check or issues):
        # Where something is wrong stands what takes its place: its problems are nobody's.
        wrong = [issue.path for issue in issues]
        issues += [
            issue
            for issue in find_problems(scene, files)
            if not any(is_at_or_below(path, issue.path) for path in wrong)
        ]
    if issues:
        raise SceneError([issue if issue.place else source.located(issue) for issue in issues])
    if check and isinstance(data, dict):
        scene.mark_checked(files)
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
    """Plain data, problems so far and the origin, of pbrt's format or the native one."""
    _refuse_definitions(definitions, name)
    if name.lower().endswith(PBRT):
        from alight.formats import pbrt

        parsed = pbrt.parse(text, name, reach, lenient)
        return parsed.data, parsed.issues, _source(parsed, name, reach)
    data, places, issues = plain_yaml.parse(text, name)
    source = Source(name, reach.folder, places)
    refused = reach.keep_inside(data) if isinstance(data, dict) else {}
    if refused:
        # Whatever else is wrong would be found by reading these files.
        located = [source.located(Issue(path, text)) for path, text in refused.items()]
        raise SceneError([*issues, *located])
    if lenient and isinstance(data, dict):
        source = replace_missing(data, source, reach)
    return data, list(issues), source


def _source(parsed: Parsed, name: str, reach: Reach) -> Source:
    """The origin of a scene of another program, with what has been read of its files."""
    return Source(name, reach.folder, parsed.places, parsed.remarks, held=reach.files.held)


def _refuse_definitions(definitions: Mapping[str, str], name: str) -> None:
    if definitions:
        first = next(iter(definitions))
        issue = Issue(f"-D {first}", "only XML files have parameters; use --set path=value", name)
        raise SceneError([issue])


@known_words()
def changed(scene: Scene, changes: Mapping[str, Any] | tuple[str, ...] | list[str]) -> Scene:
    """Change values of a scene, and check it again.

    What does not change is shared, and rendered from what is known of it: see `SceneManager` for
    nodes that come and go.

    Parameters
    ----------
    scene : Scene
        Stays as it is.
    changes : mapping of str to object, or sequence of str
        Key path as of a scene file -> value as Python data, or ``path.to.key=value`` assignments.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        With every problem.

    Examples
    --------
    >>> scene = load("cornell-box")
    >>> changed(scene, {"film.size": (64, 64), "integrator.max_depth": 3}).film.size
    (64, 64)
    """
    manager = SceneManager(expect(scene, Scene, "scene", "a scene; alight.load(path) reads one"))
    if isinstance(changes, Mapping):
        for path, value in changes.items():
            manager.set_at(path, value)
        changes = []
    _check_assignments(changes)
    for assignment in changes:
        manager.set_value(_with_camera_path(manager.scene, assignment))
    checked_files(manager.scene)
    return manager.scene


def _check_assignments(changes: object) -> None:
    if isinstance(changes, str | bytes) or not isinstance(changes, Sequence):
        text = "must map key paths to values, or list path.to.key=value assignments"
        raise OptionError(f"{text}, got {show_value(changes)}", "changes")


def _with_camera_path(scene: Scene, assignment: str) -> str:
    """Put the path of a camera's node into the place of its number or its last name."""
    key, _, wanted = str(assignment).partition("=")
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
