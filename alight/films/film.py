"""The film: exact sums of samples by replicate, their counts, and the request.

Sample i belongs to replicate i mod R. ``sums[y, x, replicate, channel]`` are whole numbers
(`fixed_point`), so tiles, passes, resumed parts and films of other machines are added in any order
with the same bits. What follows from them is worked out elsewhere: `readout` (means), `statistics`
(standard errors), `metrics.own_error` and `metrics.pixel_bars` (error bars), `merging`, `storage`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from alight.core.arguments import expect
from alight.core.errors import FilmError
from alight.films import (
    contents,
    fixed_point,
    judgement,
    ledger,
    mattes,
    merging,
    notebook,
    readout,
    storage,
    tiles,
)  # fmt: skip
from alight.films.coverage import Coverage
from alight.films.ledger import Bias
from alight.films.lock import FilmLock
from alight.films.sample_ranges import SampleRanges, cells_of, empty_cells, union_of_cells
from alight.films.tiles import PartialFilm, names_of
from alight.metrics.error_estimate import ErrorEstimate
from alight.metrics.own_error import relmse_of
from alight.metrics.pixel_bars import PixelBars, pixel_bars
from alight.metrics.survey import survey
from alight.outputs.image import write_image
from alight.outputs.picture import Picture

if TYPE_CHECKING:
    import os


class Film:
    """Sums of samples of one picture. Adding and reading are safe from any thread.

    Parameters
    ----------
    width, height : int
        Size of the full film in pixels.
    crop : (int, int, int, int), optional
        x, y, width and height of the window that is kept; the full film by default.
    replicates : int, default 4
        R: sample i belongs to replicate i mod R. Part of the film's identity.
    channels : sequence of str, default ("R", "G", "B")
        The first three are the picture.
    aovs : mapping of str to sequence of str, optional
        Further planes and their channels, for instance ``{"depth": ("Z",)}``: no replicates.
    surfaces : sequence of (str, str), optional
        Names of every object and of its material, for films that know what covers a pixel.
    scene_hash, seed, options, fingerprint, version
        Of the samples. Films merge where all but `version`, which the fingerprint covers, agree.

    Attributes
    ----------
    sums : ndarray of int64, shape (h, w, R, C, 2)
        Canonical two-limb fixed point: units of 2^-8 and 2^-48 (see `fixed_point`).
    counts : ndarray of int64, shape (h, w, R)
        Samples, those that were NaN too.
    cells : ndarray of object, shape (cells_y, cells_x)
        `SampleRanges` of each 8x8 cell of the full film.
    invalid, saturated : int
        Samples that were NaN or infinite (they add 0 and count 1); values cut to 2^36.
    recorded : tuple of Bias
        What the renderer knows to be biased, effects as radiance; see `biases`.
    largest_sample : float or None
        No channel of a sample can be larger, where that is known.
    by_chance : bool
        Whether no path was led to a light: what no sample has met says nothing of itself then.
    rare_light : ndarray, shape (n, 7), or None
        Light that only chance finds: of `light_behind_glass` and `light_off_surfaces`.
    scene_warnings : tuple of str
        What is suspicious of the scene: `warnings` says it, files and merged films keep it.
    shares_paths : bool
        Whether one path adds to several pixels: promises about the whole picture do not hold then.
    stats : dict
        Times and rates, filled in by the renderer.
    lock : FilmLock
        Held while tiles are added, and while planes are read that belong together.

    Raises
    ------
    FilmError
        For an impossible size or crop, or more than 2^19 - 1 samples per pixel and replicate
        (with AOVs: per pixel), beyond which sums could overflow.
    """

    def __init__(
        self,
        width: int,
        height: int,
        *,
        crop: tuple[int, int, int, int] | None = None,
        replicates: int = 4,
        channels: Sequence[str] = ("R", "G", "B"),
        aovs: Mapping[str, Sequence[str]] | None = None,
        surfaces: Sequence[tuple[str, str]] | None = None,
        scene_hash: str = "",
        seed: int = 0,
        options: Mapping[str, Any] | None = None,
        fingerprint: str = "",
        version: str = "",
    ) -> None:
        tiles.check_shape(width, height, crop, replicates)
        tiles.check_channels(channels, aovs)
        expect(surfaces, (Sequence, type(None)), "surfaces", "pairs of names")
        self.width, self.height = width, height
        self.crop = (0, 0, width, height) if crop is None else tuple(crop)
        self.replicates = replicates
        self.channels = tuple(channels)
        self.aov_channels = {name: tuple(names) for name, names in (aovs or {}).items()}
        self.scene_hash, self.seed, self.options = scene_hash, seed, dict(options or {})
        self.fingerprint, self.version = fingerprint, version
        h, w = self.crop[3], self.crop[2]
        self.sums = np.zeros((h, w, replicates, len(self.channels), 2), np.int64)
        self.counts = np.zeros((h, w, replicates), np.int64)
        self.aov_sums = {
            name: np.zeros((h, w, len(names), 2), np.int64)
            for name, names in self.aov_channels.items() if names
        }  # fmt: skip
        self.coverage = None if surfaces is None else Coverage(surfaces)
        self.cells = empty_cells(width, height)
        self.invalid = self.saturated = 0
        self.recorded: tuple[Bias, ...] = ()
        self.scene_warnings: tuple[str, ...] = ()
        self.largest_sample: float | None = None
        self.shares_paths = self.by_chance = False
        self.rare_light: np.ndarray | None = None
        self._mean_of, self._judged = (-1, 0.0), judgement.Judged()
        self.stats: dict[str, Any] = {}
        self.lock = FilmLock()

    # ------------------------------------------------------------------------------ adding

    def add_tile(self, partial: PartialFilm, add_rows: Callable | None = None) -> None:
        """Add the sums of a tile; nothing is changed if it is refused.

        Parameters
        ----------
        partial : PartialFilm
        add_rows : callable, optional
            `fixed_point.add_rows` as machine code, which takes less than half of NumPy's time.

        Raises
        ------
        FilmError
            If the tile does not fit, holds samples that the film has, or there is no room.
        """
        window = tiles.window_of(self, partial)
        cells = tiles.ranges_of(self, partial)
        with self.lock:
            counts = self.counts[window] + partial.counts
            tiles.check_room(self, counts)
            if cells is not None:
                index, added = cells
                self.cells[index] = union_of_cells(self.cells[index], added)
            self.counts[window] = counts
            if add_rows is None:
                tiles.add_sums(self.sums[window], partial.sums)
            else:
                tiles.add_sums_compiled(add_rows, self.sums, window, partial.sums)
            for name, plane in self.aov_sums.items():
                tiles.add_sums(plane[window[:2]], (partial.aovs or {})[name])
            if self.coverage is not None:
                self.coverage.add(tiles.coverage_of(self, partial))
            self.invalid += int(partial.invalid)
            self.saturated += int(partial.saturated)

    def mark_samples(self, first: int, count: int) -> None:
        """Record that every cell of the window holds samples first to first + count - 1.

        For renderers that add tiles without `ranges`.
        """
        added = SampleRanges([(first, first + count)])
        index = cells_of(*self.crop)
        with self.lock:
            self.cells[index] = union_of_cells(
                self.cells[index], np.full(self.cells[index].shape, added, dtype=object)
            )

    @classmethod
    def merge(cls, *films: Film) -> Film:
        """One film with the samples of all, exactly: the order does not matter.

        Raises
        ------
        FilmError
            If two films hold the same samples, or differ in scene, options, seed, replicates,
            size, crop, channels or kernel fingerprint: the message names what differs.
        """
        return merging.merge([expect(film, Film, "films", "films") for film in films])

    def empty_like(self) -> Film:
        """Make a film without samples and with the same identity."""
        film = Film(
            self.width, self.height, crop=self.crop, replicates=self.replicates,
            channels=self.channels, aovs=self.aov_channels, scene_hash=self.scene_hash,
            seed=self.seed, options=self.options, fingerprint=self.fingerprint,
            version=self.version, surfaces=self.coverage.names if self.coverage else None,
        )  # fmt: skip
        film.recorded, film.scene_warnings = self.recorded, self.scene_warnings
        film.largest_sample = self.largest_sample
        film.shares_paths, film.by_chance = self.shares_paths, self.by_chance
        film.rare_light = self.rare_light
        return film

    def snapshot(self) -> Film:
        """Copy this moment, for readers that need several planes of one state."""
        copy = self.empty_like()
        with self.lock:
            copy.sums, copy.counts = self.sums.copy(), self.counts.copy()
            copy.aov_sums = {name: plane.copy() for name, plane in self.aov_sums.items()}
            copy.cells = self.cells.copy()
            copy.invalid, copy.saturated = self.invalid, self.saturated
            copy.stats = dict(self.stats)
            copy.coverage = self.coverage.copy() if self.coverage else None
        return copy

    # ------------------------------------------------------------------------------ reading

    @property
    def mean(self) -> np.ndarray:
        """Mean of every channel, float64, shape (h, w, C); 0 where there is no sample yet."""
        return readout.mean_of(self)

    @property
    def image(self) -> np.ndarray:
        """The picture: linear sRGB, float32, shape (h, w, 3)."""
        return readout.image_of(self)

    @property
    def standard_error(self) -> np.ndarray:
        """Standard error of `image`, float32, shape (h, w, 3); NaN means unknown."""
        return readout.error_of(self)

    def interval(self, confidence: float = 0.95) -> PixelBars:
        """Give every pixel an interval that holds the true one with this probability.

        Wider than `standard_error` alone would have it, where the pixels around show that bright
        samples are rare; `unsure` marks those of whose noise too little is known.

        Parameters
        ----------
        confidence : float, default 0.95

        Returns
        -------
        PixelBars
            ``low`` and ``high``, float32, shape (h, w, 3), and ``unsure``, bool, shape (h, w).

        Raises
        ------
        OptionError
            If `confidence` does not lie in (0, 1).
        """
        return pixel_bars(*self.replicate_means(), confidence)

    @property
    def unsure(self) -> np.ndarray:
        """Pixels whose 95 % interval is unsure, bool, shape (h, w); found once for all samples."""
        self._judged = known = judgement.unsure_of(self, self._judged)
        return known.unsure

    @property
    def sample_count(self) -> np.ndarray:
        """Samples per pixel, int64, shape (h, w)."""
        with self.lock:
            return self.counts.sum(axis=2)

    @property
    def spp(self) -> float:
        """Samples per pixel, averaged over the window."""
        return float(self.sample_count.mean())

    def aov(self, name: str) -> np.ndarray:
        """Mean of an AOV, float32, shape (h, w, c); of mattes, a picture in their colours."""
        if expect(name, str, "name", "the name of a layer") in mattes.MATTES and self.coverage:
            return mattes.colors_of(self, name)
        if name not in self.aov_sums:
            raise FilmError(f'the film has no AOV "{name}"; it has {names_of(self.aov_sums)}')
        with self.lock:
            sums, n = self.aov_sums[name].copy(), self.counts.sum(axis=2)
        n = np.minimum(n, 1) if name in tiles.FIRST_SAMPLE_LAYERS else n
        return (fixed_point.to_float(sums) / np.maximum(n, 1)[..., None]).astype(np.float32)

    def mask(self, name: str, layer: str = "cryptomatte_object") -> np.ndarray:
        """Coverage of an object and all below it, or of a material, float32, shape (h, w).

        Parameters
        ----------
        name : str
            Path of a node, for instance ``table`` or ``table/leg``, or name of a material.
        layer : {"cryptomatte_object", "cryptomatte_material"}

        Raises
        ------
        FilmError
            For an unknown name, with the nearest one; if no mattes were rendered.
        """
        return mattes.mask_of(self, name, layer)

    alpha = property(readout.alpha_of)
    alpha_error = property(readout.alpha_error_of)

    @property
    def error(self) -> ErrorEstimate:
        """The picture's own error with its interval: `relmse_estimate` by a short name."""
        return self.relmse_estimate()

    @property
    def biases(self) -> tuple[Bias, ...]:
        """The ledger: everything in the picture that is biased, with its effect if measured."""
        with self.lock:
            samples, recorded = int(self.counts.sum()), self.recorded
            invalid, saturated = self.invalid, self.saturated
        # Worked out once for the same samples, and without the lock: tiles do not wait for it.
        known = self._mean_of
        if recorded and known[0] != samples:
            known = self._mean_of = samples, float(self.image.mean(dtype=np.float64))
        relative = [bias.relative(known[1]) for bias in recorded]
        return (*relative, *ledger.counted(invalid, saturated, samples))

    def replicate_means(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean of each replicate, float32, shape (h, w, R, 3), and the counts (h, w, R)."""
        return readout.replicates_of(self)

    def relmse_estimate(self, literature: bool = True) -> ErrorEstimate:
        """Estimate the picture's own relMSE, with a 95 % interval; NaN if a replicate is empty.

        Without `literature` the figure for epsilon = 0.01 is left out: a third of the time.
        """
        seen = survey(*self.replicate_means(), self.shares_paths)
        return relmse_of(seen, literature)

    def judged(self, literature: bool = True) -> tuple[ErrorEstimate, np.ndarray]:
        """Give `relmse_estimate` and `unsure`, cheaper together, and once for all samples."""
        self._judged = known = judgement.judge(self, self._judged, literature)
        assert known.error is not None
        return known.error, known.unsure

    provenance = property(contents.provenance_of)
    warnings = property(contents.warnings_of)

    # ------------------------------------------------------------------------------ output

    def picture(self, layers: bool = True) -> Picture:
        """Image, layers (unless they are not wanted) and provenance, ready to be written."""
        return contents.picture_of(self, layers)

    def save(self, path: str | os.PathLike[str], **display: Any) -> Path:
        """Write the picture, or the film itself; the suffix chooses the format.

        Parameters
        ----------
        path : path
            ``.exr .png .jpg .npy .hdr .pfm``; EXR also keeps the error, the AOVs and provenance.
            ``.alight`` keeps all sums, exactly: see `load`. It is no checkpoint to resume from.
        **display
            `exposure`, `white_balance`, `tone_map`, `bits`: see `alight.outputs.write_image`.

        Raises
        ------
        OutputError
            If it cannot be written; a file that was there before is then untouched.
        """
        if storage.is_film_file(path):
            return storage.save_film(path, self)
        return write_image(path, self, **display)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Film:
        """Read a film that `save` wrote as ``.alight``, or that of a checkpoint.

        Raises
        ------
        OutputError, FilmError
            If it cannot be read, is damaged, or is no film.
        """
        return storage.load_film(cls, path)

    _repr_png_ = notebook.png_of
    _repr_html_ = notebook.html_of

    def __repr__(self) -> str:
        """Say size, samples and replicates, and that there are warnings."""
        return contents.line_of(self)
