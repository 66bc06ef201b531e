"""What a format writes: a linear picture, its further layers, and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from alight.core.errors import OutputError
from alight.core.srgb import encode_srgb


@dataclass(frozen=True)
class Picture:
    """A picture with everything that a format may keep.

    Parameters
    ----------
    image : ndarray of float32, shape (h, w, 3)
        Linear sRGB, top row first.
    layers : dict of str to ndarray, shape (h, w), float32 or uint32
        Further channels by their full name, for instance ``albedo.R``.
    attributes : dict of str to str
        Provenance.
    size : (int, int), optional
        Width and height of the full film; the picture may be a crop of it.
    offset : (int, int), default (0, 0)
        Pixel of the full film that the upper left corner is.
    alpha : ndarray of float32, shape (h, w), optional
        Coverage, by which `image` is multiplied already.
    shadow : ndarray of float32, shape (h, w), optional
        Further share of the background that is kept from sight: black, beside what covers.
    header : dict of str to str
        What other programs look for in a file, under its full names.
    """

    image: np.ndarray
    layers: dict[str, np.ndarray] = field(default_factory=dict)
    attributes: dict[str, str] = field(default_factory=dict)
    size: tuple[int, int] | None = None
    offset: tuple[int, int] = (0, 0)
    alpha: np.ndarray | None = None
    header: dict[str, str] = field(default_factory=dict)
    shadow: np.ndarray | None = None

    @property
    def opacity(self) -> np.ndarray | None:
        """Share of the background that is not seen, in linear light: coverage and shadow."""
        return self.alpha if self.alpha is None or self.shadow is None else self.alpha + self.shadow

    def over_display(self, encoded: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        """Colours and alpha for programs that blend values encoded for a display, as browsers do.

        A shadow that lets the share s of the light through shows a background of the encoded value
        b as sRGB(s) b: where the curve is a power, that is what s makes of its light. Edges are
        blended by coverage, as is usual.

        Parameters
        ----------
        encoded : ndarray of float, shape (h, w, 3)
            `straight`, encoded.

        Returns
        -------
        ndarray of float, shape (h, w, 3)
            Straight colours.
        ndarray of float, shape (h, w), or None
            Alpha in [0, 1], if there is any.
        """
        if self.alpha is None or self.shadow is None:
            return encoded, None if self.alpha is None else np.clip(self.alpha, 0.0, 1.0)
        covered = np.clip(self.alpha.astype(np.float64), 0.0, 1.0)
        beside = np.where(covered < 1.0, 1.0 - covered, 1.0)
        seen = beside * encode_srgb(np.clip(1.0 - self.shadow / beside, 0.0, 1.0))
        alpha = np.where(covered < 1.0, 1.0 - seen, 1.0)
        share = covered / np.where(alpha > 0.0, alpha, 1.0)
        return encoded * share[..., None], alpha

    def rows(self, rows: slice) -> Picture:
        """Some rows, without the layers."""
        cut = (None if plane is None else plane[rows] for plane in (self.alpha, self.shadow))
        alpha, shadow = cut
        return Picture(self.image[rows], alpha=alpha, shadow=shadow)

    @property
    def straight(self) -> np.ndarray:
        """The colours of what covers a pixel: `image` over alpha, 0 where that is 0."""
        if self.alpha is None:
            return self.image
        whole = np.where(self.alpha > 0.0, self.alpha, np.float32(np.inf))
        return self.image / whole[..., None]

    @property
    def full_size(self) -> tuple[int, int]:
        """Width and height of the full film."""
        return self.size or (self.image.shape[1], self.image.shape[0])


def as_picture(source: Any, layers: bool = True) -> Picture:
    """Make a `Picture` from an array or anything with a method `picture(layers)`, as a film.

    Parameters
    ----------
    source : Picture, film, or array of shape (h, w), (h, w, 1) or (h, w, 3)
        Arrays are linear; one channel becomes grey.
    layers : bool, default True
        Whether the format keeps layers; a film need not work them out else.

    Raises
    ------
    OutputError
        For an array that is no picture.
    """
    if isinstance(source, Picture):
        return source
    if hasattr(source, "picture"):
        return source.picture(layers)
    image = np.asarray(source)
    if image.dtype.kind not in "fiu":
        raise OutputError(f"a picture must hold numbers, got an array of {image.dtype}")
    if image.ndim == 2:
        image = image[..., None]
    if image.ndim != 3 or image.shape[2] not in (1, 3) or 0 in image.shape:
        raise OutputError(
            f"a picture must have the shape (h, w) or (h, w, 3), got {np.asarray(source).shape}"
        )
    image = np.broadcast_to(image, (*image.shape[:2], 3))
    return Picture(np.ascontiguousarray(image, np.float32))
