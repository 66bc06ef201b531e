"""A stand-in for the renderer: noise in the shape of a film, in no time."""

import numpy as np

from alight.films import Film, PartialFilm
from alight.films.fixed_point import to_limbs
from alight.rendering import Progress


class StubRender:
    """Takes a scene and `RenderOptions`, keeps them, and fills a film with noise.

    Parameters
    ----------
    during : dict of str to callable
        Called when the phase ("compile", "render") begins.
    """

    def __init__(self, during=None, value=1.0):
        self.during = during or {}
        self.value = value
        self.scene = self.options = None
        self.compiled = False

    def __call__(self, scene, options):
        self.scene, self.options = scene, options
        progress, cancel = options.progress, options.cancel
        film = Film(
            *scene.film.size, crop=scene.film.crop,
            replicates=options.replicates or scene.film.replicates,
            aovs=dict.fromkeys(options.aovs, ("R", "G", "B")), seed=options.seed,
            scene_hash="stub",
        )  # fmt: skip
        progress(Progress("compile", 0, 0, 0.0, film))
        self.during.get("compile", lambda: None)()
        self.compiled = True
        progress(Progress("render", 0, 0, 0.0, film))
        total = (options.spp or 8) * film.sample_count.size
        done, step = 0, film.replicates
        while done < total and not cancel.is_set():
            film.add_tile(self._samples(film, done // film.sample_count.size, step))
            done += step * film.sample_count.size
            progress(Progress("render", done, total, 1.5, film))
            self.during.get("render", lambda: None)()
        film.stats = {
            "seconds": {"load": 0.1, "compile": 0.2, "bvh": 0.0, "render": 1.5},
            "spp": film.spp, "msamples_per_s": 1.25, "rays": 10, "peak_rss_mb": 99.0,
        }  # fmt: skip
        return film

    def _samples(self, film, first, step):
        x, y, w, h = film.crop
        values = np.random.default_rng([first]).lognormal(-1, 0.5, (step, h, w, 3)) * self.value
        limbs, invalid, saturated = to_limbs(values.astype(np.float32))
        sums = np.moveaxis(limbs, 0, 2)
        counts = np.ones((h, w, step), np.int64)
        aovs = {name: limbs.sum(axis=0) for name in film.aov_sums}
        bad = int(invalid.any(axis=-1).sum())
        return PartialFilm(x, y, sums, counts, bad, int(saturated.sum()), (first, step), aovs)
