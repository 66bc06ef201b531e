"""Mattes: the coverage of named things in a film, and the ranks that a Cryptomatte holds of it.

The share of a pixel that a thing covers is the weight of its samples over their number, as for all
layers. With pixel filters that are negative somewhere it may lie outside of [0, 1] by their noise.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from alight.core.arguments import expect
from alight.core.errors import FilmError, unknown_name
from alight.films import fixed_point
from alight.films.coverage import SurfaceSums
from alight.outputs import cryptomatte

if TYPE_CHECKING:
    from alight.films.film import Film

#: The layers that name what is seen, and how a Cryptomatte calls them. In `Coverage.names` they
#: are in the same order.
MATTES = {"cryptomatte_object": "CryptoObject", "cryptomatte_material": "CryptoMaterial"}

#: All of them by one word.
ALL_MATTES = "cryptomatte"

#: Names below this one belong to it.
_BELOW = "/"


def mask_of(film: Film, name: str, layer: str) -> np.ndarray:
    """Coverage of what has this name or is below it: see `Film.mask`."""
    expect(name, str, "name", "the name of an object or a material")
    rows, samples = _weights_of(film)
    names = _names_in(film, layer)
    wanted = np.array([_is_part(one, name, layer) for one in names], bool)
    if not wanted.any():
        kind = MATTES[layer].removeprefix("Crypto").lower()
        raise FilmError(unknown_name(kind, name, _known(names, layer)))
    own = wanted[rows.surfaces]
    joined = SurfaceSums.gathered(rows.pixels[own], 0 * rows.surfaces[own], rows.sums[own])
    image = np.zeros(samples.shape)
    image.ravel()[joined.pixels] = fixed_point.to_float(joined.sums)
    return (image / samples).astype(np.float32)


def colors_of(film: Film, layer: str) -> np.ndarray:
    """The mattes of a layer in colours of their ids, float32, shape (h, w, 3)."""
    (rows, samples), ids = _weights_of(film), _ids_of(film, layer)
    painted, values = cryptomatte.colors_of(ids[rows.surfaces]), fixed_point.to_float(rows.sums)
    planes = [
        np.bincount(rows.pixels, values * painted[:, i], minlength=samples.size) for i in range(3)
    ]
    image = np.stack(planes, axis=-1).reshape(*samples.shape, 3)
    return (image / samples[..., None]).astype(np.float32)


def ranks_of(film: Film, layer: str) -> tuple[np.ndarray, np.ndarray]:
    """Ids and coverages of each pixel, the largest first, shape (h, w, ranks).

    What is seen with no weight has no rank; equal coverages are in the order of their ids.

    Returns
    -------
    ids : ndarray of uint32
    coverages : ndarray of float32
    """
    (rows, samples), ids = _weights_of(film), _ids_of(film, layer)
    # Things of one name are one thing.
    joined = SurfaceSums.gathered(rows.pixels, ids[rows.surfaces].astype(np.int64), rows.sums)
    share = fixed_point.to_float(joined.sums) / samples.ravel()[joined.pixels]
    order = np.lexsort((joined.surfaces, -share, joined.pixels))
    order = order[share[order] > 0.0]
    pixels = joined.pixels[order]
    rank = np.arange(len(pixels)) - np.searchsorted(pixels, pixels)
    kept = rank < cryptomatte.RANKS
    shape = (samples.size, cryptomatte.RANKS)
    found, shares = np.zeros(shape, np.uint32), np.zeros(shape, np.float32)
    at = pixels[kept], rank[kept]
    found[at], shares[at] = joined.surfaces[order][kept], share[order][kept]
    return found.reshape(*samples.shape, -1), shares.reshape(*samples.shape, -1)


def planes_of(film: Film) -> dict[str, np.ndarray]:
    """The channels of the Cryptomattes that a film was asked for."""
    planes: dict[str, np.ndarray] = {}
    for layer in _asked(film):
        planes |= cryptomatte.planes_of(MATTES[layer], *ranks_of(film, layer))
    return planes


def header_of(film: Film) -> dict[str, str]:
    """What a file's header says of them."""
    header: dict[str, str] = {}
    for layer in _asked(film):
        header |= cryptomatte.header_of(MATTES[layer], _names_in(film, layer))
    return header


def _asked(film: Film) -> list[str]:
    return [layer for layer in MATTES if layer in film.aov_channels]


def _weights_of(film: Film) -> tuple[SurfaceSums, np.ndarray]:
    """The table of a film, and the samples of each pixel, 1 at least."""
    if film.coverage is None:
        raise FilmError(f'the film has no mattes; render it with aovs="{ALL_MATTES}"')
    with film.lock:
        return film.coverage.sums, np.maximum(film.counts.sum(axis=2), 1)


def _names_in(film: Film, layer: str) -> list[str]:
    """Of each surface its name in a layer."""
    if layer not in MATTES:
        raise FilmError(unknown_name("layer of mattes", layer, MATTES))
    number = list(MATTES).index(layer)
    return [names[number] for names in film.coverage.names] if film.coverage else []


def _ids_of(film: Film, layer: str) -> np.ndarray:
    names = _names_in(film, layer)
    known = {name: cryptomatte.id_of(name) for name in dict.fromkeys(names)}
    return np.array([known[name] for name in names], np.uint32)


def _is_hierarchical(layer: str) -> bool:
    """Whether the names of a layer are paths."""
    return layer == next(iter(MATTES))


def _is_part(one: str, name: str, layer: str) -> bool:
    return one == name or (_is_hierarchical(layer) and one.startswith(name + _BELOW))


def _known(names: list[str], layer: str) -> set[str]:
    """Names that a mask may have: those of whole branches, too."""
    known = set(names)
    if _is_hierarchical(layer):
        for name in names:
            pieces = name.split(_BELOW)
            known |= {_BELOW.join(pieces[:count]) for count in range(1, len(pieces))}
    return known
