"""Light that no path of an integrator finds, whatever the number of samples."""

from __future__ import annotations

from alight.compiled.scene import CompiledScene
from alight.films.ledger import Bias
from alight.integrators.caustics.chain_types import has_chains
from alight.lights.sampling import has_delta_lights

_UNSEEN = Bias("light paths", "what is seen in mirrors and through clear glass is missing")

_CAUSTICS = "caustics of lights without a size"

#: Such light has no density: neither light sampling nor a path that happens to go there finds it.
_NONE = Bias("caustics", f"{_CAUSTICS} are missing: no path finds them (caustics: manifold does)")

_SOME = Bias("caustics", f"{_CAUSTICS} are missing where walks do not cover them")

#: Paths from both ends cannot be joined there.
_SEEN_IN_MIRRORS = Bias(
    "caustics", f"{_CAUSTICS} are missing where they are seen in mirrors and through clear glass"
)


def unfound_light(scene: CompiledScene) -> tuple[Bias, ...]:
    """The entries of the ledger that a scene and its integrator decide, before any sample."""
    program, integrator = scene.program, scene.integrator
    if integrator.splats and not integrator.transports:
        return (_UNSEEN,)
    if not (integrator.needs_light and has_delta_lights(program) and has_chains(program)):
        return ()
    if integrator.splats:
        return (_SEEN_IN_MIRRORS,)
    return (_SOME if integrator.aims_at_lamps else _NONE,)
