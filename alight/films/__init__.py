"""Films: where samples are added up, exactly, with their error bars."""

from alight.films.film import FIRST_SAMPLE_LAYERS, Film, PartialFilm
from alight.films.sample_ranges import CELL_SIZE, SampleRanges

__all__ = ["CELL_SIZE", "FIRST_SAMPLE_LAYERS", "Film", "PartialFilm", "SampleRanges"]
