"""A file of Mitsuba gives Mitsuba's picture, where the meaning of what it says is easy to miss.

``picture/objects.xml`` shows textures on every shape, mirrors, instances, lights and more;
``make_picture.py`` rendered it with Mitsuba. Ours must be the same within noise.
"""

import numpy as np

import alight
from alight.metrics.comparison import Comparison, PictureStatistics, compare_pictures
from tests.formats.mitsuba.reading import PICTURE

SEEDS, SPP = 32, 64


def compare() -> Comparison:
    """Render the file and compare it with the stored picture."""
    scene = alight.load(PICTURE / "objects.xml")
    films = [alight.render(scene, spp=SPP, spp_per_pass=SPP, seed=seed) for seed in range(SEEDS)]
    assert sum(film.invalid for film in films) == 0
    ours = PictureStatistics.of(np.stack([film.image for film in films]))
    return compare_pictures(ours, PictureStatistics.load(PICTURE / "objects.npz"), join=False)


def test_picture_is_mitsubas_within_noise(tmp_path):
    result = compare()
    assert np.isfinite(result.z).sum() >= 1000, "too few blocks for the bounds on rms(z)"
    assert result.passed, f"{result.report()}\npictures in {result.dump(tmp_path / 'objects')}"
