r"""What share of a picture's variance comes from which light, found how, by paths of which length.

A pixel X is the sum of parts X_k: the contributions of one depth, way of finding light, light and
first material. By the linearity of the covariance

.. math:: s_k = \frac{\operatorname{Cov}(X_k, X)}{\operatorname{Var} X}, \qquad \sum_k s_k = 1,

and a share is negative where a part is small whenever the others are large. Over the picture both
are summed with the weights of relMSE, 1 / (ref^2 + eps), so that the shares are those of the error
that alight reports (docs/conventions.md); a pilot, whose samples play no other part, stands for the
reference.

Covariances are those of a few replicates of the independent sampler, each with its mean of a few
samples. Several such batches are independent of each other: from their spread come the standard
errors, as those of ratios of means.

Source: the covariance decomposition is that of global sensitivity analysis with dependent inputs
(Li, Rabitz et al., J. Phys. Chem. A 114 (2010), 6022).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from alight.compiled.scene import CompiledScene, compile_scene
from alight.compiled.shapes import compile_shapes
from alight.core.errors import OptionError
from alight.integrators.contributions import BY_BSDF, BY_DELTA, BY_LIGHT, SEEN, can_record
from alight.laws.scene.check import material_names
from alight.laws.scene.pictures import small
from alight.options.laboratory import WhyOptions
from alight.rendering.resources import usable_processors
from alight.rendering.tracing.contribution_recorder import Contributions, Recorder
from alight.scene import Scene, flatten
from alight.scene.flatten import FlatScene
from alight.shapes.hit import INFO as SHAPE_INFO

#: Independent batches, and replicates in each: the samples of a pixel are divided among them.
BATCHES, REPLICATES = 8, 4
#: Samples a pixel of the pilot.
PILOT = 16
#: relMSE's epsilon is the square of this part of the mean.
EPSILON = 0.1

TECHNIQUES = {
    SEEN: "seen by the camera itself",
    BY_BSDF: "found by BSDF sampling",
    BY_DELTA: "found through a mirror or glass",
    BY_LIGHT: "found by light sampling",
}


class Part(NamedTuple):
    """Contributions of one kind; None means all.

    Attributes
    ----------
    depth : int or None
        Edges of the path; 1 is light that is seen directly.
    technique : str or None
        One of `TECHNIQUES`.
    light, material : str or None
        Names; the material is the first one that the camera's ray met, "" if it met none.
    """

    depth: int | None = None
    technique: str | None = None
    light: str | None = None
    material: str | None = None

    def __str__(self) -> str:
        """In words."""
        words = f"light `{self.light}`" if self.light is not None else "light"
        if self.technique is not None:
            words += f" {self.technique}"
        if self.depth is not None and self.technique != TECHNIQUES[SEEN]:
            words += f" at depth {self.depth}"
        if self.material:
            words += f", first met: `{self.material}`"
        return words


class Share(NamedTuple):
    """Share of the variance: estimate and standard error."""

    value: float
    error: float


@dataclass(frozen=True)
class Shares:
    """The variance of a picture, divided up.

    Attributes
    ----------
    parts : tuple of Part
        Every combination that occurs.
    numerators : ndarray, shape (BATCHES, parts)
        Weighted covariance of each part with the picture, summed over pixels and channels.
    relative_variance : float
        Of one sample: the sum of all numerators of a batch, on average; relMSE times samples.
    spp : int
        Samples a pixel that went in, those of the pilot not counted.
    picture : ndarray, shape (h, w, 3)
        Mean of all samples.
    variance : ndarray, shape (h, w)
        Weighted variance of one sample of each pixel; the sum over the pixels is
        `relative_variance`.
    maps : ndarray, shape (parts, h, w)
        `variance` divided among the parts.
    """

    parts: tuple[Part, ...]
    numerators: np.ndarray
    relative_variance: float
    spp: int
    picture: np.ndarray = field(repr=False)
    variance: np.ndarray = field(repr=False)
    maps: np.ndarray = field(repr=False)

    def by(self, *fields: str) -> dict[Part, Share]:
        """Shares of all parts that differ in these fields of `Part`, the largest first.

        Examples
        --------
        ``shares.by("light", "technique", "depth")``, ``shares.by("material")``.
        """
        groups: dict[Part, list[int]] = {}
        for k, part in enumerate(self.parts):
            key = Part(**{name: getattr(part, name) for name in fields})
            groups.setdefault(key, []).append(k)
        total = self.numerators.sum(axis=1)
        found = {
            key: self._share(self.numerators[:, of].sum(axis=1), total)
            for key, of in groups.items()
        }
        return dict(sorted(found.items(), key=lambda item: -item[1].value))

    def map_of(self, part: Part) -> np.ndarray:
        """Which variance of each pixel a part makes, (h, w); may be negative."""
        mine = [k for k, one in enumerate(self.parts) if _belongs(one, part)]
        return self.maps[mine].sum(axis=0)

    @staticmethod
    def _share(part: np.ndarray, total: np.ndarray) -> Share:
        if total.sum() == 0.0:
            return Share(0.0, 0.0)
        value = part.sum() / total.sum()
        # Of a ratio of means of independent batches (delta method).
        rest = part - value * total
        n = len(part)
        return Share(float(value), float(np.sqrt(np.sum(rest**2) / (n * (n - 1))) / total.mean()))


def _belongs(part: Part, group: Part) -> bool:
    return all(wanted is None or wanted == own for own, wanted in zip(part, group, strict=True))


def shares_of(
    scene: Scene,
    *,
    size: int = 128,
    spp: int = 64,
    seed: int = 0,
    region: tuple[float, float, float, float] | None = None,
) -> Shares:
    """Divide up the variance of a scene's picture.

    Parameters
    ----------
    scene : Scene
        With its own integrator and options; the sampler is replaced by the independent one.
    size : int in [8, 1024], pixels, default 128
        Of the longer side.
    spp : int >= 32, default 64
        Samples a pixel, rounded down to a multiple of 32.
    seed : int
    region : (float, float, float, float), optional
        x, y, width and height of the only part that counts, as shares of the full film's width and
        height; at least the pixels that it touches.

    Raises
    ------
    OptionError
        For an integrator that cannot say where its light comes from, or numbers out of range.
    """
    _check(scene, size, spp)
    arm = small(scene, size=size)
    flat = flatten(arm)
    compiled = compile_scene(flat, threads=usable_processors())
    recorder = Recorder(compiled, usable_processors())
    each = spp // (BATCHES * REPLICATES)
    seeds = np.random.SeedSequence((seed, 4)).generate_state(BATCHES + 1).tolist()
    _, pilot = recorder.run(PILOT, seeds[-1])
    weights = relative_weights(pilot[:, :, 0] / PILOT)
    if region is not None:
        weights = _within(weights, region)
    divider = _Divider(compiled, weights, each)
    for one in seeds[:-1]:
        divider.add(*recorder.run(each * REPLICATES, one, REPLICATES))
    return divider.result(_names(scene, flat, compiled))


def _check(scene: Scene, size: int, spp: int) -> None:
    kind = scene.integrator.type_name()
    if not can_record(kind):
        raise OptionError(
            f"the integrator {kind} does not record where its light comes from; "
            "path, direct, random_walk and bidirectional do"
        )
    WhyOptions.of({"size": size, "spp": spp})


def relative_weights(reference: np.ndarray) -> np.ndarray:
    """Weights (h, w, 3) with which squared errors add up to relMSE."""
    epsilon = (EPSILON * reference.mean()) ** 2
    return 1.0 / (np.maximum(reference, 0.0) ** 2 + max(epsilon, 1e-30)) / reference.size


def _within(weights: np.ndarray, region: tuple[float, float, float, float]) -> np.ndarray:
    """The weights (h, w, 3) of the pixels that a region touches, so that it has the same mean."""
    height, width = weights.shape[:2]
    x, y, w, h = region
    left, top = min(int(x * width), width - 1), min(int(y * height), height - 1)
    columns = slice(left, max(int(np.ceil((x + w) * width)), left + 1))
    rows = slice(top, max(int(np.ceil((y + h) * height)), top + 1))
    inside = np.zeros_like(weights)
    inside[rows, columns] = weights[rows, columns]
    return inside * (weights.size / weights[rows, columns].size)


class _Divider:
    """Adds batch after batch; kinds of contributions get numbers as they turn up."""

    def __init__(self, scene: CompiledScene, weights: np.ndarray, spp: int) -> None:
        self.size, self.weights, self.spp = scene.size, weights, spp
        self.rows: list[dict[int, float]] = []
        self.maps: dict[int, np.ndarray] = {}
        self.total = np.zeros(weights.shape)

    def add(self, contributions: Contributions, sums: np.ndarray) -> None:
        """One batch: its contributions, and the sums (h, w, REPLICATES, 3) that they make."""
        means = sums / self.spp
        deviation = means - means.mean(axis=2, keepdims=True)
        # Variance of one sample: that of the mean of N, times N.
        scale = self.spp / (REPLICATES - 1)
        factor = (deviation * self.weights[:, :, None] * scale).reshape(-1, REPLICATES, 3)
        found = contributions
        value = found.value.astype(np.float64) / self.spp
        products = np.sum(value * factor[found.pixel, found.replicate], axis=1)
        codes = _coded(found)
        row: dict[int, float] = {}
        pixels = self.size[0] * self.size[1]
        kinds, place = np.unique(codes, return_inverse=True)
        for k, code in enumerate(kinds.tolist()):
            mine = place == k
            here = np.bincount(found.pixel[mine], products[mine], minlength=pixels)
            row[code] = float(here.sum())
            self.maps[code] = self.maps.get(code, 0.0) + here
        self.rows.append(row)
        self.total += means.sum(axis=2)

    def result(self, names: tuple[list[str], list[str]]) -> Shares:
        """Everything that was added."""
        width, height = self.size
        codes = sorted(self.maps)
        numerators = np.array([[row.get(code, 0.0) for code in codes] for row in self.rows])
        numerators = numerators.reshape(BATCHES, len(codes))
        maps = np.array([self.maps[code] for code in codes]).reshape(-1, height, width) / BATCHES
        return Shares(
            parts=tuple(_part(code, *names) for code in codes),
            numerators=numerators,
            relative_variance=float(numerators.sum() / BATCHES),
            spp=self.spp * REPLICATES * BATCHES,
            picture=self.total / (REPLICATES * BATCHES),
            variance=maps.sum(axis=0),
            maps=maps,
        )


#: Bits of the fields of a code; deep paths share a kind.
_BITS = 16
_DEEPEST = 16


def _coded(found: Contributions) -> np.ndarray:
    depth = np.minimum(found.depth, _DEEPEST)
    code = (depth << _BITS | found.how) << _BITS
    return (code | found.light) << _BITS | (found.bsdf + 1)


def _part(code: int, lights: list[str], materials: list[str]) -> Part:
    low = (1 << _BITS) - 1
    bsdf, light = code & low, code >> _BITS & low
    how, depth = code >> 2 * _BITS & low, code >> 3 * _BITS
    material = materials[bsdf - 1] if bsdf else ""
    return Part(depth, TECHNIQUES[how], lights[light], material)


def _names(scene: Scene, flat: FlatScene, compiled: CompiledScene) -> tuple[list[str], list[str]]:
    """What the rows of the tables of lights, and the materials, are called in the scene."""
    shapes = compiled.tables.shapes.info.shaped.reshape(-1, SHAPE_INFO)
    rows = {int(row[2]) - 1: index for index, row in enumerate(shapes) if row[2] > 0}
    sources = [row.source for row in compile_shapes(flat).rows]
    lights = [flat.shapes[sources[rows[k]]].name for k in sorted(rows)]
    lights += [light.name for light in flat.lights]
    # Several environments are one light: `alight.integrators.contributions`.
    lights += [" + ".join(light.name for light in flat.environments)] * len(flat.environments)
    return lights, list(material_names(scene, flat))
