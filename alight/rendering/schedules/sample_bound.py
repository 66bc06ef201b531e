"""The largest value that a sample of a scene can have, from what its models say of themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from alight.core.spec import largest_of

if TYPE_CHECKING:
    from alight.scene.flatten import FlatScene


def largest_sample(flat: FlatScene, by_tree: bool) -> float | None:
    """Bound every channel of every sample; None where it is not known to be bounded.

    Parameters
    ----------
    flat : FlatScene
    by_tree : bool
        Whether a tree chooses lights (`Program.light_tree`): samples are divided by a density that
        knows the normal, but weighed by one that does not, and their quotient has no bound.
    """
    if by_tree or flat.lights or len(flat.environments) > 1:
        # Light at points has no bound; environments add up.
        return None
    lights = [shape.light for shape in flat.shapes if shape.light is not None]
    lights += [placed.light for placed in flat.environments]
    radiance = largest_of(light.largest_radiance() for light in lights)
    weight = largest_of(bsdf.largest_weight() for bsdf in flat.bsdfs)
    start = flat.film.filter.largest_weight
    if radiance is None or weight is None or start is None:
        return None
    return flat.integrator.largest_sample(radiance, weight, start)
