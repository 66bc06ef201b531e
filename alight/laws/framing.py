"""The law of automatic cameras: they see all of every shape, and little else."""

from __future__ import annotations

import numpy as np

from alight.cameras.basis import perspective_half_extents, project_points
from alight.formats.geometry.bounds import FOV, FOV_AXIS, MARGIN, NEAREST, Bounds
from alight.laws.bodies import Body, N, placed_everywhere, rows_of
from alight.laws.report import demand
from alight.scene.transform import look_at

#: A shape that fills less of the picture has been framed as something larger; lines that miss the
#: corners of a triangle leave a tenth of it out.
FILLED = 0.7


@placed_everywhere
def an_automatic_camera_sees_all_of_it(body: Body) -> None:
    """Hits lie within the picture of the camera that is placed for it, and reach its margins."""
    if not body.spec.finite:
        return
    bounds, size = Bounds(), (80, 60)
    bounds.add(body.spec, body.to_world)
    view = look_at(*bounds.viewpoint(size)).matrix
    o, d = body.lines(4)
    hit, surface = body.hit(o, d, np.ones(N, bool))
    p = rows_of(surface.p, N)[:, np.isfinite(hit.t)].T
    film = project_points(p, perspective_half_extents(FOV, FOV_AXIS, *size), size, view, True)
    places, depths = film[:, :2] / size, film[:, 2]
    inside = (places > MARGIN - 1e-3) & (places < 1.0 - MARGIN + 1e-3)
    demand(inside, "a hit lies outside of the picture")
    fills = float((places.max(axis=0) - places.min(axis=0)).max())
    close = depths.min() < 1.02 * NEAREST * bounds.sphere[1]
    demand(fills > FILLED or close, f"it fills {fills:.3g} of the picture only")
