"""The layers of a film or of a file, each as numbers, and what they are at one pixel."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from alight.films import Film
from alight.films.storage import is_film_file
from alight.outputs import exr
from alight.outputs.image import format_of, read_image
from alight.outputs.picture import Picture, as_picture

#: The layer that is the picture itself, and those that every film has.
PICTURE, ERROR, SAMPLES = "picture", "error", "samples"

#: Sides of a full picture over those of the picture while the camera moves.
COARSER = 4

#: A pixel's error is relative to the larger of its value and this share of the picture's mean.
DARKEST = 0.1


def names_with(asked: Iterable[str]) -> tuple[str, ...]:
    """The layers of a film, with those that were asked for."""
    return (PICTURE, ERROR, SAMPLES, *asked)


class Layers(ABC):
    """Something with layers of one size.

    Attributes
    ----------
    size : (int, int)
        Width and height in pixels.
    names : tuple of str
        The picture is the first.
    number : int
        Of the view of a live scene that they show.
    """

    number = 0

    size: tuple[int, int]
    names: tuple[str, ...]

    @abstractmethod
    def plane(self, name: str) -> np.ndarray:
        """Give a layer, shape (h, w, c) with one to four channels."""

    @abstractmethod
    def values(self, x: int, y: int) -> dict[str, list[float]]:
        """Give every layer at one pixel."""


class FilmLayers(Layers):
    """The layers of a film, which may be read while it grows."""

    def __init__(self, film: Film) -> None:
        self.film = film
        _, _, width, height = film.crop
        self.size = width, height
        self.names = names_with(film.aov_channels)

    def plane(self, name: str) -> np.ndarray:
        """Work a layer out of the sums."""
        if name == PICTURE:
            return self.film.image
        if name == SAMPLES:
            return self.film.sample_count[..., None]
        if name == ERROR:
            return relative_error(self.film.image, self.film.standard_error)
        return self.film.aov(name)

    def values(self, x: int, y: int) -> dict[str, list[float]]:
        """Give the pixel, its standard error, the 95 % interval, samples and layers."""
        film, window = self.film.snapshot(), _window(x, y)
        bars = film.interval()
        found = {
            PICTURE: film.image[y, x], "standard error": film.standard_error[y, x],
            "95 % from": bars.low[y, x], "95 % to": bars.high[y, x],
            SAMPLES: film.sample_count[window],
        }  # fmt: skip
        found |= {name: film.aov(name)[y, x] for name in film.aov_channels}
        return {name: _numbers(value) for name, value in found.items()}


class GrowingLayers(FilmLayers):
    """A film that grows; pixels without a sample yet show the small picture of the same view."""

    def __init__(self, film: Film, small: np.ndarray) -> None:
        super().__init__(film)
        self.small = small

    def plane(self, name: str) -> np.ndarray:
        """As of any film, but for the picture."""
        if name != PICTURE:
            return super().plane(name)
        # The samples first: what comes between is in the image, though not yet counted.
        empty = self.film.sample_count == 0
        image = self.film.image
        if empty.any():
            y, x = np.nonzero(empty)
            rows, columns = self.small.shape[:2]
            image[y, x] = self.small[
                np.minimum(y // COARSER, rows - 1), np.minimum(x // COARSER, columns - 1)
            ]
        return image


class FileLayers(Layers):
    """The layers of a file: channels by the part of their names before the last dot."""

    def __init__(self, picture: Picture) -> None:
        height, width = picture.image.shape[:2]
        self.size = width, height
        groups: dict[str, dict[str, np.ndarray]] = {}
        for name in sorted(picture.layers, key=lambda name: name.rpartition(".")):
            group, _, channel = name.rpartition(".")
            groups.setdefault(group or channel, {})[channel] = picture.layers[name]
        self._planes = {PICTURE: picture.image}
        for name, channels in groups.items():
            planes = [channels[channel] for channel in _in_order(channels)]
            # What has more channels than a colour is shown channel by channel.
            self._planes |= {name: np.stack(planes, axis=-1)} if len(planes) <= 4 else {
                f"{name}.{number}": plane[..., None] for number, plane in enumerate(planes)
            }  # fmt: skip
        if "standard_error" in self._planes:
            self._planes[ERROR] = relative_error(picture.image, self._planes["standard_error"])
        self.names = tuple(self._planes)

    def plane(self, name: str) -> np.ndarray:
        """Give the channels."""
        return self._planes[name]

    def values(self, x: int, y: int) -> dict[str, list[float]]:
        """Give every channel."""
        return {name: _numbers(plane[y, x]) for name, plane in self._planes.items()}


def read_layers(path: Path) -> Layers:
    """Read a film, or a picture of any format that alight reads.

    Raises
    ------
    OutputError, FilmError
        If the file is missing, broken or of an unknown format.
    """
    if is_film_file(path):
        return FilmLayers(Film.load(path))
    image = read_image(path)
    if format_of(path) is not exr:
        return FileLayers(as_picture(image))
    channels, attributes = exr.read_layers(path)
    layers = {name: plane for name, plane in channels.items() if name not in "RGBY"}
    return FileLayers(Picture(image, layers, attributes))


def relative_error(image: np.ndarray, error: np.ndarray) -> np.ndarray:
    """The error of each pixel over its value, by the mean of its channels, shape (h, w, 1).

    Very dark pixels count as a tenth of the picture's mean, as in relMSE.
    """
    grey = np.maximum(image, 0.0).mean(axis=-1, keepdims=True)
    scale = np.maximum(grey, DARKEST * float(grey.mean()))
    noise = np.sqrt(np.square(error).mean(axis=-1, keepdims=True))
    return np.divide(noise, scale, out=np.full_like(noise, np.nan), where=scale > 0.0)


def _in_order(channels: Iterable[str]) -> list[str]:
    """Channels of a layer, red before green, x before y; in small letters if they are a colour."""
    order = "rgba" if set("rgb") <= set(channels) <= set("rgba") else "RGBXYZUVA"
    return sorted(channels, key=lambda name: (order.find(name), name))


def _window(x: int, y: int) -> tuple[slice, slice]:
    return slice(y, y + 1), slice(x, x + 1)


def _numbers(value: Any) -> list[float]:
    return [float(one) for one in np.ravel(value)]
