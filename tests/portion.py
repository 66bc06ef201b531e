"""The portion of long proofs that a run tries.

Some proofs consist of hundreds or thousands of cases that stand for themselves: planted bugs,
mutated scenes, pictures of another renderer. ``PORTION=2/4`` tries every fourth, from the second
on; continuous integration counts commits, so that four in a row try all. Without it all are tried.
"""

import os
from collections.abc import Iterable
from itertools import islice
from typing import TypeVar

T = TypeVar("T")

FIRST, OF = (int(part) for part in os.environ.get("PORTION", "1/1").split("/"))


def portion(cases: Iterable[T]) -> list[T]:
    """Those of some cases that this run tries, in their order."""
    return list(islice(cases, FIRST - 1, None, OF))
