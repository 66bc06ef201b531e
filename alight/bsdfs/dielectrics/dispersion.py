r"""Dispersion: clear bodies that refract each wavelength by an index of its own.

Three ways to say it, with wavelengths in micrometres where there are coefficients:

.. math::
    n(\lambda) &= n_d + \frac{n_d - 1}{V} \,
        \frac{\lambda^{-2} - \lambda_d^{-2}}{\lambda_F^{-2} - \lambda_C^{-2}}
        && \text{Abbe's number } V = \frac{n_d - 1}{n_F - n_C}, \\
    n(\lambda) &= A + B \lambda^{-2} && \text{Cauchy}, \\
    n(\lambda)^2 &= 1 + \sum_{i=1}^{3} \frac{B_i \lambda^2}{\lambda^2 - C_i} && \text{Sellmeier},

the last also by the name of a substance. Kernels know

.. math:: n(\lambda) = n_d + a\, (\lambda^{-2} - \lambda_d^{-2})
    + b\, (\lambda^{-4} - \lambda_d^{-4}) + c\, (\lambda^{-6} - \lambda_d^{-6}),

which the first two are, and the third is to within 6e-5 for the substances below. What is outside
has the same index for all wavelengths. A path that meets such a body is followed for one wavelength
(`alight.core.wavelengths`); the layers that look through glass see the line d.

Sources: Born and Wolf, Principles of Optics, section 2.3.4; the optical glass catalogue of Schott
AG; Malitson 1965 (fused silica, doi:10.1364/JOSA.55.001205); Malitson and Dodge 1972 (sapphire, the
ordinary ray); Peter 1923 (diamond, doi:10.1007/BF01333109).
"""

from __future__ import annotations

import numbers
from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator
from pydantic_core import PydanticCustomError

from alight.bsdfs.dielectrics.interface import Interface
from alight.core.errors import show_value, unknown_name
from alight.core.fields import Interval, invalid
from alight.core.parameters import Slots
from alight.core.wavelengths import DISPERSIVE, LINE_C, LINE_D, LINE_F, LONGEST, SHORTEST
from alight.textures.fetch import scalar
from lanewise.jit import kernel, specialised
from lanewise.simd import gather_row

#: Sellmeier's B_1, B_2, B_3 and C_1, C_2, C_3 (square micrometres).
SUBSTANCES: dict[str, tuple[float, ...]] = {
    "bk7": (1.03961212, 0.231792344, 1.01046945, 0.00600069867, 0.0200179144, 103.560653),
    "baf10": (1.5851495, 0.143559385, 1.08521269, 0.00926681282, 0.0424489805, 105.613573),
    "fk51a": (0.971247817, 0.216901417, 0.904651666, 0.00472301995, 0.0153575612, 168.68133),
    "lasf9": (2.00029547, 0.298926886, 1.80691843, 0.0121426017, 0.0538736236, 156.530829),
    "sf5": (1.52481889, 0.187085527, 1.42729015, 0.011254756, 0.0588995392, 129.141675),
    "sf10": (1.62153902, 0.256287842, 1.64447552, 0.0122241457, 0.0595736775, 147.468793),
    "sf11": (1.73759695, 0.313747346, 1.89878101, 0.013188707, 0.0623068142, 155.23629),
    "fused_quartz": (
        0.6961663, 0.4079426, 0.8974794, 0.0684043**2, 0.1162414**2, 9.896161**2,
    ),
    "sapphire": (1.4313493, 0.65054713, 5.3414021, 0.0726631**2, 0.1193242**2, 18.028251**2),
    "diamond": (0.3306, 4.3356, 0.0, 0.1750**2, 0.1060**2, 0.0),
}  # fmt: skip

_COEFFICIENT = Interval(-1e3, 1e3)
#: By how much `int_ior` may differ from what coefficients say.
_SAME = 1e-3

#: Micrometres.
_D, _F, _C = 1e-3 * LINE_D, 1e-3 * LINE_F, 1e-3 * LINE_C
_SQUARED = LINE_D**2
_WAVELENGTHS = np.linspace(1e-3 * SHORTEST, 1e-3 * LONGEST, 171)


@dataclass(frozen=True)
class AbbeNumber(Interval):
    """Metadata of a field that holds Abbe's number, or 0 for no dispersion."""

    low: float = 1.0
    high: float = 1e3

    def check(self, value: object) -> Any:
        """Return `value` as a Python number, or raise an error that states the allowed range."""
        is_zero = isinstance(value, numbers.Real) and not isinstance(value, bool) and value == 0
        return 0.0 if is_zero else super().check(value)

    def describe(self) -> str:
        """Put the range in words."""
        return f"{super().describe()}, or 0"


@dataclass(frozen=True)
class _Dispersion(AbbeNumber):
    """Metadata of `Dispersive.dispersion`."""

    def check(self, value: object) -> Any:
        """Return a number, a tuple of numbers or a name, or raise an error."""
        if isinstance(value, str):
            if value not in SUBSTANCES:
                raise invalid(unknown_name("substance", value, SUBSTANCES))
            return value
        if isinstance(value, list | tuple) and len(value) in (2, 6):
            return tuple(float(_COEFFICIENT.check(number)) for number in value)
        if isinstance(value, numbers.Real):
            return super().check(value)
        raise invalid(f"must be a number {self.describe()}, got {show_value(value)}")

    def describe(self) -> str:
        """Put in words what it takes."""
        return f"{super().describe()} (Abbe), 2 (Cauchy) or 6 numbers (Sellmeier), or a name"


def indices(
    dispersion: float | tuple[float, ...] | str, at: NDArray[np.float64], n_d: float
) -> NDArray[np.float64]:
    """Indices of refraction.

    Parameters
    ----------
    dispersion : float, tuple of float or str
        As in `Dispersive`; 0: the same index everywhere.
    at : (n,) float64
        Wavelengths, micrometres.
    n_d : float
        Index at the line d, for Abbe's number.

    Returns
    -------
    (n,) float64
        NaN where the coefficients give none.
    """
    known = SUBSTANCES[dispersion] if isinstance(dispersion, str) else dispersion
    if isinstance(known, tuple) and len(known) == 2:
        return known[0] + known[1] / at**2
    if isinstance(known, tuple):
        squares = at**2
        with np.errstate(all="ignore"):
            terms = [b * squares / (squares - c) for b, c in zip(known[:3], known[3:], strict=True)]
            return np.sqrt(1.0 + sum(terms))
    if known == 0.0:
        return np.full(np.shape(at), n_d)
    return n_d + (n_d - 1.0) / known * (at**-2 - _D**-2) / (_F**-2 - _C**-2)


def spread_of(
    dispersion: float | tuple[float, ...] | str, n_d: float
) -> tuple[float, float, float]:
    """The coefficients a, b and c over their powers of the line d: the best fit.

    With x the square of the line d over the wavelength, they are factors of x - 1, x^2 - 1 and
    x^3 - 1.
    """
    wanted = indices(dispersion, _WAVELENGTHS, n_d) - n_d
    x = (_D / _WAVELENGTHS) ** 2
    columns = [x**power - 1.0 for power in (1, 2, 3)]
    found, *_ = np.linalg.lstsq(np.stack(columns, axis=1), wanted)
    a, b, c = found.tolist()
    return a, b, c


def extremes_of(dispersion: float | tuple[float, ...] | str, n_d: float) -> tuple[float, float]:
    """The least and the largest index at all wavelengths of paths."""
    found = indices(dispersion, _WAVELENGTHS, n_d)
    return float(found.min()), float(found.max())


def out_of_range(low: float, high: float, least: float = 1.0) -> PydanticCustomError:
    """The message for indices that kernels are not made for."""
    if not low <= high:
        return invalid("the coefficients of dispersion give no index at some wavelengths")
    text = f"indices must be in [{least:g}, 5] at {SHORTEST:g} to {LONGEST:g} nm"
    return invalid(f"{text}, and dispersion makes them {low:.6g} to {high:.6g}")


class Dispersive(Interface):
    """Base class of boundaries of clear bodies that may disperse light.

    Parameters
    ----------
    dispersion : float, 2 or 6 numbers, or str, default 0
        How the index inside depends on the wavelength: Abbe's number, 0 for not at all; or, in the
        place of `int_ior`, Cauchy's A and B, Sellmeier's B1, B2, B3, C1, C2 and C3, for micrometres
        both, or a name of `SUBSTANCES`.
    """

    dispersion: Annotated[float | tuple[float, ...] | str, _Dispersion()] = 0.0

    @model_validator(mode="before")
    @classmethod
    def _with_its_index(cls, data: Any) -> Any:
        """Take the index at the line d from coefficients or a name, where there is no other."""
        given = data.get("dispersion") if isinstance(data, dict) else None
        try:
            known = _Dispersion().check(given)
        except PydanticCustomError:
            return data
        if isinstance(known, float) or data.get("int_ior") is not None:
            return data
        return {**data, "int_ior": _index_at_d(known)}

    @model_validator(mode="after")
    def _has_indices(self) -> Self:
        low, high = self.extreme_indices
        if not 1.0 <= low <= high <= 5.0:
            raise out_of_range(low, high)
        if not isinstance(self.dispersion, float):
            own = _index_at_d(self.dispersion)
            if abs(own - self.int_ior) > _SAME:
                text = f"int_ior is {self.int_ior:g}, and dispersion makes it {own:.6g}"
                raise invalid(f"{text}: leave out one of them")
        return self

    @property
    def extreme_indices(self) -> tuple[float, float]:
        """The least and the largest index inside at all wavelengths of paths."""
        return extremes_of(self.dispersion, self.int_ior)


def _index_at_d(dispersion: tuple[float, ...] | str) -> float:
    return float(np.nan_to_num(indices(dispersion, np.array([_D]), 1.0)[0]))


# ---------------------------------------------------------------- tables


def pack_spread(
    packer, dispersion: float | tuple[float, ...] | str, n_d: float, outside: float = 1.0
) -> None:
    """Fill the slots of an `Index` but eta, which is that at the line d over the index outside."""
    spread = spread_of(dispersion, n_d) if dispersion != 0.0 else (0.0, 0.0, 0.0)
    packer.numbers("spread", *(number / outside for number in spread))


def dispersion_features(dispersion: float | tuple[float, ...] | str) -> tuple[str, ...]:
    """What must be compiled for it."""
    return () if dispersion == 0.0 else (DISPERSIVE,)


def disperses(program) -> bool:
    """Whether a material of the program does."""
    return DISPERSIVE in program.bsdfs


@specialised
def index_at(program):
    """``(scene, slot, surface) -> float``: the relative index at the wavelength of a surface."""
    if not disperses(program):
        return scalar

    @kernel
    def index_at_wavelength(scene, slot, surface):
        eta, a, b, c = gather_row(scene.materials.data, slot, 4)
        # 1 / lambda^2, over that of the line d.
        x = _SQUARED / (surface.wavelength * surface.wavelength)
        return eta + (x - 1.0) * (a + (x + 1.0) * b + ((x + 1.0) * x + 1.0) * c)

    return index_at_wavelength


#: Field of a record of parameters.
Index = Annotated[Any, Slots(index_at, {"eta": 1, "spread": 3})]
