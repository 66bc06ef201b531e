"""Films: where samples are added up, exactly, with their error bars."""

from alight.films.film import Film
from alight.films.sample_ranges import CELL_SIZE, SampleRanges
from alight.films.tiles import FIRST_SAMPLE_LAYERS, PartialFilm

__all__ = ["CELL_SIZE", "FIRST_SAMPLE_LAYERS", "Film", "PartialFilm", "SampleRanges"]
