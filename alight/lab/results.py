"""What a study found, as plain data: everything that a report, a table or a test needs.

`save` writes one JSON file with the numbers and one npz file with the arrays next to it; `load`
gives equal results back. NaN means unknown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from alight.metrics import JUDGED, SHOWN, Estimate

UNKNOWN = Estimate(math.nan, math.nan, math.nan)

#: Verdicts of `BiasTest`. An arm is disputed if it disagrees with others, and no majority of the
#: arms says which of them is wrong.
UNBIASED, BIASED, DISPUTED = "unbiased", "biased", "disputed"
DIFFERENT = "different by declaration"


@dataclass(frozen=True)
class Point:
    """The errors of one arm at one number of samples; intervals are of 95 %.

    Attributes
    ----------
    spp : int
        Samples per pixel.
    seconds : Estimate
        CPU time of rendering one picture.
    errors : dict of str to (Estimate or None)
        Of one picture against the reference, by the metric's name. The reference's own noise is
        subtracted from (weighted) squared errors, and can't be from others. None where the metric
        needs a package that is not installed.
    bias2, variance : Estimate
        Parts of the MSE, both estimated without bias: bias2 may come out below 0.
    """

    spp: int
    seconds: Estimate
    errors: dict[str, Estimate | None]
    bias2: Estimate
    variance: Estimate

    @property
    def mse(self) -> Estimate:
        """The error by which arms are judged."""
        return self.errors[JUDGED] or UNKNOWN

    @property
    def relmse(self) -> Estimate:
        """The error that is shown where one must do."""
        return self.errors[SHOWN] or UNKNOWN


@dataclass(frozen=True)
class Speedup:
    """How many times more efficient an arm is than the baseline, at equal time.

    Attributes
    ----------
    ratio : Estimate
        Efficiency over the baseline's; 95 % t interval of its logarithm by the jackknife.
    p_value, p_adjusted : float
        Of "no difference", alone and by Holm over the arms of the scene.
    bootstrap : Estimate
        Bootstrap-t interval of the same ratio, as a cross-check.
    """

    ratio: Estimate
    p_value: float
    p_adjusted: float
    bootstrap: Estimate

    @property
    def significant(self) -> bool:
        """Whether the arm differs from the baseline at 5 % over all arms."""
        return self.p_adjusted < 0.05


@dataclass(frozen=True)
class BiasTest:
    """Whether the mean of an arm's pictures agrees with the reference.

    Attributes
    ----------
    block, blocks : int
        Pixels on the side of a block, and blocks that vary.
    z_rms, z_low, z_high, z_largest : float
        Root mean square of the blocks' z, its bounds if there is no bias, the largest abs(z).
    difference : list of Estimate
        Relative difference of the channel means (R, G, B): arm / reference - 1.
    p_value : float
        Of "no bias", corrected for the tests of this arm and over the arms of the scene: against
        the reference if the study names one, else of "it agrees with a majority of the arms".
    verdict : str
        `UNBIASED`, `BIASED`, `DISPUTED` or `DIFFERENT`.
    """

    block: int
    blocks: int
    z_rms: float
    z_low: float
    z_high: float
    z_largest: float
    difference: list[Estimate]
    p_value: float
    verdict: str


@dataclass(frozen=True)
class ArmImages:
    """Pictures of an arm at the number of samples that is nearest to its equal-time point.

    Attributes
    ----------
    example : ndarray of float32, shape (h, w, 3)
        One replicate: what a user would see after `example_seconds`.
    mean, variance : ndarray of float32, shape (h, w, 3)
        Over the replicates; unbiased variance of one picture.
    error : ndarray of float32, shape (h, w, 3)
        `mean` - reference.
    count : ndarray of float32, shape (h, w)
        Samples of each pixel in one picture.
    example_spp : int
    example_seconds : float
    """

    example: np.ndarray
    mean: np.ndarray
    variance: np.ndarray
    error: np.ndarray
    count: np.ndarray
    example_spp: int
    example_seconds: float


@dataclass(frozen=True)
class ArmResult:
    """One arm in one scene.

    Attributes
    ----------
    name, label : str
        As in the study file; the label is for figures.
    options : dict of str to value
        Key paths of the scene file that the arm sets.
    is_baseline, declares_different : bool
    replicates : int
        S.
    seeds : list of int
    samples : list of Point
        Equal-samples ladder, by rising spp.
    times : list of Point
        Equal-time ladder: the i-th point of every arm has the errors that it leaves in the
        baseline's time, interpolated between two numbers of samples that its sampler is made
        for; `spp` is the number between them that fits. Only where the smallest number takes
        longer is that the point.
    efficiency : Estimate
        1 / (MSE * seconds) at the last point of `times`.
    speedup : Speedup or None
        None for the baseline.
    slope_spp, slope_time : Estimate
        Of log(RMSE) over log(spp), and over log(seconds).
    expected_slope : float or None
        Of log(RMSE) over log(spp), where the study file says so.
    bias : BiasTest
    microseconds_per_sample : Estimate
        CPU time of one sample.
    compile_seconds, load_seconds : float
        Not part of any `seconds`.
    invalid : int
        Samples that were NaN or infinite.
    own_reference : ReferenceInfo or None
        Of arms that are compared with a reference of their own.
    images : ArmImages
    """

    name: str
    label: str
    options: dict[str, Any]
    is_baseline: bool
    declares_different: bool
    replicates: int
    seeds: list[int]
    samples: list[Point]
    times: list[Point]
    efficiency: Estimate
    speedup: Speedup | None
    slope_spp: Estimate
    slope_time: Estimate
    expected_slope: float | None
    bias: BiasTest
    microseconds_per_sample: Estimate
    compile_seconds: float
    load_seconds: float
    invalid: int
    own_reference: ReferenceInfo | None
    images: ArmImages


@dataclass(frozen=True)
class ReferenceInfo:
    """Where a reference comes from and how far it can be trusted.

    Attributes
    ----------
    source : str
        "rendered", "cached" or the name of a file.
    arm : str
        That rendered it; empty for files.
    spp : int
        0 where unknown.
    relative_noise : float
        relRMSE of the reference itself.
    declared : bool
        Whether `relative_noise` was stated by the user, not measured.
    seconds : float
        CPU time that it took; 0 for files.
    key : str
        Content hash.
    """

    source: str
    arm: str
    spp: int
    relative_noise: float
    declared: bool
    seconds: float
    key: str


@dataclass(frozen=True)
class SceneResult:
    """One scene of a study.

    Attributes
    ----------
    name, label : str
    size : list of int
        Width and height of the pictures.
    baseline : str
        Name of the arm that others are compared with.
    paired : bool
        Whether the arms share their seeds.
    order_seed : int
        Of the random order in which the arms of a block were rendered.
    reference : ReferenceInfo
    reference_image, reference_variance : ndarray of float32, shape (h, w, 3)
    arms : list of ArmResult
        In the order of the study file.
    crops : list of list of int
        (x, y, width, height) of parts worth a closer look; may be empty.
    notes : list of str
        What the reader must know, in words.
    """

    name: str
    label: str
    size: list[int]
    baseline: str
    paired: bool
    order_seed: int
    reference: ReferenceInfo
    reference_image: np.ndarray
    reference_variance: np.ndarray
    arms: list[ArmResult]
    crops: list[list[int]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Curve:
    """One line of a diagram with logarithmic axes.

    Attributes
    ----------
    name, label : str
    x, y, low, high : list of float
        Points and their 95 % intervals (equal to `y` where a value is exact).
    slope : Estimate or None
    expected_slope : float or None
    """

    name: str
    label: str
    x: list[float]
    y: list[float]
    low: list[float]
    high: list[float]
    slope: Estimate | None = None
    expected_slope: float | None = None


@dataclass(frozen=True)
class CurveResult:
    """A diagram: RMSE against N, time against triangles.

    Attributes
    ----------
    name, title, description : str
    x_label, y_label : str
    curves : list of Curve
    notes : list of str
    """

    name: str
    title: str
    description: str
    x_label: str
    y_label: str
    curves: list[Curve]
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class TableResult:
    """A table of a study's own.

    Attributes
    ----------
    name, title, description : str
    columns : list of str
    rows : list of list
        Texts, numbers, or [value, low, high].
    """

    name: str
    title: str
    description: str
    columns: list[str]
    rows: list[list[Any]]


@dataclass(frozen=True)
class StudyResult:
    """Everything that a study found.

    Attributes
    ----------
    name, title, description, teaches : str
        `teaches` says in a few sentences what is to be learnt.
    command : str
        That repeats the study.
    created : str
        ISO 8601.
    quick : bool
    replicates : int
    seed : int
        From which all seeds follow.
    machine, versions : dict of str to str
    seconds : dict of str to float
        "render" (CPU), "wall", "reference", "load", "compile", "statistics".
    scenes, curves, tables : list
        Any may be empty.
    """

    name: str
    title: str
    description: str
    teaches: str
    command: str
    created: str
    quick: bool
    replicates: int
    seed: int
    machine: dict[str, str]
    versions: dict[str, str]
    seconds: dict[str, float]
    scenes: list[SceneResult] = field(default_factory=list)
    curves: list[CurveResult] = field(default_factory=list)
    tables: list[TableResult] = field(default_factory=list)
