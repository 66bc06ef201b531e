"""More scenes for `mitsuba_scenes`: metals and glasses, rough in three degrees, and smooth ones."""

from typing import Any

from mitsuba_parts import SceneDict, ball, ceiling_light, rgb, room, scene

ALPHAS = (0.06, 0.2, 0.6)
# Indices of refraction by the three primaries: real and imaginary part.
METALS = {
    "gold": ((0.1430, 0.3753, 1.4420), (3.9830, 2.3856, 1.6034)),
    "copper": ((0.2010, 0.9237, 1.1022), (3.9133, 2.4530, 2.1421)),
    "silver": ((0.1553, 0.1167, 0.1384), (4.8284, 3.1222, 2.1469)),
    "tungsten": ((4.3708, 3.3002, 2.9984), (3.5006, 2.6049, 2.2732)),
    "aluminium": ((1.6575, 0.8804, 0.5212), (9.2238, 6.2695, 4.8370)),
}


def balls(mi: Any, max_depth: int, rows: list[list[SceneDict]]) -> SceneDict:
    """Hang three rows of three balls into the room, under a large light."""
    contents = room(mi, max_depth) | {"light": ceiling_light(mi, 0.9, 2.0, 1.9, 1.7)}
    for row, bsdfs in enumerate(rows):
        for i, bsdf in enumerate(bsdfs):
            centre = (0.6 * i - 0.6, 0.6 - 0.6 * row, 0.0)
            contents[f"ball{row}{i}"] = ball(mi, centre, 0.27, bsdf)
    return contents


@scene
def rough_metals(mi: Any) -> SceneDict:
    """Three roughnesses by GGX, as many by Beckmann; two brushed metals and a smooth one."""

    def metal(name: str, kind: str = "roughconductor", **options: Any) -> SceneDict:
        eta, k = METALS[name]
        return {"type": kind, "eta": rgb(*eta), "k": rgb(*k)} | options

    brushed = metal("silver", distribution="ggx", alpha_u=0.06, alpha_v=0.4)
    across = {"alpha_u": 0.5, "alpha_v": 0.1, "specular_reflectance": rgb(0.9, 1.0, 0.6)}
    tinted = metal("aluminium", "conductor", specular_reflectance=rgb(0.6, 0.8, 1.0))
    rows = [
        [metal("gold", distribution="ggx", alpha=alpha) for alpha in ALPHAS],
        [metal("copper", distribution="beckmann", alpha=alpha) for alpha in ALPHAS],
        [brushed, metal("tungsten", distribution="beckmann", **across), tinted],
    ]
    return balls(mi, 8, rows)


@scene
def rough_glasses(mi: Any) -> SceneDict:
    """Three roughnesses by GGX, as many by Beckmann; an anisotropic one, a bubble, clear glass."""

    def glass(kind: str, **options: Any) -> SceneDict:
        return {"type": kind, "int_ior": 1.5, "ext_ior": 1.0} | options

    tints = {
        "specular_reflectance": rgb(1.0, 0.7, 0.4),
        "specular_transmittance": rgb(0.7, 0.8, 1.0),
    }
    ground = glass("roughdielectric", distribution="ggx", alpha_u=0.1, alpha_v=0.5, **tints)
    rows = [
        [glass("roughdielectric", distribution=name, alpha=alpha) for alpha in ALPHAS]
        for name in ("ggx", "beckmann")
    ]
    rows.append([ground, glass("thindielectric", **tints), glass("dielectric", **tints)])
    return balls(mi, 12, rows)
