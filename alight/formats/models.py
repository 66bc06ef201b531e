"""Files of other programs that are read as bytes, by the ending of their names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from alight.core.errors import Issue, SceneError
from alight.core.extras import install_command
from alight.formats import gltf, mesh_scene, obj_scene
from alight.formats.parsed import Parsed
from alight.formats.reach import Reach
from alight.outputs.texels import reusing_memory

Parser = Callable[[bytes, str, Reach], Parsed]


def _read_usd(data: bytes, name: str, reach: Reach) -> Parsed:
    """Read a file of OpenUSD, if the package for it is there."""
    import importlib.util

    if importlib.util.find_spec("pxr") is None:
        command = install_command("usd", "usd-core")
        text = f"OpenUSD needs the package usd-core: {command}"
        raise SceneError([Issue("", text, name)])
    from alight.formats.usd.scene import parse

    return parse(data, name, reach)


PARSERS: dict[str, Parser] = {
    ".gltf": gltf.parse,
    ".glb": gltf.parse,
    ".obj": obj_scene.parse,
    ".ply": mesh_scene.parse_ply,
    ".stl": mesh_scene.parse_stl,
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), _read_usd),
}
MOST_BYTES = 2**30


def read_model(path: Path, name: str, reach: Reach, variant: str | None = None) -> Parsed:
    """Read a file whose ending is one of `PARSERS`.

    Parameters
    ----------
    path : Path
    name : str
        How messages call it.
    reach : Reach
        Where the files that it names may lie.
    variant : str, optional
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
            return gltf.parse(data, name, reach, variant)
        refuse_variant(variant, name)
        return parser(data, name, reach)


def refuse_variant(variant: str | None, name: str) -> None:
    """Refuse the choice of a variant for files of formats without any."""
    if variant is not None:
        raise SceneError([Issue("--variant", "only glTF files have variants of materials", name)])
