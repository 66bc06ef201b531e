r"""What trials leave open because they have met too little of the light.

Where a few bright samples carry the noise of two pictures, chance decides which of them seems to be
quieter. But the pilot of a promise (`alight.rendering.rare_light`) knows such light: how bright
samples are that have found it, and how often the scene as it is finds it. That is noise u, in
whatever trial. An alternative that shows the noise v, and leaves the part u' of that light to
chance as well, is

.. math:: \frac{u\, t}{(v + u')\, t'}

times as efficient or more, with t and t' the times of a sample.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from alight.compiled.scene import CompiledScene
from alight.core.spec import Integrator
from alight.rendering.rare_light import RareLight
from alight.rendering.schedules.rare_noise import rare_noise
from alight.rendering.sight import Sight
from alight.scene import Scene, flatten

#: From so much on that counts as an advantage: the pilot knows such noise to about a quarter, but
#: it traces few light paths.
CLEAR = 3.0


def rare_noises(
    scene: Scene,
    compiled: CompiledScene,
    others: Iterable[Integrator],
    sums: np.ndarray,
    spp: int,
) -> list[float]:
    """Variance of one sample by light that is found by chance, in relMSE.

    Parameters
    ----------
    scene : Scene
        The scene as it is, and `compiled`.
    others : iterable of Integrator
    sums : ndarray, shape (h, w, R, 3)
        Of R replicates of the scene as it is, which have `spp` samples a pixel together.
    spp : int

    Returns
    -------
    list of float
        Of the scene as it is, and of each of the others.
    """
    rare = RareLight(Sight(flatten(scene), compiled))
    counts = np.full(sums.shape[:3], spp // sums.shape[2])
    means = sums / counts[..., None]
    tables = [rare.everywhere, *map(rare.left_by, others)]
    return [rare_noise(means, counts, table).noise * spp for table in tables]
