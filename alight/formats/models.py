"""Files of other programs that are read as bytes, by the ending of their names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from alight.core.errors import Issue, SceneError
from alight.core.extras import install_command
from alight.formats import gltf, mesh_scene, obj_scene
from alight.formats.materialx import scene as materialx
from alight.formats.parsed import Parsed
from alight.formats.reach import Reach
from alight.formats.shown import Shown
from alight.outputs.texels import reusing_memory

AS_IT_IS = Shown()
Parser = Callable[[bytes, str, Reach], Parsed]


def _read_usd(
    data: bytes, name: str, reach: Reach, shown: Shown = AS_IT_IS, lenient: bool = False
) -> Parsed:
    """Read a file of OpenUSD, if the package for it is there."""
    import importlib.util

    if importlib.util.find_spec("pxr") is None:
        command = install_command("usd", "usd-core")
        text = f"OpenUSD needs the package usd-core: {command}"
        raise SceneError([Issue("", text, name)])
    from alight.formats.usd.scene import parse

    return parse(data, name, reach, shown.at, lenient)


PARSERS: dict[str, Parser] = {
    ".gltf": gltf.parse,
    ".glb": gltf.parse,
    ".obj": obj_scene.parse,
    ".ply": mesh_scene.parse_ply,
    ".stl": mesh_scene.parse_stl,
    ".mtlx": materialx.parse,
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), _read_usd),
}
MOST_BYTES = 2**30


def read_model(
    path: Path, name: str, reach: Reach, shown: Shown = AS_IT_IS, lenient: bool = False
) -> Parsed:
    """Read a file whose ending is one of `PARSERS`.

    Parameters
    ----------
    path : Path
    name : str
        How messages call it.
    reach : Reach
        Where the files that it names may lie.
    shown : Shown, optional
        Which of what the file holds.
    lenient : bool, default False
        See `alight.load`.

    Raises
    ------
    SceneError
        If it cannot be read, or is no scene at all.
    """
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            text = f"must be at most {MOST_BYTES >> 20} MB, got {size >> 20} MB"
            raise SceneError([Issue("", text, name)])
        with path.open("rb") as file:
            # OpenUSD reads its files itself.
            data = b"" if PARSERS[path.suffix.lower()] is _read_usd else file.read()
    except OSError as error:
        raise SceneError([Issue("", f"cannot be read: {error.strerror}", name)]) from None
    parser = PARSERS[path.suffix.lower()]
    with reusing_memory():
        if parser is gltf.parse:
            return gltf.parse(data, name, reach, shown, lenient)
        if parser is materialx.parse:
            shown.refuse(name, ("variant",))
            return materialx.parse(data, name, reach, shown, lenient)
        if parser is _read_usd:
            shown.refuse(name, ("at",))
            return _read_usd(data, name, reach, shown, lenient)
        shown.refuse(name)
        if parser is obj_scene.parse:
            return obj_scene.parse(data, name, reach, lenient)
        return parser(data, name, reach)
