"""Reference pictures that know their own noise.

A reference is rendered with 16 independent seeds; their spread gives the variance of every pixel,
which the statistics subtract. References are kept next to the compiled kernels, under the content
hash of everything that decides them, so that the next study finds them.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from alight.core.errors import OutputError
from alight.lab.arms import Arm, digest, seed_of
from alight.lab.replicates.steering import is_biased
from alight.lab.results import ReferenceInfo
from alight.lab.statistics.block_means import BlockMoments, block_row, exact_statistics
from alight.lab.statistics.decomposition import Moments
from alight.lab.study import SCHEDULE, ReferenceSpec, SceneSpec, Study, StudyError
from alight.metrics.comparison import PictureStatistics
from alight.metrics.epsilon import default_epsilon
from alight.outputs.atomic import replacing
from lanewise.machine import cache_folder

#: Independent seeds of a reference.
SEEDS = 16

#: Largest share of the reference's noise in the error of an arm: rendered for, and refused above.
WANTED_SHARE, LARGEST_SHARE = 0.05, 0.25


@dataclass(frozen=True)
class Reference:
    """A reference and its noise.

    Attributes
    ----------
    image, variance : ndarray of float32, shape (h, w, 3)
        Variance of the image's own error.
    statistics : PictureStatistics
        Of its blocks.
    seeds : float
        Independent pictures that it is the mean of.
    info : ReferenceInfo
    """

    image: np.ndarray
    variance: np.ndarray
    statistics: PictureStatistics
    seeds: float
    info: ReferenceInfo

    @property
    def noise(self) -> float:
        """Mean variance over pixels and channels."""
        return float(self.variance.mean(dtype=np.float64))


def rendered_reference(
    arm: Arm,
    spp: int,
    study_seed: int,
    threads: int,
    tick: Callable[[float], None] | None = None,
) -> Reference:
    """Render a reference with an arm, or find it among those that were kept.

    Parameters
    ----------
    arm : Arm
        Must be unbiased.
    spp : int
        Samples per pixel in all.
    study_seed : int
        From which its seeds follow.
    threads : int
    tick : callable, optional
        Called with the share that is done.
    """
    each = -(-spp // SEEDS)
    key = digest("reference", arm.key, each, SEEDS, study_seed)
    path = cache_folder() / "references" / f"{key}.npz"
    kept = _kept(path, arm)
    if kept is not None:
        return kept
    moments, rows, seconds = Moments(), [], 0.0
    for number in range(SEEDS):
        for rung in arm.render(seed_of("reference", key, number), [each], threads):
            moments.add(rung.picture.astype(np.float64))
            rows.append(block_row(rung.picture))
            seconds += rung.seconds
        if tick is not None:
            tick((number + 1) / SEEDS)
    arrays = {
        "image": moments.mean.astype(np.float32),
        "variance": (moments.variance / SEEDS).astype(np.float32),
        "rows": np.stack(rows),
    }
    facts = {"arm": arm.spec.name, "spp": each * SEEDS, "seconds": seconds, "key": key}
    # A full disk costs the next study some time, nothing else.
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as beside, beside.open("wb") as file:
            np.savez(file, facts=json.dumps(facts), **arrays)
    except OSError:
        pass
    return _reference(arrays, {**facts, "source": "rendered"})


def _kept(path: Path, arm: Arm) -> Reference | None:
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in ("image", "variance", "rows")}
            facts = json.loads(str(stored["facts"]))
    except (OSError, ValueError, KeyError):
        return None
    if arrays["image"].shape[:2] != arm.size[::-1]:
        return None
    return _reference(arrays, {**facts, "arm": arm.spec.name, "source": "cached"})


def _reference(arrays: dict[str, np.ndarray], facts: dict) -> Reference:
    image, variance = arrays["image"], arrays["variance"]
    size = (image.shape[1], image.shape[0])
    statistics = BlockMoments.of(arrays["rows"], size).statistics
    info = ReferenceInfo(
        facts["source"], facts["arm"], facts["spp"], _relative(image, variance), False,
        facts["seconds"], facts["key"],
    )  # fmt: skip
    return Reference(image, variance, statistics, SEEDS, info)


def is_named(scene: SceneSpec) -> bool:
    """Whether the study says who the reference is."""
    return bool(scene.reference.file or scene.reference.arm)


def fit_arms(study: Study, scene: SceneSpec) -> list[str]:
    """Arms that may render a reference: they mean to compute what the baseline does."""
    return [
        arm.name
        for arm in study.arms_of(scene)
        if not (arm.declares_different or is_biased(arm.options.get(SCHEDULE)))
    ]


def reference_arm(study: Study, scene: SceneSpec) -> str:
    """The arm that the study names for its reference, else the baseline.

    Never the arm that looks best: one that loses light is less noisy.

    Parameters
    ----------
    study : Study
    scene : SceneSpec

    Raises
    ------
    StudyError
        For an arm that does not run in the scene, or is biased by its own words.
    """
    name, fit = scene.reference.arm, fit_arms(study, scene)
    if not name:
        baseline = study.baseline_of(scene).name
        return baseline if baseline in fit or not fit else fit[0]
    path = f"scenes[{list(study.scenes).index(scene)}].reference.arm"
    found = {arm.name: arm for arm in study.arms_of(scene)}.get(name)
    if found is None:
        raise study.fail(path, f'arm "{name}" does not run in this scene')
    if name not in fit:
        different = found.declares_different
        why = "is declared different" if different else "decides by the samples that it keeps"
        raise study.fail(path, f'arm "{name}" {why}: it cannot be a reference')
    return name


def external_reference(
    study: Study, path: str, spec: ReferenceSpec, size: tuple[int, int]
) -> Reference:
    """Read a reference that was made elsewhere.

    Parameters
    ----------
    study : Study
    path : str
        Of the key in the study file, for messages.
    spec : ReferenceSpec
        With a file, and a stated error unless the file has a layer of standard errors.
    size : (int, int)
        Width and height that it must have.

    Raises
    ------
    StudyError
        If it cannot be read, has another size, holds NaN, or its noise is not known.
    """
    from alight.outputs import exr
    from alight.outputs.image import read_image

    file = study.folder / spec.file
    if not file.is_file():
        raise study.fail(f"{path}.file", f"there is no file {file}")
    layers: dict[str, np.ndarray] = {}
    try:
        image = np.asarray(read_image(file), np.float32)
        if file.suffix.lower() == ".exr":
            layers, _ = exr.read_layers(file)
    except (OutputError, OSError, ValueError) as error:
        raise study.fail(f"{path}.file", str(error)) from None
    if image.shape != (size[1], size[0], 3):
        raise study.fail(
            f"{path}.file",
            f"must have {size[0]}x{size[1]} pixels as the arms, "
            f"got {image.shape[1]}x{image.shape[0]}",
        )
    if not np.isfinite(image).all():
        raise study.fail(f"{path}.file", "holds NaN or infinity")
    names = [f"standard_error.{c}" for c in "RGB"]
    if spec.error is not None:
        variance = spec.error**2 * (image**2 + default_epsilon(image))
    elif all(name in layers for name in names):
        variance = np.stack([layers[name] for name in names], axis=-1) ** 2
        if not np.isfinite(variance).all():
            raise study.fail(f"{path}.file", "its standard error is unknown in some pixels")
    else:
        raise study.fail(
            f"{path}.error",
            "is missing: how noisy is the reference? State its relRMSE, as error: 0.5%, "
            "or make it with alight reference, which writes its standard errors",
        )
    variance = variance.astype(np.float32)
    info = ReferenceInfo(
        str(spec.file), "", 0, _relative(image, variance), spec.error is not None, 0.0,
        digest("file", hashlib.sha256(image.tobytes() + variance.tobytes()).hexdigest()),
    )  # fmt: skip
    return Reference(image, variance, exact_statistics(image, variance), 4.0, info)


def _relative(image: np.ndarray, variance: np.ndarray) -> float:
    """relRMSE of a picture with this variance."""
    scale = image.astype(np.float64) ** 2 + default_epsilon(image)
    if not (scale > 0.0).all():
        return math.nan
    return math.sqrt(float((variance / scale).mean()))


def demand_quiet(study: Study, path: str, reference: Reference, arm: str, mse: float) -> None:
    """Refuse a reference whose noise would drown what an arm is to be measured by.

    Parameters
    ----------
    study : Study
    path : str
        Key of the reference, for the message.
    reference : Reference
    arm : str
        The least noisy arm.
    mse : float
        Its mean squared error, the reference's noise subtracted.

    Raises
    ------
    StudyError
    """
    noise = reference.noise
    if mse > 0.0 and noise <= LARGEST_SHARE * mse:
        return
    # Without the smallest idea of the arm's own error, ask for a tenth of the noise.
    factor = noise / (WANTED_SHARE * max(mse, 0.1 * noise))
    spp = reference.info.spp
    remedy = (
        f"it would need about {math.ceil(spp * factor)} spp instead of {spp}: set reference.spp"
        if spp
        else f"its error must be about {math.sqrt(factor):.1f} times smaller"
    )
    raise StudyError(
        [
            study.issue(
                path,
                f"the reference is too noisy: its own noise is {_percent(noise, mse)} of what arm "
                f'"{arm}" is measured by; {remedy}',
            )
        ]
    )


def _percent(noise: float, mse: float) -> str:
    return f"{noise / mse:.0%}" if mse > 0.0 else "more than all"
