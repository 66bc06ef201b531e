"""Scenes that are well formed, with some of their numbers at the ends of float32 and of reason."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator

from alight.formats import builtin_names
from tests.formats.mutate import Mutation, mesh_file, mesh_scene, read_builtin

# fmt: off
EXTREMES = (
    "0", "-0.0", "1", "-1", "2", "0.5", "0.999999", "90", "179.99", "180", "1e-45", "1e-38",
    "1e-30", "1e-15", "1e-7", "1e6", "1e12", "1e15", "-1e15", "1e19", "1e30", "1e38", "-1e38",
)
# fmt: on

_NUMBER = re.compile(r"(?<![\w.])-?\d+(\.\d*)?(e[-+]?\d+)?(?![\w.])")


def extremes(seed: int, n: int) -> Iterator[Mutation]:
    """Yield `n` scenes in which up to six numbers are replaced.

    Random damage to the text seldom passes the checks of the format; these mostly do, and put the
    compiler and the kernels to the test.
    """
    rng = random.Random(seed)
    texts = [*map(read_builtin, builtin_names()), mesh_scene("mesh.ply")]
    for _ in range(n):
        yield Mutation(extreme_numbers(rng.choice(texts), rng), "mesh.ply", mesh_file("<"))


def extreme_numbers(text: str, rng: random.Random) -> str:
    """Replace up to six numbers of a scene."""
    # The number of the format's version stays.
    start = text.index("alight:") + len("alight: 1")
    numbers = list(_NUMBER.finditer(text, start))
    chosen = rng.sample(numbers, min(len(numbers), rng.choice((1, 1, 2, 3, 6))))
    for number in sorted(chosen, key=re.Match.start, reverse=True):
        text = text[: number.start()] + rng.choice(EXTREMES) + text[number.end() :]
    return text
