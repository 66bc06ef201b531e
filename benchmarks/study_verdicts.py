"""How often a study says what is not so: of bias, and of speed.

    python benchmarks/study_verdicts.py same --seeds 1:400:2
    python benchmarks/study_verdicts.py dark --seeds 1:20:2 --missing 0.01
    python benchmarks/study_verdicts.py dark --seeds 1:20:2 --missing 0.01 --baseline

``same`` runs studies of arms that differ in nothing but their names: whatever is found is false. In
``dark`` one more arm loses a share of the light at every wall, by a user's material whose field
`sampling` says that it changes the noise only, and no reference is named; with ``--baseline`` that
arm is the baseline. One line of JSON a study, then the sums. Constants are chosen on even seeds and
judged on odd ones.
"""

import argparse
import json
import tempfile
from typing import Annotated, Any, Literal

import numpy as np
from scipy import stats

import alight
from alight.bsdfs.matte import diffuse
from alight.core.field_types import Reflectance
from alight.core.noise_only import NoiseOnly
from alight.core.spec import Bsdf
from alight.lab.results import BIASED, DISPUTED, ArmResult
from alight.lab.run import run_study
from alight.lab.study import ArmSpec, SceneSpec, Study

#: Share of the light that each kind of `sampling` loses.
MISSING = {"cosine": 0.0, "a hundredth less": 0.01, "three thousandths less": 0.003}
WALLS = {
    "white": (0.885809, 0.698859, 0.666422),
    "green": (0.105421, 0.37798, 0.076425),
    "red": (0.570068, 0.0430135, 0.0443706),
}


class LeakySpec(Bsdf):
    """Matt surface with a field that should change the noise only, and loses light."""

    type: Literal["leaky"] = "leaky"
    reflectance: Reflectance = (0.5, 0.5, 0.5)
    sampling: Annotated[
        Literal["cosine", "a hundredth less", "three thousandths less"], NoiseOnly()
    ] = "cosine"


def pack(spec: LeakySpec, packer: Any) -> None:
    """Lose the light in the numbers, so that all arms run the same machine code."""
    kept = 1.0 - MISSING[spec.sampling]
    packer.numbers("reflectance", *(kept * channel for channel in spec.reflectance))
    packer.numbers("uniform", 0.0)


def is_lossless(spec: LeakySpec) -> bool:
    """No."""
    return False


@alight.register
class Leaky:
    """`diffuse`, but for what is lost."""

    EXAMPLES = (LeakySpec(),)
    SLOTS, pack, load = diffuse.SLOTS, pack, diffuse.load
    evaluate, sample, albedo = diffuse.evaluate, diffuse.sample, diffuse.albedo
    is_lossless, is_reciprocal = is_lossless, diffuse.is_reciprocal


def study_of(args: argparse.Namespace, seed: int) -> Study:
    """The study of a seed."""
    names = ("first", "second", "third", "fourth")[: 4 if args.what == "same" else 3]
    arms = [ArmSpec(name, {"sampler": args.sampler}) for name in names]
    options: dict[str, Any] = {"size": [args.size, args.size]}
    if args.what == "dark":
        for wall, color in WALLS.items():
            options[f"bsdfs.{wall}"] = {"type": "leaky", "reflectance": list(color)}
        word = next(word for word, share in MISSING.items() if share == args.missing)
        leaks = {f"bsdfs.{wall}.sampling": word for wall in WALLS}
        arms.append(ArmSpec("dark", {"sampler": args.sampler, **leaks}))
    baseline = "dark" if args.baseline else "first"
    scene = SceneSpec("cornell-box", options=options)
    return Study(
        "verdicts", arms=arms, scenes=[scene], spp=(16, 64), replicates=args.replicates,
        baseline=baseline, seed=seed,
    )  # fmt: skip


def facts_of(arm: ArmResult) -> dict[str, Any]:
    """What is said of an arm."""
    found: dict[str, Any] = {
        "verdict": arm.bias.verdict, "p_bias": arm.bias.p_value,
        "mean": [100.0 * one.value for one in arm.bias.difference],
        "spp": [point.spp for point in arm.times],
        "mse": [point.mse.value for point in arm.samples],
        "seconds": [point.seconds.value for point in arm.samples],
    }  # fmt: skip
    if arm.speedup:
        one = arm.speedup
        found |= {
            "speedup": list(one.ratio), "bootstrap": list(one.bootstrap), "p": one.p_value,
            "significant": one.significant,
        }  # fmt: skip
    return found


def run(args: argparse.Namespace, seed: int) -> dict[str, Any]:
    """Run the study of one seed, in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder:
        (scene,) = run_study(study_of(args, seed), folder, threads=args.threads).scenes
    return {
        "seed": seed,
        "reference": scene.reference.arm,
        "arms": {arm.name: facts_of(arm) for arm in scene.arms},
    }


def tail(hits: int, trials: int, level: float) -> str:
    """A count beside the level that it should have, and how likely so many are."""
    p = float(stats.binom.sf(hits - 1, trials, level)) if hits else 1.0
    return (
        f"{hits} of {trials} ({level:.0%} are {level * trials:.3g}; so many or more: p = {p:.2g})"
    )


def report(args: argparse.Namespace, results: list[dict[str, Any]]) -> None:
    """Print the sums."""
    arms = [(name, arm) for one in results for name, arm in one["arms"].items()]
    right = [[a for name, a in one["arms"].items() if name != "dark"] for one in results]
    for verdict in (BIASED, DISPUTED):
        named = sum(any(arm["verdict"] == verdict for arm in study) for study in right)
        print(f"studies with a right arm called {verdict}: {tail(named, len(results), 0.01)}")
    if args.what == "dark":
        dark = [arm for name, arm in arms if name == "dark"]
        named = sum(arm["verdict"] == BIASED for arm in dark)
        lost = np.mean([arm["mean"] for arm in dark], axis=0)
        print(f"the dark arm named: {named} of {len(dark)}; its mean is off by {lost} %")
        print("references by:", sorted({one["reference"] for one in results}))
        return
    compared = [arm for _, arm in arms if "p" in arm]
    p_values = np.array([arm["p"] for arm in compared])
    some = sum(any(arm.get("significant") for arm in study) for study in right)
    print(f"studies with a false speed: {tail(some, len(results), 0.05)}")
    below = int((p_values < 0.05).sum())
    print(f"comparisons with p < 0.05, uncorrected: {tail(below, len(p_values), 0.05)}")
    for name in ("speedup", "bootstrap"):
        bounds = np.array([arm[name] for arm in compared])
        missed = int(((bounds[:, 1] > 1.0) | (bounds[:, 2] < 1.0)).sum())
        print(f"95 % intervals ({name}) without 1: {tail(missed, len(bounds), 0.05)}")
    ratios = np.log([arm["speedup"][0] for arm in compared])
    print(
        f"speed-ups: median {np.exp(np.median(ratios)):.4f}, 95 % of them within "
        f"{np.exp(np.quantile(ratios, 0.025)):.3f} and {np.exp(np.quantile(ratios, 0.975)):.3f}; "
        f"one arm a study: Kolmogorov-Smirnov p = "
        f"{stats.kstest([study[1]['p'] for study in right], 'uniform').pvalue:.3g}"
    )


def main() -> None:
    """Read the command line, run the studies, print the sums."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("what", choices=("same", "dark"))
    parser.add_argument("--seeds", default="1:21:2", help="first:end:step")
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--replicates", type=int, default=16)
    parser.add_argument("--sampler", default="sobol")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--missing", type=float, default=0.01, choices=(0.01, 0.003))
    parser.add_argument("--baseline", action="store_true", help="the dark arm is the baseline")
    args = parser.parse_args()
    results = []
    for seed in range(*map(int, args.seeds.split(":"))):
        results.append(run(args, seed))
        print(json.dumps(results[-1]), flush=True)
    report(args, results)


if __name__ == "__main__":
    main()
