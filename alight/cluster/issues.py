"""A task that is on its way to workers, how long it is waited for, and what comes back."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from distributed import Future


@dataclass(frozen=True)
class Patience:
    """Seconds after which something is taken for lost.

    Attributes
    ----------
    task : float
        A task whose answer is missing, at least; at most `times` what tasks take.
    times : float
    fetch : float
        An answer that its worker does not deliver.
    cluster : float
        A scheduler that does not answer, or has no workers.
    """

    task: float = 15.0
    times: float = 4.0
    fetch: float = 15.0
    cluster: float = 60.0


@dataclass
class Issue:
    """A task that is on its way."""

    number: int
    task: Any
    since: float = 0.0
    failures: int = 0
    futures: list[Future] = field(default_factory=list)


class Arrived(NamedTuple):
    """What has come of one copy of a task: an answer and its checked value, or an error."""

    number: int
    future: Future
    answer: Any
    value: Any
    error: BaseException | None
