r"""What trials leave open because they have met too little of the light.

Where a few bright samples carry the noise of two pictures, chance decides which of them seems to be
quieter; and a picture that has met none of them seems to be quiet beyond doubt. But the pilot of a
promise (`alight.rendering.rare_light`) knows such light: how bright samples are that have found it,
and how often the scene as it is finds it. That is noise u, in whatever trial. An alternative that
shows the noise v, and leaves the part u' of that light to chance as well, is

.. math:: \frac{u\, t}{(v + u')\, t'}

times as efficient or more, with t and t' the times of a sample.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from alight.compiled.scene import CompiledScene
from alight.core.spec import Integrator
from alight.rendering.pilot_rays import POINTS
from alight.rendering.rare_light import RareLight
from alight.rendering.schedules.unseen import cell_sum
from alight.rendering.sight import Sight
from alight.scene import Scene, flatten

#: From so much on that counts as an advantage: the pilot knows such noise to about a quarter, but
#: it traces few light paths.
CLEAR = 3.0


def rare_noises(
    scene: Scene, compiled: CompiledScene, others: Iterable[Integrator], weights: np.ndarray
) -> list[float]:
    """Variance of one sample by light that is found by chance.

    Parameters
    ----------
    scene : Scene
        The scene as it is, and `compiled`.
    others : iterable of Integrator
    weights : ndarray, shape (h, w, 3)
        Of squared errors.

    Returns
    -------
    list of float
        Of the scene as it is, and of each of the others.
    """
    rare = RareLight(Sight(flatten(scene), compiled))
    pixels = weights.shape[0] * weights.shape[1]
    of_cells = cell_sum(weights) / cell_sum(np.ones_like(weights)) * (pixels / POINTS)
    tables = [rare.everywhere, *map(rare.left_by, others)]
    return [_noise(table, of_cells.reshape(-1, 3)) for table in tables]


def _noise(table: np.ndarray | None, weights: np.ndarray) -> float:
    """Of light m that a sample meets with probability r: m^2 / r, as r is small."""
    if table is None:
        return 0.0
    # What no path finds brings no noise.
    rows = table[table[:, -1] > 0.0]
    squares = rows[:, 2:5] ** 2 * weights[rows[:, 1].astype(int)]
    return float((squares.sum(axis=1) / rows[:, -1]).sum())
