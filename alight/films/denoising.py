"""Denoising: a trained filter guesses the picture that many more samples would give.

The filter is Intel's Open Image Denoise (Áfra 2019-2026, openimagedenoise.org; extra ``denoise``),
fed with the picture and, where the film has them, the layers ``albedo_through`` and
``normal_through``. It is biased, and by how much nobody knows: the noisy picture stays in the
layers ``noisy.R``, ``.G``, ``.B`` of the file, the error layers speak of it alone, and the ledger
names the denoiser with the change of the picture's mean.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from alight.core.arguments import expect, known_words
from alight.core.errors import OptionError
from alight.core.extras import install_command
from alight.films.ledger import Bias
from alight.outputs.picture import Picture

if TYPE_CHECKING:
    from alight.films.film import Film

#: Layers that help the filter, by its own names for them.
FEATURES = {"albedo": "albedo_through", "normal": "normal_through"}


def check_denoiser() -> None:
    """Refuse to denoise without the package for it.

    Raises
    ------
    OptionError
    """
    import importlib.util

    if importlib.util.find_spec("pyoidn") is None:
        command = install_command("denoise", "pyoidn")
        raise OptionError(f"denoising needs the package pyoidn: {command}")


@known_words()
def denoise(film: Film) -> tuple[Picture, Bias]:
    """Denoise the picture of a film.

    Parameters
    ----------
    film : Film
        With the layers of `FEATURES`, or with less detail in the result.

    Returns
    -------
    picture : Picture
        The denoised picture, with the noisy one as layers.
    bias : Bias
        The entry of the ledger; its effect is the change of the mean, as a share of it.

    Raises
    ------
    OptionError
        If the package `pyoidn` is not installed.

    Examples
    --------
    >>> aovs = ["albedo_through", "normal_through"]
    >>> film = alight.render("cornell-box", spp=16, aovs=aovs)  # doctest: +SKIP
    >>> alight.outputs.write_image("cornell.png", alight.denoise(film)[0])  # doctest: +SKIP
    """
    from alight.films.film import Film

    expect(film, Film, "film", "a film; Film.load(path) reads one")
    check_denoiser()
    picture = film.picture(True)
    features = {
        name: _plane(film, layer) for name, layer in FEATURES.items() if layer in film.aov_channels
    }
    image = _filtered(picture.image, features)
    bias = _bias_of(picture.image, image, list(features))
    layers = {f"noisy.{c}": picture.image[..., i] for i, c in enumerate("RGB")} | picture.layers
    biases = "; ".join([*(known.line for known in film.biases), bias.line])
    # The error is that of the picture before.
    known = {name: text for name, text in picture.attributes.items() if name != "error"}
    attributes = known | {"biases": biases}
    return replace(picture, image=image, layers=layers, attributes=attributes), bias


def _plane(film: Film, layer: str) -> np.ndarray:
    # Albedos of mirrors of metal and weights of fluorescent tints may pass 1; normals of several
    # samples are means, as the filter expects them.
    bounds = (0.0, 1.0) if layer == FEATURES["albedo"] else (-1.0, 1.0)
    return np.ascontiguousarray(np.clip(film.aov(layer), *bounds), np.float32)


def _filtered(image: np.ndarray, features: dict[str, np.ndarray]) -> np.ndarray:
    from pyoidn.denoise import denoise as run

    # Always as HDR: the other network takes values above 1 for white.
    noisy = np.ascontiguousarray(np.maximum(image, 0.0), np.float32)
    return run(noisy, **features, hdr=True)


def _bias_of(noisy: np.ndarray, image: np.ndarray, features: list[str]) -> Bias:
    from importlib.metadata import version

    before, after = float(noisy.mean(dtype=np.float64)), float(image.mean(dtype=np.float64))
    effect = (after - before) / before if before > 0.0 else None
    helped = f" with {' and '.join(features)}" if features else ""
    name = f"Open Image Denoise (pyoidn {version('pyoidn')})"
    text = f"denoised by {name}{helped}; error bars are those of the noisy picture"
    return Bias("denoiser", text, effect)
