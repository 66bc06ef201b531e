"""Films: where samples are added up, exactly, with their error bars."""

from alight.films.film import Film, PartialFilm
from alight.films.sample_ranges import CELL_SIZE, SampleRanges

__all__ = ["CELL_SIZE", "Film", "PartialFilm", "SampleRanges"]
