"""Blocks of samples as tasks of a cluster: what a worker renders, and how the client checks it.

An answer is an archive (`alight.films.archive`), which holds no code and its own checksum: the
canonical sums of each block, and the digest of the task that they answer.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from alight.compiled.scene import CompiledScene
from alight.core.errors import FilmError
from alight.films import CELL_SIZE, PartialFilm
from alight.films.archive import Archive, pack_archive, unpack_archive
from alight.films.coverage import SurfaceSums, pack_sums, unpack_sums
from alight.films.fixed_point import HIGH_SCALE, LOW_MASK, MAX_VALUE, carry
from alight.integrators.walk import Settings, sent_integrator
from alight.rendering.executors.blocks import Block
from alight.rendering.tiles.tile import Kernels, Scratch, render_tile

#: Units of limb 0 that a sample adds at most, with its carry.
LARGEST = int(MAX_VALUE * HIGH_SCALE) + 1

#: The rest is cut into so many tasks for each thread at least, so that all end together.
SHARES = 3

#: Bytes of an answer's header for each block, at most.
HEADER = 2**16


class BlockTask(NamedTuple):
    """Blocks that one thread renders.

    Attributes
    ----------
    seed : int
        Of the film.
    blocks : tuple of Block
    """

    seed: int
    blocks: tuple[Block, ...]

    @property
    def samples(self) -> float:
        """How many, about."""
        return sum(map(samples_in, self.blocks))

    @property
    def digest(self) -> str:
        """Names seed, tiles and ranges."""
        found = hashlib.sha256(str(self.seed).encode())
        for tile, ranges in self.blocks:
            found.update(repr((tuple(map(int, tile)), ranges.shape)).encode())
            found.update(np.ascontiguousarray(ranges, np.int64).tobytes())
        return found.hexdigest()


class SharedScene(NamedTuple):
    """What all tasks of a render need.

    Attributes
    ----------
    scene : CompiledScene
    settings : Settings
        Of any seed.
    kernels : Kernels
        They have run, and travel as object code.
    """

    scene: CompiledScene
    settings: Settings
    kernels: Kernels


def sent(scene: CompiledScene) -> CompiledScene:
    """A scene as it travels: tables, and nothing of what a user's script has defined.

    Kernels are object code, so the integrator's description is all that names a model's class.
    """
    if any(family == "integrators" for family, *_ in scene.program.registered):
        return replace(scene, integrator=sent_integrator(scene.integrator))
    return scene


def render_blocks(shared: SharedScene, task: BlockTask) -> bytes:
    """Render a task: a pure function of scene, settings, seed, tiles and ranges."""
    settings, scratch = shared.settings._replace(seed=task.seed), Scratch()
    arrays: dict[str, np.ndarray] = {}
    described = []
    for number, block in enumerate(task.blocks):
        partial, rays = render_tile(shared.kernels, shared.scene, settings, *block, scratch)
        tally = {"invalid": partial.invalid, "saturated": partial.saturated, "rays": rays}
        described.append(tally)
        arrays[f"{number}.counts"] = partial.counts.copy()
        for name, sums in {"": partial.sums, **(partial.aovs or {})}.items():
            arrays |= limbs_of(f"{number}.{name}", sums)
        if partial.coverage is not None:
            arrays |= pack_sums(f"{number}.coverage", partial.coverage)
    content = {"task": task.digest, "blocks": described}
    return b"".join(pack_archive(content, arrays))


def limbs_of(name: str, sums: np.ndarray) -> dict[str, np.ndarray]:
    """Arrays of an answer, of sums that are made canonical."""
    carry(sums)
    # Limbs apart: their bytes have nothing in common that could be left out.
    return {f"{name}.high": sums[..., 0].copy(), f"{name}.low": sums[..., 1].copy()}


class Layout(NamedTuple):
    """Shapes of the sums of a film's pixels.

    Attributes
    ----------
    replicates, channels : int
    aovs : mapping of str to sequence of str
        Channels of each layer that has some.
    surfaces : int or None
        How many there are to be weighed; None where none shall be.
    """

    replicates: int
    channels: int
    aovs: Mapping[str, Sequence[str]]
    surfaces: int | None = None

    def most_bytes(self, task: BlockTask) -> int:
        """How long an answer can be: all its numbers as they are, and a header."""
        pixels = sum((b.tile.x1 - b.tile.x0) * (b.tile.y1 - b.tile.y0) for b in task.blocks)
        numbers = self.replicates * (2 * self.channels + 1)
        numbers += 2 * sum(map(len, self.aovs.values()))
        rows = 0
        if self.surfaces is not None:
            of_blocks = (samples_of(block, self.replicates).sum(axis=2) for block in task.blocks)
            rows = sum(int(np.minimum(n, self.surfaces).sum()) for n in of_blocks)
        return 8 * (numbers * pixels + 4 * rows) + HEADER * len(task.blocks)


def read_blocks(layout: Layout, task: BlockTask, data: Any) -> list[tuple[PartialFilm, int]]:
    """Read the answer to a task, and refuse what cannot be one.

    Returns
    -------
    list of (PartialFilm, int)
        Sums and rays of each block.

    Raises
    ------
    FilmError
        If it is damaged, that of another task, or has arrays of another shape or type, other
        numbers of samples, or sums that so many samples cannot have.
    """
    with read_from(task, data, layout.most_bytes(task)) as (content, arrays):
        tallies = content["blocks"]
        if len(tallies) != len(task.blocks):
            raise FilmError(f"a worker answered {len(tallies)} blocks, not {len(task.blocks)}")
        return [
            _block(layout, block, tally, number, arrays)
            for number, (block, tally) in enumerate(zip(task.blocks, tallies, strict=True))
        ]


@contextmanager
def read_from(task: Any, data: Any, most_bytes: int) -> Iterator[Archive]:
    """The archive of an answer to a task; what is read of it may be missing, or of another type.

    Raises
    ------
    FilmError
    """
    if not isinstance(data, bytes):
        raise FilmError(f"a worker's answer is {type(data).__name__}, not bytes")
    if len(data) > most_bytes:
        raise FilmError(f"a worker's answer is {len(data)} bytes long: too long for its task")
    try:
        archive = unpack_archive("a worker's answer", memoryview(data))
        if archive.content["task"] != task.digest:
            raise FilmError("a worker's answer is that of another task")
        yield archive
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, FilmError):
            raise
        raise FilmError(f"a worker's answer cannot be read: {error!r}") from error


def _block(
    layout: Layout, block: Block, tally: Mapping[str, Any], number: int, arrays: Any
) -> tuple[PartialFilm, int]:
    tile, expected = block.tile, samples_of(block, layout.replicates)
    check_counts(arrays, f"{number}.counts", expected)
    most = expected.sum(axis=2)
    shape = (*expected.shape, layout.channels)
    sums = sums_of(arrays, f"{number}.", shape, LARGEST * expected[..., None])
    aovs = {
        name: sums_of(
            arrays, f"{number}.{name}", (*most.shape, len(names)), LARGEST * most[..., None]
        )
        for name, names in layout.aovs.items()
    }
    invalid, saturated, rays = tallies_of(tally)
    partial = PartialFilm(
        x0=tile.x0, y0=tile.y0, sums=sums, counts=expected, invalid=invalid, saturated=saturated,
        ranges=block.ranges, aovs=aovs,
        coverage=_coverage(layout, arrays, f"{number}.coverage", most.ravel()),
    )  # fmt: skip
    return partial, rays


def samples_in(block: Block) -> float:
    """Samples of a block, about: as if cells at its edges were whole."""
    tile = block.tile
    return float(block.ranges[..., 1].mean()) * (tile.x1 - tile.x0) * (tile.y1 - tile.y0)


def samples_of(block: Block, replicates: int) -> np.ndarray:
    """Samples of each pixel and replicate, int64, shape (height, width, replicates)."""
    tile, ranges = block
    rows = np.arange(tile.y0, tile.y1) // CELL_SIZE - tile.y0 // CELL_SIZE
    columns = np.arange(tile.x0, tile.x1) // CELL_SIZE - tile.x0 // CELL_SIZE
    of_pixel = ranges[rows[:, None], columns[None, :]]
    first, end = of_pixel[..., 0, None], of_pixel.sum(axis=-1)[..., None]
    # Indices i < n with i mod R = r are ceil((n - r) / R).
    replicate = np.arange(replicates)
    return -((replicate - end) // replicates) + (replicate - first) // replicates


def _coverage(layout: Layout, arrays: Any, name: str, samples: np.ndarray) -> SurfaceSums | None:
    """The table of a block; `samples` are those of each pixel."""
    if layout.surfaces is None:
        return None
    found = unpack_sums(name, arrays, len(samples), layout.surfaces)
    if is_beyond(found.sums[:, 0], LARGEST * samples[found.pixels]):
        raise FilmError("a worker's answer has weights that its samples cannot have")
    return found


def check_counts(arrays: Mapping[str, np.ndarray], name: str, expected: np.ndarray) -> None:
    """Refuse an answer to other samples."""
    if (_array(arrays, name, expected.shape) != expected).any():
        raise FilmError("a worker's answer has other samples than its task")


def tallies_of(content: Mapping[str, Any]) -> list[int]:
    """Invalid and saturated samples, and rays."""
    values = [content[name] for name in ("invalid", "saturated", "rays")]
    if not all(type(value) is int and value >= 0 for value in values):
        raise FilmError(f"a worker's answer has the tallies {values}")
    return values


def sums_of(
    arrays: Mapping[str, np.ndarray], name: str, shape: tuple[int, ...], most: Any
) -> np.ndarray:
    """Canonical sums, of which limb 0 is at most `most`."""
    high, low = (_array(arrays, f"{name}.{limb}", shape) for limb in ("high", "low"))
    if ((low < 0) | (low > LOW_MASK)).any() or is_beyond(high, most):
        raise FilmError("a worker's answer has sums that its samples cannot have")
    return np.stack([high, low], axis=-1)


def is_beyond(numbers: np.ndarray, most: Any) -> bool:
    """Whether a magnitude is larger than `most`; that of the least int64 is no int64."""
    return bool(((numbers > most) | (numbers < -most)).any())


def _array(arrays: Mapping[str, np.ndarray], name: str, shape: tuple[int, ...]) -> np.ndarray:
    array = arrays[name]
    if array.shape != shape or array.dtype != np.int64:
        raise FilmError(
            f"a worker's answer has {name} of shape {array.shape} and type {array.dtype}, "
            f"not {shape} and int64"
        )
    return array
