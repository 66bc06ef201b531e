"""Light between a rough coat and its base, walked at random: what coated materials are held to.

Facets are GGX. At each layer a facet is drawn that is seen from where the light comes, the coat's
reflection is chosen by Fresnel's term, and of the light G / G1(wo) is kept, with the masking
G = 1 / (1 + Lambda_o + Lambda_i) of facets of correlated heights. Nothing of it is alight's.

Source: Guo, Hasan and Zhao 2018, Position-Free Monte Carlo Simulation for Arbitrary Layered BSDFs;
Heitz 2018, Sampling the GGX Distribution of Visible Normals; Heitz 2014 for the masking.
"""

from typing import NamedTuple

import numpy as np


class Metal(NamedTuple):
    """A base of metal; the index is that over the coat's."""

    alpha: float
    eta: tuple[float, ...]
    k: tuple[float, ...]


class Lambert(NamedTuple):
    """A matte base."""

    albedo: tuple[float, ...]


class Walks(NamedTuple):
    """Where light goes: directions (3, n), power (3, n), and whether the coat alone sent it."""

    wi: np.ndarray
    power: np.ndarray
    coat: np.ndarray


def walks(cosine, ior, coat, base, thickness=0.0, bounces=1000, n=40_000, seed=1):
    """Light from `cosine` outside on a coat of roughness `coat` (0: smooth) and relative index."""
    rng = np.random.default_rng(seed)
    wi, power = np.zeros((3, n)), np.zeros((3, n))
    w = np.zeros((3, n))
    w[0], w[2] = np.sqrt(1.0 - cosine * cosine), cosine
    w, kept, through = _interface(w, coat, ior, rng)
    alone, light = ~through, np.broadcast_to(kept, (3, n))
    wi[:, alone], power[:, alone] = w[:, alone], light[:, alone]
    index, w, light = np.flatnonzero(through), w[:, through], light[:, through]
    for _ in range(bounces):
        # Down to the base, and up again.
        light = light * np.exp(-thickness / _not_0(w[2]))
        w, scattered = _base(-w, base, rng)
        light = light * scattered * np.exp(-thickness / _not_0(w[2]))
        # The coat from inside, in a frame whose z axis points down.
        w, kept, through = _interface(-w * _DOWN, coat, 1.0 / ior, rng)
        w, light = w * _DOWN, light * kept
        wi[:, index[through]], power[:, index[through]] = w[:, through], light[:, through]
        goes_on = ~through & (light > 0.0).any(0)
        index, w, light = index[goes_on], w[:, goes_on], light[:, goes_on]
        if not index.size:
            break
    return Walks(wi, power, alone)


def fresnel(cosine, ior):
    """(F, refracted cosine) of a dielectric."""
    square = 1.0 - (1.0 - cosine * cosine) / ior**2
    refracted = np.sqrt(np.maximum(square, 0.0))
    s = (cosine - ior * refracted) / (cosine + ior * refracted)
    p = (ior * cosine - refracted) / (ior * cosine + refracted)
    return np.where(square > 0.0, 0.5 * (s * s + p * p), 1.0), refracted


def fresnel_of_metal(cosine, metal):
    """(3, n)."""
    index = (np.asarray(metal.eta) + 1j * np.asarray(metal.k))[:, None]
    refracted = np.sqrt(1.0 - (1.0 - cosine * cosine) / index**2)
    s = (cosine - index * refracted) / (cosine + index * refracted)
    p = (index * cosine - refracted) / (index * cosine + refracted)
    return 0.5 * (np.abs(s) ** 2 + np.abs(p) ** 2)


# ---------------------------------------------------------------- one layer; w[2] > 0

_DOWN = np.array([[1.0], [1.0], [-1.0]])


def _interface(w, alpha, ior, rng):
    """(where it goes, what is kept, whether it goes through)."""
    wm, cosine = _facet(w, alpha, rng)
    reflectance, refracted = fresnel(cosine, ior)
    through = rng.random(cosine.size) >= reflectance
    bent = (cosine / ior - refracted) * wm - w / ior
    out = np.where(through, bent, 2.0 * cosine * wm - w)
    return out, _kept(w, out, alpha) * ((out[2] < 0.0) == through), through


def _base(w, base, rng):
    """(where it goes, what is kept)."""
    if isinstance(base, Lambert):
        r, phi = np.sqrt(rng.random(w.shape[1])), 2.0 * np.pi * rng.random(w.shape[1])
        z = np.sqrt(np.maximum(1.0 - r * r, 1e-12))
        return np.array([r * np.cos(phi), r * np.sin(phi), z]), np.array(base.albedo)[:, None]
    wm, cosine = _facet(w, base.alpha, rng)
    out = 2.0 * cosine * wm - w
    kept = _kept(w, out, base.alpha) * (out[2] > 0.0)
    return np.where(out[2] > 0.0, out, w), fresnel_of_metal(cosine, base) * kept


def _facet(w, alpha, rng):
    """(normal, cosine) of a facet seen from w, by a point of the disk that facets look like."""
    if alpha == 0.0:
        return np.array([0.0 * w[2], 0.0 * w[2], 1.0 + 0.0 * w[2]]), w[2]
    h = np.array([alpha * w[0], alpha * w[1], w[2]])
    h /= np.linalg.norm(h, axis=0)
    # Any direction across h will do where h is the z axis.
    across = np.array([-h[1], h[0], np.where(np.hypot(h[0], h[1]) > 1e-9, 0.0, 1.0)])
    across[1] += across[2]
    across[2] = 0.0
    across /= np.linalg.norm(across, axis=0)
    r, phi = np.sqrt(rng.random(w.shape[1])), 2.0 * np.pi * rng.random(w.shape[1])
    x, y, half = r * np.cos(phi), r * np.sin(phi), 0.5 * (1.0 + h[2])
    y = (1.0 - half) * np.sqrt(np.maximum(1.0 - x * x, 0.0)) + half * y
    z = np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))
    m = x * across + y * np.cross(h, across, axis=0) + z * h
    m = np.array([alpha * m[0], alpha * m[1], np.maximum(m[2], 1e-9)])
    m /= np.linalg.norm(m, axis=0)
    return m, np.clip((w * m).sum(0), 0.0, 1.0)


def _kept(wo, wi, alpha):
    """G / G1(wo)."""
    before, after = (0.5 * (1.0 + np.sqrt(1.0 + alpha**2 * _tan2(w))) for w in (wo, wi))
    return before / (before + after - 1.0)


def _tan2(w):
    return (w[0] ** 2 + w[1] ** 2) / _not_0(w[2]) ** 2


def _not_0(z):
    return np.maximum(np.abs(z), 1e-9)
