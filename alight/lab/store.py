"""Results of a study as they come, in one SQLite file.

A replicate is one transaction: after a crash or ``kill -9`` everything but the replicate in flight
is there, and the same command continues. Pictures are kept as running sums, so that neither memory
nor the file grows by pictures with the number of replicates.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from alight.core.errors import OutputError
from alight.lab.statistics.decomposition import Moments

_SCHEMA = """
CREATE TABLE IF NOT EXISTS facts (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS replicates (
    arm TEXT NOT NULL, number INTEGER NOT NULL, seed INTEGER NOT NULL, invalid INTEGER NOT NULL,
    rungs TEXT NOT NULL, blocks BLOB NOT NULL, PRIMARY KEY (arm, number));
CREATE TABLE IF NOT EXISTS processors (
    arm TEXT NOT NULL, number INTEGER NOT NULL, name TEXT NOT NULL, PRIMARY KEY (arm, number));
CREATE TABLE IF NOT EXISTS moments (
    arm TEXT NOT NULL, spp INTEGER NOT NULL, count INTEGER NOT NULL, shape TEXT NOT NULL,
    mean BLOB NOT NULL, squares BLOB NOT NULL, PRIMARY KEY (arm, spp));
CREATE TABLE IF NOT EXISTS examples (
    arm TEXT PRIMARY KEY, spp INTEGER NOT NULL, seconds REAL NOT NULL, shape TEXT NOT NULL,
    picture BLOB NOT NULL);
PRAGMA user_version = 1;
"""


@dataclass(frozen=True)
class Replicate:
    """The figures of one replicate.

    Attributes
    ----------
    number, seed, invalid : int
    rungs : dict of int to dict of str to float or None
        By spp: seconds, and the error by each metric.
    blocks : ndarray of float64
        `alight.lab.statistics.block_means.block_row` of the deepest picture.
    processor : str
        On which it was timed; empty where a store does not know, or is not asked.
    """

    number: int
    seed: int
    invalid: int
    rungs: dict[int, dict[str, Any]]
    blocks: np.ndarray
    processor: str = ""


@dataclass(frozen=True)
class Example:
    """One picture, to be looked at."""

    spp: int
    seconds: float
    picture: np.ndarray


class Store:
    """An open results file.

    Parameters
    ----------
    path : Path
        Made if it does not exist.

    Raises
    ------
    OutputError
        If it cannot be opened or written: no permission, no results file, full disk, in use.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with self._explained():
            self._base = sqlite3.connect(path, timeout=10.0, isolation_level=None)
            try:
                self._base.execute("PRAGMA journal_mode = WAL")
                # With WAL a crash of the program loses nothing, one of the machine the last
                # replicate.
                self._base.execute("PRAGMA synchronous = NORMAL")
                self._base.executescript(_SCHEMA)
            except sqlite3.Error:
                self._base.close()
                raise

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file."""
        self._base.close()

    @contextmanager
    def _explained(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise OutputError(f"cannot write {self.path}: {error}") from error

    # ---- facts

    def fact(self, key: str) -> Any:
        """What was kept under a key, or None."""
        with self._explained():
            row = self._base.execute("SELECT value FROM facts WHERE key = ?", (key,)).fetchone()
        return None if row is None else json.loads(row[0])

    def keep(self, key: str, value: Any) -> None:
        """Keep a small value under a key."""
        with self._explained():
            self._base.execute(
                "INSERT OR REPLACE INTO facts VALUES (?, ?)", (key, json.dumps(value))
            )

    # ---- replicates

    def add(
        self,
        arm: str,
        replicate: Replicate,
        pictures: dict[int, np.ndarray],
        example: Example | None,
    ) -> None:
        """Keep a replicate, all or nothing.

        Parameters
        ----------
        arm : str
            Key of the arm.
        replicate : Replicate
        pictures : dict of int to ndarray, shape (h, w, 3)
            By spp: pictures that go into the running sums.
        example : Example, optional
            Kept if the arm has none.
        """
        with self._explained(), self._transaction():
            self._base.execute(
                "INSERT INTO replicates VALUES (?, ?, ?, ?, ?, ?)",
                (
                    arm, replicate.number, replicate.seed, replicate.invalid,
                    json.dumps(replicate.rungs),
                    replicate.blocks.astype(np.float64).tobytes(),
                ),
            )  # fmt: skip
            if replicate.processor:
                self._base.execute(
                    "INSERT INTO processors VALUES (?, ?, ?)",
                    (arm, replicate.number, replicate.processor),
                )
            for spp, picture in pictures.items():
                moments = self.moments(arm, spp) or Moments()
                moments.add(np.asarray(picture, np.float32))
                self._base.execute(
                    "INSERT OR REPLACE INTO moments VALUES (?, ?, ?, ?, ?, ?)",
                    (
                        arm, spp, moments.count, json.dumps(picture.shape),
                        moments.mean.tobytes(), moments.squares.tobytes(),
                    ),
                )  # fmt: skip
            if example is not None:
                self._base.execute(
                    "INSERT OR IGNORE INTO examples VALUES (?, ?, ?, ?, ?)",
                    (
                        arm, example.spp, example.seconds, json.dumps(example.picture.shape),
                        example.picture.astype(np.float32).tobytes(),
                    ),
                )  # fmt: skip

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self._base.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            # A full disk has ended the transaction already.
            if self._base.in_transaction:
                self._base.execute("ROLLBACK")
            raise
        self._base.execute("COMMIT")

    def numbers(self, arm: str) -> set[int]:
        """The replicates that are done."""
        with self._explained():
            rows = self._base.execute("SELECT number FROM replicates WHERE arm = ?", (arm,))
            return {row[0] for row in rows}

    def processors(self, arm: str) -> set[str]:
        """Those that replicates were timed on, as far as it is known."""
        with self._explained():
            rows = self._base.execute("SELECT name FROM processors WHERE arm = ?", (arm,))
            return {row[0] for row in rows}

    def replicates(self, arm: str) -> Iterator[Replicate]:
        """All replicates of an arm, in their order, one at a time."""
        with self._explained():
            rows = self._base.execute(
                "SELECT number, seed, invalid, rungs, blocks FROM replicates "
                "WHERE arm = ? ORDER BY number",
                (arm,),
            )
            for number, seed, invalid, rungs, blocks in rows:
                figures = {int(spp): values for spp, values in json.loads(rungs).items()}
                yield Replicate(number, seed, invalid, figures, np.frombuffer(blocks, np.float64))

    def moments(self, arm: str, spp: int) -> Moments | None:
        """The running sums of an arm's pictures at one step of the ladder."""
        with self._explained():
            row = self._base.execute(
                "SELECT count, shape, mean, squares FROM moments WHERE arm = ? AND spp = ?",
                (arm, spp),
            ).fetchone()
        if row is None:
            return None
        count, shape, mean, squares = row
        return Moments(count, _array(mean, shape), _array(squares, shape))

    def example(self, arm: str) -> Example | None:
        """The picture kept for an arm."""
        with self._explained():
            row = self._base.execute(
                "SELECT spp, seconds, shape, picture FROM examples WHERE arm = ?", (arm,)
            ).fetchone()
        return None if row is None else Example(row[0], row[1], _array(row[3], row[2]))


def _array(data: bytes, shape: str) -> np.ndarray:
    return np.frombuffer(data, np.float32).reshape(json.loads(shape))
