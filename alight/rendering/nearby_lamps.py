r"""Where light paths of a pilot start: half of them at lamps close to what the camera sees.

By power alone, a sky or far street lamps get all light paths, and a lamp in a frosted bulb before
the camera none. So half of them choose a lamp by what it would give without walls:

.. math:: \overline{\Phi_i / (d^2 + s^2)} ,

the mean over places on the lamp and points that the camera sees, d apart; :math:`s^2` is the area
that one of these points stands for. Lamps at infinity have no place, and keep the other half.
"""

from __future__ import annotations

import numpy as np

from alight.core.distributions import cumulative
from alight.lights.emission.density import is_kind
from alight.lights.emission.sampling import emit_chosen
from alight.lights.tables import CHOICE, INFO
from alight.rendering.pilot_rays import Pilot, Seen, columns_of, dots, lanes_of, wide
from lanewise.view import View

#: Places on each lamp, and points that the camera sees.
_PLACES, _POINTS = 4, 32


def with_nearby_lamps(pilot: Pilot, seen: Seen) -> Pilot:
    """The pilot, with other probabilities of lamps; its tables are those of lights that emit."""
    lights = pilot.tables.lights
    n = lights.info.array.size // INFO
    if n < 2 or not len(seen.point):
        return pilot
    by_nearness = _nearness(pilot, n, seen)
    if not by_nearness.any():
        return pilot
    emission = lights.emission.array.copy()
    table = slice(CHOICE, CHOICE + n + 1)
    by_power = np.diff(emission[table].astype(np.float64))
    emission[table] = cumulative(0.5 * by_power + 0.5 * by_nearness / by_nearness.sum())
    tables = pilot.tables._replace(lights=lights._replace(emission=View(emission)))
    return Pilot(pilot.scene, pilot.random, tables)


def _nearness(pilot: Pilot, n: int, seen: Seen) -> np.ndarray:
    """What each of n lamps would give to what the camera sees; of no unit, (n,) float64."""
    rows = np.repeat(np.arange(n, dtype=np.uint32), _PLACES)
    # Random numbers of its own: a single lamp has the same light paths with and without.
    u, ux, uy, vx, vy = np.random.default_rng(0).random((5, len(rows))).astype(np.float32)
    tables = pilot.at(np.zeros(len(rows), np.float32))
    e = pilot.twin(emit_chosen)(tables, rows, u, (ux, uy), (vx, vy))
    on_shape, near, _ = (wide(kind, len(rows)) for kind in pilot.twin(is_kind)(tables, rows))
    flux = columns_of(lanes_of(e.flux, len(rows))).mean(axis=1)
    flux = np.where(on_shape | near, np.nan_to_num(flux), 0.0)
    p = columns_of(lanes_of(e.p, len(rows)))
    some = seen.some(np.arange(0, len(seen.point), max(len(seen.point) // _POINTS, 1)))
    points = columns_of(some.o) + some.hit.t.astype(np.float64)[:, None] * columns_of(some.d)
    aside = points - points.mean(axis=0)
    area = max(float(dots(aside, aside).mean()) / len(seen.point), 1e-30)
    given = np.zeros(len(rows))
    for point in points:
        given += 1.0 / (dots(p - point, p - point) + area)
    return (flux * given).reshape(n, _PLACES).mean(axis=1)
