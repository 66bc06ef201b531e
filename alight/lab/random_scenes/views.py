"""How a scene is looked at: camera, film, sampler and integrator, each of any registered model."""

from __future__ import annotations

import math
from typing import Any

from alight.core.registry import Models as Registry
from alight.core.spec import Integrator, Sampler
from alight.integrators.options import LightSampling, PathTracing
from alight.lab.random_scenes.chance import Chance
from alight.lab.random_scenes.descriptions import any_model, of_model, varied
from alight.scene.description import FilmSettings, Node
from alight.scene.transform import look_at

SMALLEST, LARGEST = 32, 256
#: How much more often a model is drawn that follows light in all ways; a quarter of it for one that
#: also looks for media where there are none.
PATH_TRACERS = 8
#: Scenes that need this many edges show little by direct light.
INDIRECT = 4

Point = tuple[float, float, float]


def any_film(chance: Chance, size: tuple[int, int] | None) -> FilmSettings:
    """A film of a size of its own, or of the requested one."""
    width = round(chance.scaled(SMALLEST, LARGEST))
    height = round(width * chance.scaled(0.5, 2.0))
    drawn = (width, min(max(height, SMALLEST), LARGEST))
    # A wide filter blurs everything: these are for pictures, not for the edges of ranges.
    spec = any_model(chance, "filters")
    changes = {name: min(value, 2.0) for name, value in spec if name in ("radius", "stddev")}
    return FilmSettings(size=size or drawn, filter=spec.replaced(**changes))


def any_view(
    chance: Chance, origin: Point, target: Point, half: float, *, indoors: bool = False
) -> Node:
    """A camera that sees what lies around a point.

    Parameters
    ----------
    chance : Chance
    origin, target : (3,) float, metres
        Its position, and what it looks at.
    half : float, metres
        What lies nearer to the target than this is in the picture.
    indoors : bool, default False
        Whether rays must start at the origin, since there is a wall behind it.
    """
    modules = list(Registry("cameras").values())
    if indoors:
        modules = [module for module in modules if module.PERSPECTIVE]
    spec = of_model(chance, chance.choose(modules))
    distance = math.dist(origin, target)
    changes: dict[str, Any] = {"shutter": (0.0, chance.choose((0.0, 0.3, 1.0, 1.0)))}
    if "fov" in dict(spec):
        fov = 2.0 * math.degrees(math.atan(half / distance))
        changes["fov"] = min(max(float(f"{fov:.4g}"), 2.0), 110.0)
        changes["fov_axis"] = chance.choose(("smaller", "smaller", "smaller", "x", "y"))
    if "height" in dict(spec):
        changes["height"] = 2.0 * half
    if "focus_distance" in dict(spec):
        changes["focus_distance"] = float(f"{distance * chance.scaled(0.8, 1.25):.4g}")
        sizes = (0.0, distance * chance.scaled(0.002, 0.04))
        changes["aperture_radius"] = float(f"{sizes[chance.happens(0.9)]:.4g}")
    return Node(camera=spec.replaced(**changes), transform=look_at(origin, target))


def any_sampler(chance: Chance) -> Sampler:
    """Any sampler."""
    spec = any_model(chance, "samplers")
    changes = {name: min(value, 16) for name, value in spec if name == "strata"}
    return spec.replaced(**changes)


def any_integrator(
    chance: Chance,
    *,
    media: bool,
    bodies: bool,
    spreads: bool,
    found_by_chance: bool,
    closed: bool,
    edges: tuple[int, int],
) -> Integrator:
    """An integrator that shows the scene.

    Parameters
    ----------
    chance : Chance
    media : bool
        Whether there are media to be seen.
    bodies : bool
        Whether there are bodies that scatter light inside.
    spreads : bool
        Whether materials disperse light.
    found_by_chance : bool
        Whether paths meet enough of the light without looking for it.
    closed : bool
        Whether no light leaves the scene.
    edges : (int, int)
        Between which limits the length of the longest paths is; more where there is glass.
    """
    modules = [
        module
        for module in Registry("integrators").values()
        for _ in range(_weight(module.EXAMPLES[0], media))
        if _shows(module.EXAMPLES[0], media, found_by_chance, edges[0])
        and (module.EXAMPLES[0].walks_inside or not bodies)
        and (module.EXAMPLES[0].sees_dispersion or not spreads)
    ]
    module = chance.choose(modules)
    spec = varied(chance, chance.choose(module.EXAMPLES), keep=("hide_emitters",), share=0.3)
    fields = dict(spec)
    changes: dict[str, Any] = {}
    if "light_sampling" in fields:
        ways = ("mis", "mis", "mis", "emitter", "bsdf") if found_by_chance else ("mis",)
        changes["light_sampling"] = chance.choose(ways)
    if "hide_emitters" in fields:
        changes["hide_emitters"] = chance.happens(0.05)
    if "max_depth" in fields:
        changes["max_depth"] = chance.whole(*edges)
        if "rr_depth" in fields and not closed and chance.happens(0.1):
            changes |= {"max_depth": None, "russian_roulette": "throughput"}
    if "rr_depth" in fields:
        changes["rr_depth"] = chance.whole(1, 8)
    if "distance" in fields and (closed or fields["distance"] is not None):
        changes["distance"] = chance.scaled(0.3, 2.0)
    return spec.replaced(**changes)


def _shows(spec: Integrator, media: bool, found_by_chance: bool, fewest: int) -> bool:
    if spec.splats:
        # It does not show what is in mirrors and glass.
        return False
    if not spec.needs_light:
        return True
    # Without a length to choose, paths may be short ones: direct light only.
    if fewest >= INDIRECT and "max_depth" not in dict(spec):
        return False
    return (spec.sees_media or not media) and (found_by_chance or isinstance(spec, LightSampling))


def _weight(spec: Integrator, media: bool) -> int:
    if not isinstance(spec, PathTracing):
        return 1
    return PATH_TRACERS if media or not spec.sees_media else PATH_TRACERS // 4
