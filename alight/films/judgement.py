"""How wrong a film's picture is, and where nobody can tell: worked out together, and once.

A render ends with several questions about the same samples: the summary, ``--stats`` and the layers
of a picture ask for the error and for the unsure pixels. Both begin with the same survey.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from alight.metrics.error_estimate import ErrorEstimate
from alight.metrics.own_error import relmse_of
from alight.metrics.pixel_bars import unsure_pixels
from alight.metrics.survey import survey

if TYPE_CHECKING:
    from alight.films.film import Film


class Judged(NamedTuple):
    """What is known of a film with so many samples.

    Attributes
    ----------
    samples : int
        Of the whole film; films only grow, so that their number says which.
    unsure : ndarray of bool, shape (h, w)
    error : ErrorEstimate or None
    literature : bool
        Whether `error` has the figure of the literature.
    """

    samples: int = -1
    unsure: np.ndarray = np.zeros((0, 0), bool)
    error: ErrorEstimate | None = None
    literature: bool = False


def unsure_of(film: Film, known: Judged) -> Judged:
    """Find the unsure pixels, if they are not known."""
    if known.samples == _samples_of(film):
        return known
    means, counts = film.replicate_means()
    seen = survey(means, counts, film.shares_paths)
    return Judged(int(counts.sum()), unsure_pixels(seen))


def judge(film: Film, known: Judged, literature: bool) -> Judged:
    """Find the error and the unsure pixels, if they are not known."""
    same = known.samples == _samples_of(film)
    if same and known.error is not None and known.literature >= literature:
        return known
    means, counts = film.replicate_means()
    seen, samples = survey(means, counts, film.shares_paths), int(counts.sum())
    # Tiles may have come in between.
    unsure = known.unsure if samples == known.samples else unsure_pixels(seen)
    return Judged(samples, unsure, relmse_of(seen, literature), literature)


def _samples_of(film: Film) -> int:
    with film.lock:
        return int(film.counts.sum())
