"""Pictures of any renderer, read for a comparison: linear, three channels, errors if they have any.

OpenEXR files of alight hold the standard error of every pixel in layers ``standard_error.R`` and so
on, the numbers of samples in ``samples``, and the number of replicates in their header; no other
format does.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from alight.core.arguments import PATH, expect
from alight.core.errors import OutputError, unknown_name
from alight.core.srgb import decode_srgb
from alight.films import Film
from alight.outputs import exr
from alight.outputs.texels import read_texels

#: Layers that renderers call the picture itself, the last part of the name.
_MAIN_LAYERS = ("combined", "beauty", "color", "rgb", "rgba")

#: Values of a comparison are float64, several planes at a time: 2^26 pixels are enough.
_MOST_PIXELS = 2**26


@dataclass(frozen=True)
class Input:
    """A picture to compare.

    Attributes
    ----------
    name : str
        As the user wrote it.
    image : ndarray of float32, shape (h, w, 3)
        Linear sRGB.
    is_display : bool
        Whether the file holds display values (PNG, JPEG), cut at 1.
    error : ndarray of float32, shape (h, w, 3), or None
        Standard errors, NaN where unknown.
    replicates : int
        R of the standard errors; 0 without.
    samples : ndarray of uint32, shape (h, w), or None
        Samples of each pixel, where standard errors are known.
    place : (int, int) or None
        Where in its full film or display window the upper left pixel lies, if that is known.
    remarks : list of str
        What was done to make it comparable, and what is suspicious.
    """

    name: str
    image: np.ndarray
    is_display: bool
    error: np.ndarray | None = None
    replicates: int = 0
    samples: np.ndarray | None = None
    place: tuple[int, int] | None = None
    remarks: list[str] = field(default_factory=list)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height."""
        return self.image.shape[1], self.image.shape[0]


def as_input(source: Any, name: str, layer: str | None) -> Input:
    """Make an input of what is to be compared.

    Parameters
    ----------
    source : path, Film or ndarray of shape (h, w), (h, w, 1) or (h, w, 3)
        Arrays of floats are linear.
    name : str
        Of what has no path.
    layer : str or None
        Of an EXR file or of a film.

    Raises
    ------
    OutputError
        As `read_input`, and for an array that is no picture.
    """
    try:
        if isinstance(source, np.ndarray):
            if layer is not None:
                raise ValueError("only OpenEXR files have layers")
            return _as_input(name, source)
        if isinstance(source, Film):
            picture = source.picture()
            own = {c: picture.image[..., i] for i, c in enumerate("RGB")}
            found = _of_channels(name, {**own, **picture.layers}, picture.attributes, layer)
            return replace(found, place=picture.offset)
    except ValueError as error:
        raise OutputError(f"cannot compare {name}: {_sentence(error)}") from error
    wanted = "a picture: its path, a film or an array of shape (h, w, 3)"
    return read_input(expect(source, PATH, name.lower(), wanted), layer)


def read_input(path: str | Path, layer: str | None = None) -> Input:
    """Read a picture.

    Parameters
    ----------
    path : path
        EXR, PNG, JPEG, NPY, HDR or PFM; recognised by content, not by name.
    layer : str, optional
        Of an EXR file, instead of the picture: ``albedo`` for the channels ``albedo.R`` ...

    Raises
    ------
    OutputError
        If the file is missing, broken, no picture, or has no such layer.
    """
    path = Path(path)
    try:
        if path.is_file():
            with path.open("rb") as file:
                if file.read(4) == b"\x76\x2f\x31\x01":
                    return _read_exr(path, layer)
        if layer is not None:
            raise ValueError("only OpenEXR files have layers")
        return _as_input(str(path), read_texels(path, _check_size))
    except FileNotFoundError:
        raise OutputError(f"cannot read {path}: there is no such file") from None
    except PermissionError:
        raise OutputError(f"cannot read {path}: no permission to read it") from None
    except OutputError:
        raise
    except (OSError, ValueError) as error:
        raise OutputError(f"cannot read {path}: {_sentence(error)}") from error


def _sentence(error: Exception) -> str:
    text = str(error)
    return f"it {text}" if text.startswith(("is ", "has ", "must ", "takes ")) else text


def _check_size(width: int, height: int) -> None:
    if width < 1 or height < 1:
        raise ValueError("has no pixels")
    if width * height > _MOST_PIXELS:
        raise ValueError(f"has too many pixels: {width} x {height}, at most {_MOST_PIXELS}")


def _as_input(name: str, texels: np.ndarray) -> Input:
    """Make linear colour of what is stored."""
    remarks = []
    if texels.ndim not in (2, 3):
        raise ValueError(f"has the shape {texels.shape}; a picture has (h, w) or (h, w, 3)")
    if texels.ndim == 2:
        texels = texels[..., None]
    channels = texels.shape[2]
    if channels in (2, 4):
        remarks.append(f"{name}: alpha is left out")
        texels = texels[..., : channels - 1]
    elif channels not in (1, 3):
        raise ValueError(f"has {channels} channels; a picture has 1 or 3, and perhaps alpha")
    if texels.shape[2] == 1:
        remarks.append(f"{name}: grey, compared as three equal channels")
    kind = texels.dtype
    if kind.kind not in "fiub":
        raise ValueError(f"has values of type {kind}, which are no numbers")
    is_display = kind in (np.uint8, np.uint16)
    if is_display:
        texels = decode_srgb(texels / np.float64(np.iinfo(kind).max))
    image = np.broadcast_to(texels, (*texels.shape[:2], 3))
    return Input(name, np.ascontiguousarray(image, np.float32), bool(is_display), remarks=remarks)


def _read_exr(path: Path, layer: str | None) -> Input:
    data, display, _ = exr.read_windows(path)
    _check_size(*data.size)
    channels, header = exr.read_layers(path)
    if len({plane.shape for plane in channels.values()}) > 1:
        raise ValueError("has channels of different sizes")
    left, top = (a - b for a, b in zip(data.low, display.low, strict=True))
    return replace(_of_channels(str(path), channels, header, layer), place=(left, top))


def _of_channels(
    name: str, channels: Mapping[str, np.ndarray], header: Mapping[str, str], layer: str | None
) -> Input:
    """Make an input of what an EXR file holds, or would hold."""
    names = _channel_names(channels, layer)
    found = _as_input(name, np.stack([channels[one] for one in names], axis=-1))
    errors = [f"standard_error.{c}" for c in "RGB"]
    replicates = header.get("replicates", "")
    if layer is None and all(name in channels for name in errors) and replicates.isdecimal():
        error = np.stack([channels[name] for name in errors], axis=-1)
        # Without samples in every replicate nothing is known: no test then.
        if int(replicates) >= 2 and np.isfinite(error).any():
            samples = channels.get("samples")
            return replace(found, error=error, replicates=int(replicates), samples=samples)
    return found


def _channel_names(channels: Iterable[str], layer: str | None) -> list[str]:
    """Channels of the picture, or of the requested layer."""
    names = set(channels)
    layers = {name.rpartition(".")[0] for name in names}
    if layer is not None:
        if layer not in layers:
            named = sorted(one for one in layers if one)
            raise ValueError(unknown_name("layer", layer, named))
        return _parts(names, layer)
    if "" in layers and (found := _parts(names, "", must=False)):
        return found
    colors = sorted(one for one in layers if one and {f"{one}.{c}" for c in "RGB"} <= names)
    main = [one for one in colors if one.rpartition(".")[2].lower() in _MAIN_LAYERS]
    chosen = main or colors
    if len(chosen) == 1:
        return _parts(names, chosen[0])
    listed = ", ".join(sorted(one for one in layers if one)) or ", ".join(sorted(names))
    raise ValueError(f"has no channels R, G, B or Y; name one of its layers: {listed}")


def _parts(names: set[str], layer: str, must: bool = True) -> list[str]:
    """Channels of a layer: red, green, blue, or x, y, z, or the only one."""
    prefix = f"{layer}." if layer else ""
    for three in ("RGB", "rgb", "XYZ", "xyz"):
        if all(prefix + c in names for c in three):
            return [prefix + c for c in three]
    inside = sorted(name for name in names if name.rpartition(".")[0] == layer)
    plain = [name for name in inside if name.rpartition(".")[2] not in ("A", "samples")]
    if f"{prefix}Y" in names:
        return [f"{prefix}Y"]
    if len(plain) == 1:
        return plain
    if must:
        raise ValueError(f"has no colour in layer {layer}; it has {', '.join(inside)}")
    return []


def make_comparable(inputs: list[Input], skip_invalid: bool = False) -> list[Input]:
    """Check that pictures can be compared.

    Parameters
    ----------
    inputs : list of Input
    skip_invalid : bool, default False
        Make pixels that are NaN or infinite in one picture black in all, instead of refusing.

    Raises
    ------
    OutputError
        If the sizes differ, or pixels are NaN or infinite.
    """
    inputs = _on_one_display(inputs)
    first = inputs[0]
    for other in inputs[1:]:
        if other.size != first.size:
            (w, h), (v, g) = first.size, other.size
            raise OutputError(
                f"the pictures have different sizes: {first.name} {w} x {h}, "
                f"{other.name} {v} x {g} pixels"
            )
    inputs = [first, *(_of_one_place(other, first) for other in inputs[1:])]
    invalid = [~np.isfinite(one.image).all(axis=2) for one in inputs]
    for one, bad in zip(inputs, invalid, strict=True):
        if bad.any() and not skip_invalid:
            y, x = (int(v[0]) for v in np.nonzero(bad))
            what = "NaN" if np.isnan(one.image[y, x]).any() else "infinite"
            raise OutputError(
                f"{one.name}: {int(bad.sum())} of {bad.size} pixels are NaN or infinite, the first "
                f"at {x},{y} ({what}); --skip-invalid leaves them out"
            )
    bad = np.logical_or.reduce(invalid)
    if not bad.any():
        return inputs
    return [_without(one, bad, own) for one, own in zip(inputs, invalid, strict=True)]


def _of_one_place(one: Input, first: Input) -> Input:
    """Say that pictures may be of different parts: crops of one size, but from other places."""
    if one.place == first.place or one.place is None or first.place is None:
        return one
    (x, y), (u, v) = one.place, first.place
    text = f"{one.name}: begins at {x},{y} of its full picture, {first.name} at {u},{v}"
    return replace(one, remarks=[*one.remarks, text])


def _on_one_display(inputs: list[Input]) -> list[Input]:
    """Cut all pictures at 1 if one is: beyond that a display file knows nothing.

    Its values are rounded too, to 1 / 255 of the encoded range: far more than many a standard
    error, so these no longer count.
    """
    if not any(one.is_display for one in inputs):
        return inputs
    cut = []
    for one in inputs:
        remarks = list(one.remarks)
        if not one.is_display:
            remarks.append(f"{one.name}: cut to [0, 1], as the other picture is")
        # NaN stay: they are reported.
        image = np.clip(one.image, 0.0, 1.0)
        cut.append(replace(one, image=image, error=None, replicates=0, remarks=remarks))
    return cut


def _without(one: Input, bad: np.ndarray, own: np.ndarray) -> Input:
    """Black where some picture is invalid, of unknown error there."""
    image = np.where(bad[..., None], np.float32(0.0), one.image)
    error = None if one.error is None else np.where(bad[..., None], np.float32(np.nan), one.error)
    remarks = list(one.remarks)
    if own.any():
        remarks.append(f"{one.name}: {int(own.sum())} pixels are NaN or infinite, left out of all")
    return replace(one, image=image, error=error, remarks=remarks)
