"""Measured reflectances: checked once, never changed.

Arrays are as in the files of Dupuy and Jakob 2018, but that spectra are three channels. Elevations
and azimuths of the viewer are those of rows; the other directions are unit squares whose sides are
read between texels, with the first and last texel on their edges (see `alight.bsdfs.measured.warp`
and `alight.bsdfs.measured.measured`).
"""

from __future__ import annotations

import base64
import binascii
import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic_core import PydanticCustomError, core_schema

from alight.bsdfs.measured.tensor_file import Arrays, parse_tensors, write_tensors
from alight.core.cie import WAVELENGTHS
from alight.core.errors import Issue, SceneError, quote, show_value
from alight.core.fields import LARGEST, invalid
from alight.core.spectra import reflectance_weights

#: Largest file, bytes, and most numbers of one measurement: floats count them exactly.
MOST_BYTES, MOST_NUMBERS = 1 << 28, 1 << 23

#: Nanometres: beyond them lies less than 1 % of each of the observer's curves in daylight.
_VIOLET, _RED = 410.0, 670.0

#: Name -> dimensions of the arrays that every file has.
_DIMENSIONS = {"theta_i": 1, "phi_i": 1, "ndf": 2, "sigma": 2, "vndf": 4, "luminance": 4, "rgb": 5}

Array = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Measurement:
    """What was measured of a material.

    Parameters
    ----------
    arrays : dict of str to float32 array
        theta_i, phi_i : (t,), (p,), radians
            Elevations, from 0, and azimuths of the viewer, ascending.
        ndf : (h, w)
            Density of the directions of facets.
        sigma : (h, w)
            Area of facets that is seen from a direction.
        vndf : (p, t, h, w)
            Density of the directions of facets that the viewer sees.
        luminance : (p, t, h, w)
            Density of the light that these reflect.
        rgb : (p, t, 3, h, w)
            Reflected light, linear sRGB, over what `ndf` and `sigma` say.

    Attributes
    ----------
    digest : str
        SHA-256 of all arrays; measurements with equal digests are equal.
    """

    arrays: dict[str, Array]
    digest: str = field(init=False)

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        digest = hashlib.sha256()
        for name in _DIMENSIONS:
            array = self.arrays[name]
            array.setflags(write=False)
            digest.update(f"{name}{array.shape}".encode())
            digest.update(array.data)
        object.__setattr__(self, "digest", digest.hexdigest())

    def __eq__(self, other: object) -> bool:
        """Compare the contents."""
        return isinstance(other, Measurement) and self.digest == other.digest

    def __hash__(self) -> int:
        """Hash the contents."""
        return hash(self.digest)

    def __repr__(self) -> str:
        """Name the contents, for messages and for the hash of a scene's content."""
        return f"Measurement({'x'.join(map(str, self.arrays['rgb'].shape))}, {self.digest})"

    @property
    def is_isotropic(self) -> bool:
        """Whether only the angle between the azimuths counts."""
        return len(self.arrays["phi_i"]) <= 2

    @property
    def turns(self) -> int:
        """How many times the azimuths of the viewer fit into a turn: 1, 2 or 4."""
        return 1 if self.is_isotropic else round(_turns(self.arrays["phi_i"]))

    def plain(self) -> str:
        """Write it out as scene files hold it: a tensor file in base64."""
        return base64.b64encode(write_tensors(self.arrays)).decode()


def _turns(azimuths: Array) -> float:
    return 2.0 * np.pi / float(azimuths[-1] - azimuths[0])


def measurement_of(arrays: Arrays, note: Callable[[str], None] | None = None) -> Measurement:
    """Check the arrays of a file, and reduce its spectra.

    Parameters
    ----------
    arrays : dict of str to array
        As in the files; `rgb`, or `spectra` and `wavelengths`.
    note : callable, optional
        Called with what had to be changed.

    Raises
    ------
    PydanticCustomError
        If something is missing or wrong.
    """
    arrays = dict(arrays)
    if "rgb" not in arrays:
        arrays["rgb"] = _reduced(arrays, note or (lambda text: None))
    for name, dimensions in _DIMENSIONS.items():
        if name not in arrays:
            raise invalid(f"needs the field {name}; it has {', '.join(sorted(arrays)) or 'none'}")
        array = arrays[name]
        if array.ndim != dimensions or 0 in array.shape or array.dtype.kind not in "iuf":
            raise invalid(f"{name} must have {dimensions} dimensions, got the shape {array.shape}")
        with np.errstate(over="ignore"):
            arrays[name] = np.array(array, np.float32, order="C")
        low = -LARGEST if name == "phi_i" else 0.0
        if not (low <= arrays[name].min() and arrays[name].max() <= LARGEST):
            raise invalid(f"{name} must be finite, >= {low:g} and at most {LARGEST:g} everywhere")
    _check_shapes(arrays)
    jacobian = arrays.get("jacobian")
    if jacobian is not None and jacobian.size and not np.ravel(jacobian)[0]:
        # What was stored is the value itself.
        arrays["ndf"], arrays["sigma"] = np.ones((2, 2), np.float32), np.full((2, 2), 0.25, "f4")
    return Measurement({name: arrays[name] for name in _DIMENSIONS})


def _check_shapes(arrays: Arrays) -> None:
    azimuths, elevations = arrays["phi_i"], arrays["theta_i"]
    rows = len(azimuths), len(elevations)
    for name in ("vndf", "luminance", "rgb"):
        if arrays[name].shape[:2] != rows:
            text = f"{name} must begin with as many rows as phi_i and theta_i have numbers, {rows}"
            raise invalid(f"{text}, got {arrays[name].shape[:2]}")
    if arrays["rgb"].shape[2] != 3:
        raise invalid(f"rgb must have 3 channels, got {arrays['rgb'].shape[2]}")
    if arrays["rgb"].shape[3:] != arrays["luminance"].shape[2:]:
        raise invalid("rgb and luminance must be equally large")
    for name in ("ndf", "sigma", "vndf", "luminance"):
        if min(arrays[name].shape[-2:]) < 2:
            raise invalid(f"{name} must have at least 2 x 2 texels, got {arrays[name].shape[-2:]}")
    count = sum(array.size for array in arrays.values())
    if count > MOST_NUMBERS:
        raise invalid(f"must have at most {MOST_NUMBERS} numbers, got {count}")
    for name, angles in (("theta_i", elevations), ("phi_i", azimuths)):
        if not np.all(np.diff(angles) > 0.0):
            raise invalid(f"{name} must ascend")
    if not (elevations[0] >= 0.0 and elevations[-1] <= 0.5 * np.pi + 0.01):
        text = "theta_i must be in [0, pi/2] radians"
        raise invalid(f"{text}, got {elevations[0]:g} to {elevations[-1]:g}")
    if len(azimuths) > 2 and min(abs(_turns(azimuths) - n) for n in (1, 2, 4)) > 0.01:
        text = "phi_i must span a turn, half a turn or a quarter"
        raise invalid(f"{text}, got {azimuths[0]:g} to {azimuths[-1]:g} radians")
    if len(azimuths) > 2 and abs(azimuths[0] + np.pi) > 0.01:
        raise invalid(f"phi_i must begin at -pi, got {azimuths[0]:g}")
    for name in ("sigma", "vndf", "luminance"):
        if not arrays[name].max() > 0.0:
            raise invalid(f"{name} must be > 0 somewhere")


def _reduced(arrays: Arrays, note: Callable[[str], None]) -> Array:
    """Linear sRGB of spectra under daylight; channels below 0 become 0."""
    spectra, wavelengths = arrays.get("spectra"), arrays.get("wavelengths")
    if spectra is None or wavelengths is None:
        raise invalid("needs the field rgb, or spectra and wavelengths")
    fits = wavelengths.ndim == 1 and spectra.ndim == 5 and spectra.shape[2] == len(wavelengths)
    numeric = spectra.dtype.kind in "iuf" and wavelengths.dtype.kind in "iuf"
    if not (fits and numeric and len(wavelengths) and spectra.size <= 100 * MOST_NUMBERS):
        text = "spectra must have the shape (azimuths, elevations, wavelengths, h, w)"
        raise invalid(f"{text}, got {spectra.shape} for {wavelengths.size} wavelengths")
    if not (np.isfinite(wavelengths).all() and np.all(np.diff(wavelengths) > 0.0)):
        raise invalid("wavelengths must ascend")
    first, last = float(wavelengths[0]), float(wavelengths[-1])
    if last <= WAVELENGTHS[0] or first >= WAVELENGTHS[-1]:
        text = "wavelengths must be in nm, and some of them in (360, 830), which the eye sees"
        raise invalid(f"{text}, got {first:g} to {last:g}")
    if not (np.abs(spectra) <= LARGEST).all():
        raise invalid(f"spectra must be finite and at most {LARGEST:g} in size")
    if first < WAVELENGTHS[0] or last > WAVELENGTHS[-1]:
        note(
            f"its wavelengths, {first:g} to {last:g} nm, go beyond 360 to 830 nm: what lies there "
            "is not seen and was left out"
        )
    if first > _VIOLET or last < _RED:
        note(
            f"its wavelengths, {first:g} to {last:g} nm, do not reach from {_VIOLET:g} to "
            f"{_RED:g} nm: beyond them it is as at the nearest one"
        )
    weights = reflectance_weights(np.array(wavelengths, np.float64)).astype(np.float32)
    rgb = np.einsum("ptlhw,cl->ptchw", spectra, weights)
    least = float(rgb.min())
    share = -least / max(float(rgb.max()), 1e-30)
    clipped = f"; colours outside of it were clipped, by up to {share:.2%} of the brightest"
    note(
        f"its spectra ({len(wavelengths)} wavelengths, {wavelengths[0]:g} to {wavelengths[-1]:g} "
        "nm) became linear sRGB in daylight, which is exact for one reflection of white light"
        + (clipped if least < 0.0 else "")
    )
    return np.maximum(rgb, 0.0)


def read_measurement(path: Path, name: str = "") -> tuple[Measurement, list[str]]:
    """Read a file of measured reflectances (``.bsdf``).

    Parameters
    ----------
    path : Path
    name : str, optional
        How messages call it.

    Returns
    -------
    Measurement
    list of str
        What had to be changed.

    Raises
    ------
    SceneError
        If it is missing, too large, no tensor file, or holds what is no measurement.
    """
    name, notes = name or str(path), []
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise ValueError(f"must be at most {MOST_BYTES} bytes, has {size}")
        found = measurement_of(parse_tensors(path.read_bytes()), notes.append)
    except FileNotFoundError:
        raise SceneError([Issue("file", f"no such file: {quote(name)}")]) from None
    except OSError as error:
        text = f"cannot read {quote(name)}: {error.strerror}"
        raise SceneError([Issue("file", text)]) from None
    except (ValueError, PydanticCustomError) as error:
        text = error.message() if isinstance(error, PydanticCustomError) else str(error)
        raise SceneError([Issue("file", f"{quote(name)}: {text}")]) from None
    return found, [f"{quote(name)}: {text}" for text in notes]


@dataclass(frozen=True)
class MeasurementField:
    """Metadata of a field that holds a `Measurement`."""

    def check(self, value: object) -> Measurement:
        """Accept one, or the text of a tensor file in base64."""
        if isinstance(value, Measurement):
            return value
        if not isinstance(value, str):
            raise invalid(f"must be a tensor file in base64, got {show_value(value)}")
        try:
            return measurement_of(parse_tensors(base64.b64decode(value, validate=True)))
        except (binascii.Error, ValueError) as error:
            raise invalid(f"must be a tensor file in base64: {error}") from None

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Build pydantic's schema from `check`."""
        return core_schema.no_info_plain_validator_function(self.check)


MeasuredData = Annotated[Measurement, MeasurementField()]
