"""References know their own noise, are quiet enough, and are chosen by none of their samples."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from alight.films import Film, PartialFilm
from alight.films.fixed_point import to_limbs
from alight.lab import make_reference as making
from alight.lab.make_reference import make_reference
from alight.lab.references import Reference, demand_quiet, external_reference, reference_arm
from alight.lab.results import ReferenceInfo
from alight.lab.statistics.block_means import exact_statistics
from alight.lab.study import ReferenceSpec, Study, StudyError
from alight.metrics import relmse, relrmse
from alight.metrics.estimate import Estimate
from alight.outputs.image import write_image


def study_in(folder):
    return Study("truth", [], [], folder=folder)


def picture(shape=(12, 16, 3)):
    return (0.2 + np.random.default_rng(1).random(shape)).astype(np.float32)


@pytest.mark.parametrize("error", [0.01, 0.1])
def test_a_stated_error_is_the_relrmse_of_the_noise(tmp_path, error):
    """Noise of the variance that is taken has, over many pictures, the relRMSE that was stated."""
    image = picture()
    write_image(tmp_path / "truth.npy", image)
    spec = ReferenceSpec(file="truth.npy", error=error)
    found = external_reference(study_in(tmp_path), "reference", spec, (16, 12))
    np.testing.assert_array_equal(found.image, image)
    rng = np.random.default_rng(2)
    noise = rng.standard_normal((300, *image.shape)) * np.sqrt(found.variance)
    measured = math.sqrt(np.mean([relmse(image + one, image) for one in noise]))
    assert measured == pytest.approx(error, rel=0.02)
    assert found.info.relative_noise == pytest.approx(error, rel=1e-6)
    assert found.noise == pytest.approx(float((noise**2).mean()), rel=0.02)
    assert found.statistics.block_mean.mean() > 0.1


def noisy_film(sigma):
    """A film of four samples a pixel, one in each replicate."""
    rng = np.random.default_rng(3)
    values = 0.5 + sigma * rng.standard_normal((4, 12, 16, 3))
    limbs, _, _ = to_limbs(values.astype(np.float32))
    film = Film(16, 12)
    sums = np.moveaxis(limbs, 0, 2)
    film.add_tile(PartialFilm(0, 0, sums, np.ones((12, 16, 4), np.int64), 0, 0, (0, 4), None))
    return film


def test_standard_errors_in_the_file_are_squared(tmp_path):
    film = noisy_film(0.1)
    film.save(tmp_path / "truth.exr")
    spec = ReferenceSpec(file="truth.exr")
    found = external_reference(study_in(tmp_path), "reference", spec, (16, 12))
    # Stored as half floats, or as float32.
    np.testing.assert_allclose(found.variance, film.standard_error[..., :3] ** 2, rtol=3e-3)
    expected = relrmse(found.image + np.sqrt(found.variance), found.image)
    assert found.info.relative_noise == pytest.approx(expected, rel=1e-3)


def reference_of(noise, spp):
    image, variance = picture(), np.full((12, 16, 3), noise, np.float32)
    info = ReferenceInfo("rendered", "base", spp, 0.01, False, 0.0, "key")
    return Reference(image, variance, exact_statistics(image, variance), 16, info)


def test_a_reference_has_at_most_a_quarter_of_what_it_measures(tmp_path):
    study = study_in(tmp_path)
    demand_quiet(study, "reference", reference_of(0.0099, 64), "arm", 0.04)
    with pytest.raises(StudyError, match='25% of what arm "arm"'):
        demand_quiet(study, "reference", reference_of(0.0101, 64), "arm", 0.04)
    # To come to 5 % it needs 20 times the noise's share, and as many times the samples.
    with pytest.raises(StudyError, match="about 1282 spp instead of 64"):
        demand_quiet(study, "reference", reference_of(0.04004, 64), "arm", 0.04)
    # A file has no samples: its error must fall by the root.
    with pytest.raises(StudyError, match=r"about 4\.5 times smaller"):
        demand_quiet(study, "reference", reference_of(0.04, 0), "arm", 0.04)
    for nothing in (0.0, -0.01):
        with pytest.raises(StudyError, match=r"more than all.*12800 spp"):
            demand_quiet(study, "reference", reference_of(0.04, 64), "arm", nothing)


class Renders:
    """Films in the place of rendered ones: the error falls as the root of the samples."""

    def __init__(self, monkeypatch, first_error):
        self.first_error, self.asked = first_error, []
        monkeypatch.setattr(making, "render", self.render)
        monkeypatch.setattr(making, "Film", SimpleNamespace(merge=self.merge))

    def film(self, spp):
        value = self.first_error * math.sqrt(64 / spp)
        estimate = SimpleNamespace(relrmse=Estimate(value, 0.9 * value, 1.1 * value))
        return SimpleNamespace(spp=spp, relmse_estimate=lambda: estimate)

    def render(self, scene, *, spp, first_sample, seed, threads, progress):
        self.asked.append((seed, first_sample, spp))
        return self.film(spp)

    def merge(self, one, other):
        return self.film(one.spp + other.spp)


@pytest.mark.parametrize("error", [0.2, 0.09, 0.02, 0.004])
def test_a_reference_is_rendered_anew_with_as_many_samples_as_its_pilot_needed(monkeypatch, error):
    renders = Renders(monkeypatch, first_error=0.1)
    scene = SimpleNamespace(film=SimpleNamespace(replicates=4))
    made = make_reference(scene, error, seed=5)
    *pilots, final = renders.asked
    # The pilot's parts follow each other; the picture has a seed of its own and begins at 0.
    assert len({seed for seed, _, _ in pilots}) == 1
    assert final[0] != pilots[0][0]
    done = 0
    for _, first, spp in pilots:
        assert first == done
        done += spp
        # No leap on the word of one pilot.
        assert done <= 8 * max(first, 64)
    assert final[1:] == (0, done)
    assert made.pilot_spp == made.film.spp == done
    # Enough for the upper end of the interval, and not more than a quarter too much.
    needed = max(64.0, 64.0 * (1.1 * 0.1 / error) ** 2)
    assert needed <= done <= 1.25 * needed + 2


def test_references_that_would_take_for_ever_are_refused(monkeypatch):
    Renders(monkeypatch, first_error=0.1)
    scene = SimpleNamespace(film=SimpleNamespace(replicates=4))
    with pytest.raises(StudyError, match=r"error 0\.0005 would need about 2\.56e\+06 spp"):
        make_reference(scene, 0.0005)
    Renders(monkeypatch, first_error=math.nan)
    with pytest.raises(StudyError, match="is it black"):
        make_reference(scene, 0.01)


@pytest.mark.parametrize("biased", [False, True])
def test_the_baseline_renders_the_reference_if_it_may(biased):
    arms = [
        SimpleNamespace(name=name, declares_different=different, options={})
        for name, different in (("first", False), ("base", biased), ("last", False))
    ]
    study = SimpleNamespace(arms_of=lambda _: arms, baseline_of=lambda _: arms[1])
    scene = SimpleNamespace(reference=ReferenceSpec())
    assert reference_arm(study, scene) == ("first" if biased else "base")
