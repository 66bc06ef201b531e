"""What the renderer takes from the file of a sampler."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from alight.core.registry import Kernel, Record, Records


@dataclass(frozen=True, eq=False, kw_only=True)
class SamplerModel(Record):
    """A sampler: two pure functions of a sample and a dimension.

    Attributes
    ----------
    make_kernels : (fields of the description) -> (kernel, kernel)
        ``get_1d(state, dimension)`` and ``get_2d(state, dimension)``, values in [0, 1).
    EXPECTED_RATE : (float, float)
        Slope of log(mean squared error) over log(samples) for a smooth integrand, in 1-D and 2-D.
    WORST_GAIN : float
        Largest variance of a product of functions of two dimensions, times plain Monte Carlo's.
    """

    make_kernels: Callable[..., tuple[Kernel, Kernel]]
    EXPECTED_RATE: tuple[float, float]
    WORST_GAIN: float = 1.0


#: All samplers, by name.
SAMPLERS = Records("samplers", SamplerModel)
