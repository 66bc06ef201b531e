r"""How much light a clear coat and its base reflect, with all bounces between them summed up.

Both layers are rough alike in all directions, so what they do to power depends on cosines alone.
With a direction for each point of a grid of cosines, R and T the matrices of what the coat reflects
and lets through from outside, r and t those from inside, and M that of the metal, the albedo of all
light that has met the metal is

.. math:: E = T\,(1 + X r + X r X r + \dots)\, X\, t\, 1, \qquad X = A M A,

with A what a grey coat lets through from layer to layer. The sum ends with the number of times that
light may meet the metal.

Rows of the matrices are sums over a lattice of visible facets
(`alight.bsdfs.microfacets.visible_facets`); what leaves between two points of the grid is shared by
both. The part of the light that one bounce leaves is G(wo, wi) / G1(wo) with the masking G = 1 / (1
+ Lambda_o + Lambda_i) of facets whose heights are correlated; the rest is lost.

`alight.bsdfs.conductors.coated_conductor` gives this light a lobe of its own with the matrix K, and
scales it on both ways: s(mu_o) s(mu_i) with

.. math:: s(\mu_o) \sum_i K_{oi}\, s(\mu_i) = E(\mu_o),

which has one solution, found by repeating s ← (s E / K s)^(1/2).

Source: van de Hulst 1980, Multiple Light Scattering, chapter 4, for the matrices; Jakob et al.
2014, A Comprehensive Framework for Rendering Layered Materials; Heitz 2014, Understanding the
Masking-Shadowing Function, equation 99; Sinkhorn 1964 for s.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.bsdfs.microfacets.albedo_rows import FEWER, LEAST_ALPHA, STEPS
from alight.bsdfs.microfacets.visible_facets import LATTICE, Seen, see_facets
from alight.core.field_types import Triple
from alight.core.fresnel import fresnel_conductor, fresnel_dielectric
from alight.core.microfacet import Facets
from lanewise.vec3 import Vec3

Array = NDArray[np.float64]

#: Curves of a row: three of s, and the probability of the coat's own lobe.
SCALE, CHANCE, CURVES = 0, 3, 4
#: Cosines inside at which light is trapped by total internal reflection; denser near the critical
#: one.
TRAPPED = 40
_ROUNDS = 100


class Layers(NamedTuple):
    """A metal and its coat.

    Attributes
    ----------
    coat_eta : float > 1
        Index of the coat over that outside.
    coat_alpha, alpha : float
        Roughness of the coat and of the metal; those of at most `LEAST_ALPHA` are smooth.
    eta, k : (float, float, float)
        The metal's index of refraction over that of the coat.
    thickness : float, default 0
        Optical thickness of the coat at right angles.
    bounces : int, default 100
        How many times light may meet the metal.
    """

    coat_eta: float
    coat_alpha: float
    alpha: float
    eta: Triple
    k: Triple
    thickness: float = 0.0
    bounces: int = 100


class Rounds(NamedTuple):
    """What `alight.bsdfs.conductors.coated_conductor` needs of `Layers`.

    Attributes
    ----------
    row : (CURVES * STEPS,) float32
        Curves over the fourth root of the cosine outside.
    trapped : float
        Part of the light in the metal's lobe that total internal reflection keeps in at first.
    albedo : (float, float, float)
        Reflected part of light that arrives at right angles.
    """

    row: NDArray[np.float32]
    trapped: float
    albedo: Triple


# ---------------------------------------------------------------- grids of cosines


def _outside() -> Array:
    """Cosines of the grid outside, those of `alight.bsdfs.microfacets.albedo_rows`."""
    return np.maximum(np.linspace(0.0, 1.0, STEPS) ** 4, 1e-7)


def _inside(eta: float) -> Array:
    """Cosines of the grid inside: those of trapped light, then those of `_outside`, refracted."""
    critical = np.sqrt(1.0 - 1.0 / eta**2)
    part = np.linspace(0.0, 1.0, TRAPPED, endpoint=False)
    trapped = np.maximum(critical * (1.0 - (1.0 - part) ** 2), 1e-7)
    return np.append(trapped, np.sqrt(1.0 - (1.0 - _outside() ** 2) / eta**2))


def _leaving(cosine: Array, eta: float) -> Array:
    """Cosine outside of light with a cosine inside; 0 at total internal reflection."""
    return np.sqrt(np.maximum(1.0 - eta**2 * (1.0 - cosine**2), 0.0))


def _place_outside(cosine: Array) -> Array:
    return (STEPS - 1.0) * np.clip(cosine, 0.0, 1.0) ** 0.25


def _place_inside(cosine: Array, eta: float) -> Array:
    critical = np.sqrt(1.0 - 1.0 / eta**2)
    trapped = TRAPPED * (1.0 - np.sqrt(np.clip(1.0 - cosine / critical, 0.0, 1.0)))
    return trapped + _place_outside(_leaving(cosine, eta))


def _shared(place: Array, light: Array, points: int) -> Array:
    """Light (n, k) with places in a grid, shared by the points next to them: (n, points)."""
    i = np.minimum(place.astype(np.int64), points - 2)
    part, start = place - i, np.arange(len(place))[:, None] * points + i
    size = len(place) * points
    before = np.bincount(start.ravel(), (light * (1.0 - part)).ravel(), size)
    after = np.bincount(start.ravel() + 1, (light * part).ravel(), size)
    return np.asarray(before + after, np.float64).reshape(len(place), points)


# ---------------------------------------------------------------- one bounce


def _lambda(alpha: float, cosine: Array) -> Array:
    """Smith's Lambda of GGX."""
    tan2 = (1.0 - cosine * cosine) / np.maximum(cosine * cosine, 1e-14)
    return 0.5 * (np.sqrt(1.0 + alpha**2 * tan2) - 1.0)


def _kept(seen: Seen, leaving: Array) -> Array:
    """Part of the light that each facet keeps which sends it on to a cosine."""
    alpha = float(seen.facets.alpha_x)
    before = 1.0 + _lambda(alpha, seen.wo.z)
    above = leaving > 0.0
    after = _lambda(alpha, np.where(above, leaving, 1.0))
    return np.where(above, seen.weight * before / (before + after), 0.0)


def _mirrored(seen: Seen) -> Array:
    """Cosines to which the facets mirror the light."""
    return seen.wm.z * (2.0 * seen.cosine) - seen.wo.z


def _interface(seen: Seen, eta: float) -> tuple[Array, Array, Array, Array]:
    """Cosines of reflected and refracted light, and how much it is."""
    fresnel, cos_t = fresnel_dielectric(seen.cosine, eta)
    back = _mirrored(seen)
    # The refracted direction, turned over to the side of wo.
    through = seen.wo.z / eta - seen.wm.z * (seen.cosine / eta - cos_t)
    passed = (1.0 - fresnel) * (cos_t > 0.0) * _kept(seen, through)
    return back, fresnel * _kept(seen, back), through, passed


def crossing(cosine: Array, thickness: float) -> Array:
    """Part of the light that gets from layer to layer."""
    return np.exp(-thickness / cosine)


def _seen(alpha: float, cosines: Array, lattice: tuple[int, int] = FEWER) -> Seen:
    # The long tail of GGX is felt near the critical angle even of facets that mirror to float32.
    alpha = alpha if alpha > LEAST_ALPHA else 0.0
    return see_facets(Facets(alpha, alpha, 0.0), cosines, lattice=lattice)


# ---------------------------------------------------------------- all bounces


class Albedos(NamedTuple):
    """Of a coated metal at the cosines of `_outside`.

    Attributes
    ----------
    coat : (STEPS,) float64
        What the coat reflects at once.
    metal : (3, STEPS) float64
        What has met the metal.
    """

    coat: Array
    metal: Array


def albedos(layers: Layers) -> Albedos:
    """How much light is sent back."""
    coat_eta, inner = layers.coat_eta, _inside(layers.coat_eta)
    points = inner.size
    back, reflected, through, passed = _interface(_seen(layers.coat_alpha, _outside()), coat_eta)
    entering = _shared(_place_inside(through, coat_eta), passed, points)
    coat = reflected.sum(1)
    back, reflected, through, passed = _interface(_seen(layers.coat_alpha, inner), 1.0 / coat_eta)
    again = _shared(_place_inside(back, coat_eta), reflected, points)
    leaving = passed.sum(1)
    seen = _seen(layers.alpha, inner)
    cosine = _mirrored(seen)
    place = _place_inside(np.maximum(cosine, 0.0), coat_eta)
    kept = _kept(seen, cosine) * crossing(inner, layers.thickness)[:, None]
    kept = kept * crossing(np.maximum(cosine, 1e-7), layers.thickness)
    metal = []
    fresnel = fresnel_conductor(seen.cosine, Vec3(*layers.eta), Vec3(*layers.k))
    for channel in (fresnel.x, fresnel.y, fresnel.z):
        bounce = _shared(place, kept * channel, points)
        out = np.zeros(points)
        for _ in range(layers.bounces):
            out = bounce @ (leaving + again @ out)
        metal.append(np.maximum(entering @ out, 0.0))
    return Albedos(coat, np.array(metal))


class Matte(NamedTuple):
    """What a coat does to a matte base.

    Attributes
    ----------
    passed : float
        Part of light from all sides (a white sky) that gets to the base.
    internal : float
        Part of the diffuse light of the base that gets back to it.
    """

    passed: float
    internal: float


def matte_rounds(coat_eta: float, coat_alpha: float, thickness: float) -> Matte:
    """The coat of `Layers` over a base that scatters to all sides alike."""
    inner = _inside(coat_eta)
    _, _, through, passed = _interface(_seen(coat_alpha, _outside()), coat_eta)
    down = (passed * crossing(np.maximum(through, 1e-7), thickness)).sum(1)
    back, reflected, _, _ = _interface(_seen(coat_alpha, inner), 1.0 / coat_eta)
    again = (reflected * crossing(np.maximum(back, 1e-7), thickness)).sum(1)
    again = again * crossing(inner, thickness)
    mu = _outside()
    return Matte(
        float(np.trapezoid(2.0 * mu * down, mu)), float(np.trapezoid(2.0 * inner * again, inner))
    )


def lobe_alpha(layers: Layers) -> float:
    """Roughness that the metal seems to have from within the coat.

    A facet of the coat that is tilted by d turns light inside by (1 - 1 / coat_eta) d, one of the
    metal by 2 d; light meets the coat twice.
    """
    bends = 1.0 - 1.0 / layers.coat_eta
    return min(1.0, float(np.sqrt(layers.alpha**2 + 0.5 * (bends * layers.coat_alpha) ** 2)))


def _lobe(layers: Layers) -> Array:
    """The matrix K: mirrored inside by facets of `lobe_alpha`, and refracted by a smooth coat."""
    seen = _seen(lobe_alpha(layers), _inside(layers.coat_eta)[TRAPPED:], LATTICE)
    cosine = _mirrored(seen)
    out = _leaving(cosine, layers.coat_eta)
    kept = np.where(out > 0.0, _kept(seen, cosine), 0.0)
    return _shared(_place_outside(out), kept, STEPS)


@lru_cache(maxsize=64)
def rounds(layers: Layers) -> Rounds:
    """All that is tabulated of a coated metal.

    Returns
    -------
    Rounds
        Good to 0.002 of the light.
    """
    coat, metal = albedos(layers)
    lobe = _lobe(layers)
    scales = []
    for albedo in metal:
        s = np.sqrt(albedo)
        for _ in range(_ROUNDS):
            # A metal that reflects nothing, or that no light gets to, has s = 0.
            s = np.sqrt(s * albedo / np.maximum(lobe @ s, 1e-300))
        scales.append(s)
    chance = coat / (coat + metal.mean(0))
    # Over all cosines, as they are seen from a white sky.
    mu = _outside()
    trapped = 1.0 - np.trapezoid(2.0 * mu * lobe.sum(1), mu)
    r, g, b = (float(coat[-1] + channel[-1]) for channel in metal)
    return Rounds(np.array([*scales, chance]).astype(np.float32).ravel(), float(trapped), (r, g, b))
