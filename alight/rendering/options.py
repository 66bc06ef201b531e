"""The options of a render, checked before any time is spent."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from alight.core.errors import OptionError, unknown_name
from alight.integrators.aov import LAYERS

#: Further layers and their channels.
AOVS = {"direct": ("R", "G", "B"), "indirect": ("R", "G", "B"), **LAYERS}


def check_options(
    *,
    spp: Any = None,
    time_limit: Any = None,
    seed: Any = None,
    threads: Any = None,
    replicates: Any = None,
    spp_per_pass: Any = None,
    first_sample: Any = None,
    aovs: Sequence[str] = (),
    every: Any = None,
) -> None:
    """Refuse options of `alight.render` that are out of range.

    Raises
    ------
    OptionError
        Naming the option, its value and what is allowed.
    """
    _whole("spp", spp, 1, 2**31 - 1)
    _whole("seed", seed, 0, 2**32 - 1)
    _whole("threads", threads, 1, 1024)
    _whole("replicates", replicates, 1, 1024)
    _whole("spp_per_pass", spp_per_pass, 1, 2**31 - 1)
    _whole("first_sample", first_sample, 0, 2**31 - 1)
    if time_limit is not None and not time_limit > 0:
        raise OptionError(f"time_limit: must be > 0 seconds, got {time_limit}")
    if every is not None and not every >= 0:
        raise OptionError(f"every: must be >= 0 seconds, got {every}")
    for name in aovs:
        if name not in AOVS:
            raise OptionError("aovs: " + unknown_name("layer", name, list(AOVS)))


def layers_of(names: Sequence[str]) -> tuple[str, ...]:
    """Layers in our order, each once; direct and indirect light come together."""
    wanted = set(names)
    if wanted & {"direct", "indirect"}:
        wanted |= {"direct", "indirect"}
    return tuple(name for name in AOVS if name in wanted)


def _whole(name: str, value: Any, least: int, most: int) -> None:
    if value is None:
        return
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
        raise OptionError(f"{name}: must be a whole number in [{least}, {most}], got {value!r}")
