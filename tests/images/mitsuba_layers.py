"""More scenes for `mitsuba_scenes`: coated plastics, and materials made of others."""

from typing import Any

from mitsuba_parts import SceneDict, ball, ceiling_light, diffuse, rgb, room, scene


@scene
def plastics(mi: Any) -> SceneDict:
    """Smooth plastic and three rough ones, above with the linear base, below with the other."""

    def coated(nonlinear: bool, **options: Any) -> SceneDict:
        colour = rgb(0.8, 0.4, 0.15)
        return {"type": "plastic", "diffuse_reflectance": colour, "nonlinear": nonlinear} | options

    rough = {"type": "roughplastic", "distribution": "ggx", "int_ior": 1.6, "ext_ior": 1.0}
    kinds: list[SceneDict] = [
        {"int_ior": 1.8, "ext_ior": 1.0, "specular_reflectance": rgb(0.9, 0.8, 1.0)},
        rough | {"alpha": 0.08},
        rough | {"alpha": 0.25, "distribution": "beckmann", "specular_reflectance": rgb(0.7)},
        rough | {"alpha": 0.6},
    ]
    contents = room(mi) | {"light": ceiling_light(mi, 0.6, 4, 4, 4)}
    for row, nonlinear in enumerate((False, True)):
        for i, options in enumerate(kinds):
            centre = (0.48 * i - 0.72, 0.25 - 0.6 * row, 0.4 * row - 0.2)
            contents[f"ball{row}{i}"] = ball(mi, centre, 0.23, coated(nonlinear, **options))
    return contents


@scene
def layers(mi: Any) -> SceneDict:
    """Blends and masks, in each other, with textures and constants, one- and two-sided."""
    place = mi.ScalarTransform4f
    # Where a number is wanted, Mitsuba 3.9 swaps the two colours of its checkerboard.
    squares = {
        "type": "checkerboard",
        "color0": rgb(0.9),
        "color1": rgb(0.1),
        "to_uv": place().scale([2, 2, 1]),
    }
    # All parts of blends are smooth: Mitsuba 3.9 adds the probability of a delta lobe to densities.
    gold = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.3}
    gold |= {"eta": rgb(0.143, 0.375, 1.442), "k": rgb(3.983, 2.386, 1.603)}
    satin = {"type": "roughplastic", "distribution": "ggx", "alpha": 0.2}
    satin["diffuse_reflectance"] = rgb(0.1, 0.3, 0.6)
    gilded = {"type": "blendbsdf", "weight": 0.3, "a": diffuse(0.7, 0.3, 0.2), "b": gold}
    both = {"type": "twosided", "bsdf": satin | {"nonlinear": True}}
    fence = {"type": "mask", "opacity": squares, "bsdf": both}
    patches = {"type": "blendbsdf", "weight": squares, "a": gilded, "b": satin}
    veil = {"type": "mask", "opacity": 0.6, "bsdf": patches}
    cloth = {"type": "blendbsdf", "weight": 0.5, "a": diffuse(0.2, 0.7, 0.2), "b": satin}
    sheet = {"type": "twosided", "bsdf": cloth}
    left = place().translate([-0.55, 0.2, 0.3]).rotate([0, 1, 0], 40).scale(0.35)
    right = place().translate([0.6, -0.55, 0.3]).rotate([0, 1, 0], 160).scale(0.3)
    return room(mi) | {
        "light": ceiling_light(mi, 0.6, 4, 4, 4),
        "gilded": ball(mi, (-0.55, -0.65, 0.1), 0.35, gilded),
        "veil": ball(mi, (0.2, -0.15, -0.3), 0.4, veil),
        "fence": {"type": "rectangle", "to_world": left, "bsdf": fence},
        "sheet": {"type": "rectangle", "to_world": right, "bsdf": sheet},
    }
