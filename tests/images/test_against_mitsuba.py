"""Our pictures are Mitsuba's, within noise: every scene of ``scenes/`` against its reference.

``make_references.py`` made the references; `alight.metrics.comparison` says what is tested. The
numbers of samples are chosen such that an albedo that is 1 % too low is found with certainty.
"""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import alight
from alight.core.spec import Bsdf
from alight.metrics.comparison import Comparison, PictureStatistics, compare_pictures
from tests.portion import portion

HERE = Path(__file__).parent
NAMES = sorted(path.stem for path in (HERE / "references").glob("*.npz"))
BUILT_IN = {"cornell-box": (64, 64)}
#: Compared by every `make test`, together with one of Mitsuba's own files, which shows spots,
#: environment maps, two-sided and textured surfaces (`tests/formats/mitsuba/test_picture.py`). What
#: the others show besides has closed forms and laws of its own; `make proofs` compares them too.
ALWAYS = {
    "cornell-box", "fog", "many-lights", "mesh-light", "null-surface", "rough-glasses",
    "rough-metals", "textured-light", "thin-lens",
}  # fmt: skip
OTHERS = [name for name in NAMES if name not in ALWAYS]
CASES = [*sorted(ALWAYS), *(pytest.param(n, marks=pytest.mark.proofs) for n in portion(OTHERS))]

REPLICATES = 32
# Enough for a replicate's block of 4 pixels to be nearly normal in spite of the skewed samples.
SPP = 64
# Probability of a false alarm in any of the scenes.
FAMILY_LEVEL = 0.01
# Blocks with less relative noise than this hold one value (sky, a lamp, black) and its rounding.
STILL = 1e-5
ROUNDING = 1e-4


def load_reference(name: str) -> PictureStatistics:
    """Read the stored side, without its provenance."""
    with np.load(HERE / "references" / f"{name}.npz", allow_pickle=False) as stored:
        names = [field.name for field in dataclasses.fields(PictureStatistics)]
        return PictureStatistics(**{key: stored[key][()] for key in names})


def load_scene(name: str) -> alight.Scene:
    """Load the twin: a file, or a built-in scene with the size and sampler of its reference."""
    if name not in BUILT_IN:
        return alight.load(HERE / "scenes" / f"{name}.yaml")
    scene = alight.load(name)
    independent = alight.load(HERE / "scenes" / "point-light.yaml").sampler
    return scene.replaced(sampler=independent, film=scene.film.replaced(size=BUILT_IN[name]))


def render_replicates(scene: alight.Scene) -> PictureStatistics:
    """As many independent pictures, of a scene that is prepared once."""
    film = alight.render(scene, spp=REPLICATES * SPP, seed=0, replicates=REPLICATES)
    means, counts = film.replicate_means()
    assert (counts == SPP).all()
    return PictureStatistics.of(np.moveaxis(means, 2, 0))


def without_still_blocks(
    a: PictureStatistics, b: PictureStatistics
) -> tuple[PictureStatistics, PictureStatistics]:
    """Check that blocks without noise agree up to rounding, and take them out of the statistics."""
    still = np.ones(a.block_mean.shape, bool)
    for side in (a, b):
        still &= np.sqrt(side.block_variance) <= STILL * np.abs(side.block_mean)
    np.testing.assert_allclose(a.block_mean[still], b.block_mean[still], rtol=ROUNDING)

    def exact(side: PictureStatistics) -> PictureStatistics:
        return dataclasses.replace(
            side,
            block_mean=np.where(still, 0.0, side.block_mean),
            block_variance=np.where(still, 0.0, side.block_variance),
        )

    return exact(a), exact(b)


def compare(ours: PictureStatistics, name: str) -> Comparison:
    sides = without_still_blocks(ours, load_reference(name))
    # Samples are many enough for small blocks, which show where pictures differ.
    result = compare_pictures(*sides, level=FAMILY_LEVEL / len(NAMES), join=False)
    assert np.isfinite(result.z).sum() >= 1000, "too few blocks for the bounds on rms(z)"
    return result


@pytest.mark.parametrize("name", CASES)
def test_picture_is_mitsubas_within_noise(name: str, tmp_path: Path) -> None:
    ours = render_replicates(load_scene(name))
    result = compare(ours, name)
    assert result.passed, f"{result.report()}\npictures in {result.dump(tmp_path / name)}"


def test_every_scene_has_a_reference() -> None:
    scenes = {path.stem for path in (HERE / "scenes").glob("*.yaml")}
    assert scenes | set(BUILT_IN) == set(NAMES) >= ALWAYS


def test_albedo_changed_by_one_percent_is_found() -> None:
    scene = load_scene("cornell-box")
    changed = scene.replaced(bsdfs={name: _darker(bsdf) for name, bsdf in scene.bsdfs.items()})
    result = compare(render_replicates(changed), "cornell-box")
    assert not result.passed, f"a change of 1 % went unseen\n{result.report()}"


def _darker(bsdf: Bsdf) -> Bsdf:
    return bsdf.replaced(reflectance=tuple(0.99 * channel for channel in bsdf.reflectance))
