"""What `check_laws` found."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np


class BrokenLawError(AssertionError):
    """A model does not do what it must."""


def demand(truth: Any, message: str) -> None:
    """Raise `BrokenLawError` unless `truth` holds."""
    if not bool(np.all(truth)):
        raise BrokenLawError(message)


def demand_close(found: Any, wanted: Any, message: str, rtol: float = 0.0, atol: Any = 0.0):
    """Raise `BrokenLawError`, with the largest difference, unless both agree within bounds."""
    found, wanted = np.asarray(found, float), np.asarray(wanted, float)
    if found.size == 0:
        return
    difference = np.abs(found - wanted)
    excess = difference - (atol + rtol * np.abs(wanted))
    worst = np.unravel_index(np.argmax(np.where(np.isnan(excess), np.inf, excess)), excess.shape)
    if not excess[worst] <= 0.0:
        a, b = (
            np.broadcast_to(found, excess.shape)[worst],
            np.broadcast_to(wanted, excess.shape)[worst],
        )
        raise BrokenLawError(f"{message}: {a:.7g} against {b:.7g}")


@dataclass(frozen=True)
class Result:
    """One law for one example.

    Attributes
    ----------
    law : str
        In words.
    example : str
        The description and what else was given.
    problem : str
        Empty if the law holds.
    """

    law: str
    example: str
    problem: str = ""


@dataclass(frozen=True)
class Report:
    """All laws for all examples of a model.

    Attributes
    ----------
    model : str
        Family and type name.
    results : tuple of Result
    """

    model: str
    results: tuple[Result, ...]

    @property
    def failures(self) -> tuple[Result, ...]:
        """Those that do not hold."""
        return tuple(result for result in self.results if result.problem)

    @property
    def ok(self) -> bool:
        """Whether all hold."""
        return not self.failures

    def __bool__(self) -> bool:
        """As `ok`: for ``assert check_laws(...)``."""
        return self.ok

    def __str__(self) -> str:
        """A line for each law, and the failures below it."""
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        yield f"{self.model}: {len(self.results)} checks, {len(self.failures)} failures"
        for law in dict.fromkeys(result.law for result in self.results):
            mine = [result for result in self.results if result.law == law]
            failed = [result for result in mine if result.problem]
            yield f"  {'BAD' if failed else 'ok ':<4}{law} ({len(mine)})"
            for result in failed[:5]:
                yield f"        {result.example}: {result.problem}"
            if len(failed) > 5:
                yield f"        ... and {len(failed) - 5} more"


def judged(law: Callable, example: str, *arguments: Any) -> Result:
    """Try one law; its docstring is its name."""
    name = (law.__doc__ or law.__name__).strip().splitlines()[0].rstrip(".")
    try:
        law(*arguments)
    except BrokenLawError as error:
        return Result(name, example, str(error))
    except Exception as error:
        return Result(name, example, f"{type(error).__name__}: {error}")
    return Result(name, example)
