"""Lights of UsdLux -> lights of the native format.

A light's intensity is a radiance in nit, taken as W/(m^2 sr): radiance = color * intensity *
2^exposure, divided by the area where it is normalised. Lights shine along their -z.

Source: Pixar, OpenUSD documentation, UsdLux: "LightAPI", "ShapingAPI", "DomeLight".
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from alight.formats.materials.textures import DARK, multiplied
from alight.formats.reading.reach import OutOfReachError
from alight.formats.scenes.lamps import (
    NARROWEST_DISK,
    WIDEST_DISK,
    area_across,
    area_of_ball,
    area_of_mantle,
    far_disk,
    parallel,
    point,
    spot,
    turned,
)
from alight.formats.usd.light_controls import say_what_is_unphysical
from alight.formats.usd.modules import UsdGeom, UsdLux
from alight.formats.usd.stage import Stage, meters_per_unit
from alight.formats.usd.textures import picture_of
from alight.meshes.polygons import Triangles

Data = dict[str, Any]
_BLACK: Data = {"type": "diffuse", "reflectance": 0.0}
#: Axes that are off a right angle by less, and lengths off 1, are rounded.
_ROUNDING = 5e-5
#: From our light along +z to one along -z.
_TURNED: Data = {"rotate": {"axis": "y", "angle": 180.0}}
#: How a light and the glow of its mesh's material combine by default.
_TINTED = UsdLux.Tokens.materialGlowTintsLight


@dataclass(frozen=True)
class Placed:
    """A light.

    Attributes
    ----------
    node : dict
        Nodes for the prim's place.
    dome : dict or None
        Instead of it, the node in the world of what is around the scene.
    radius : float
        Of the ball about its place that shines outwards only, in units of the stage; 0 for none.
    """

    node: Data
    dome: Data | None = None
    radius: float = 0.0


def is_light(prim: Any) -> bool:
    """Whether a prim is a light."""
    return prim.HasAPI(UsdLux.LightAPI) and prim.GetTypeName() in _READERS


def read_light(stage: Stage, prim: Any, world: np.ndarray) -> Placed:
    """Read a light.

    Parameters
    ----------
    stage : Stage
    prim : Usd.Prim
    world : (4, 4) float64
        From the prim to our world, for column vectors.
    """
    say_what_is_unphysical(stage, prim)
    return _READERS[prim.GetTypeName()](stage, prim, world)


def glow_of(stage: Stage, prim: Any, own: Any, triangles: Triangles, world: np.ndarray) -> Any:
    """What a mesh emits, color or texture, W/(m^2 sr): as a light (MeshLightAPI), or by itself.

    Parameters
    ----------
    stage : Stage
    prim : Usd.Prim
        A mesh.
    own : color, texture or None
        What its material emits.
    triangles : Triangles
        All of the mesh: normalised lights are divided by its area.
    world : (4, 4) float64
    """
    if not prim.HasAPI(UsdLux.MeshLightAPI):
        return own
    corners = (triangles.vertices.astype(np.float64) @ world[:3, :3].T)[triangles.faces]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * float(np.linalg.norm(sides, axis=1).sum())
    radiance = _radiance(stage, prim) * _normalisation(stage, prim, area)
    _say_shaping(stage, prim)
    say_what_is_unphysical(stage, prim)
    mode = stage.value(UsdLux.LightAPI(prim).GetMaterialSyncModeAttr(), _TINTED)
    if mode == UsdLux.Tokens.noMaterialResponse:
        text = "light reflected by a mesh that shines stays, though it asks for no response"
        stage.report.approximate(f"{prim.GetPath()}: {text}")
    if own is None or mode == UsdLux.Tokens.noMaterialResponse:
        return radiance.tolist()
    if mode == UsdLux.Tokens.independent:
        if isinstance(own, list):
            return [a + b for a, b in zip(radiance.tolist(), own, strict=True)]
        text = "the glow of its material, a texture, is left out beside its light"
        stage.report.approximate(f"{prim.GetPath()}: {text}")
        return radiance.tolist()
    text = "the light of a mesh is multiplied by the glow of its material, seen directly, too"
    stage.report.approximate(f"{prim.GetPath()}: {text}")
    if isinstance(own, list):
        return [a * b for a, b in zip(radiance.tolist(), own, strict=True)]
    return multiplied(radiance.tolist(), own)


def _radiance(stage: Stage, prim: Any) -> np.ndarray:
    """color * intensity * 2^exposure, before any normalisation; (3,) float64, finite."""
    light = UsdLux.LightAPI(prim)
    color = np.array(stage.value(light.GetColorAttr(), (1.0, 1.0, 1.0)), np.float64)
    if stage.value(light.GetEnableColorTemperatureAttr(), False):
        kelvin = float(stage.value(light.GetColorTemperatureAttr(), 6500.0))
        color = color * np.array(UsdLux.BlackbodyTemperatureAsRgb(kelvin))
    intensity = float(stage.value(light.GetIntensityAttr(), 1.0))
    exposure = float(stage.value(light.GetExposureAttr(), 0.0))
    with np.errstate(over="ignore", invalid="ignore"):
        result = color * intensity * np.exp2(exposure)
    if not np.isfinite(result).all():
        text = f"color * intensity * 2^{exposure:g} must be finite, got {result.tolist()}"
        stage.problem(prim, text)
        return np.zeros(3)
    if (result < 0.0).any():
        stage.report.approximate(f"{prim.GetPath()}: a light cannot take light away; cut to 0")
    return np.maximum(result, 0.0)


def _is_normalised(stage: Stage, prim: Any) -> bool:
    return bool(stage.value(UsdLux.LightAPI(prim).GetNormalizeAttr(), False))


def _normalisation(stage: Stage, prim: Any, area: float) -> float:
    """What the radiance of a light of some area, m^2, is multiplied by.

    Normalised lights are divided by their area "in world space", whose unit is that of the stage:
    in one of centimetres a square metre counts as 10 000, as in OpenUSD's own renderer.
    """
    if not _is_normalised(stage, prim):
        return 1.0
    return (meters_per_unit(stage) or 1.0) ** 2 / max(area, 1e-30)


def _keeps_angles(linear: np.ndarray) -> bool:
    """Whether a matrix (3, 3) turns, mirrors and scales alike along all axes, and no more."""
    squared = linear.T @ linear
    return np.allclose(squared, np.eye(3) * squared[0, 0], atol=_ROUNDING * squared[0, 0])


def _area_light(
    stage: Stage, prim: Any, shape: Data, steps: list[Data], area: float, world: np.ndarray
) -> Placed:
    radiance = _radiance(stage, prim) * _normalisation(stage, prim, area)
    _say_shaping(stage, prim)
    node = {
        "shape": shape,
        "bsdf": _BLACK,
        "light": {"type": "area", "radiance": radiance.tolist()},
        "transform": steps,
    }
    return Placed(node)


def _say_shaping(stage: Stage, prim: Any) -> None:
    """Say that a surface shines all around, whatever shapes its light."""
    shaping = UsdLux.ShapingAPI(prim)
    cone = float(stage.value(shaping.GetShapingConeAngleAttr(), 90.0))
    if cone < 90.0 or stage.value(shaping.GetShapingFocusAttr(), 0.0) > 0.0:
        stage.report.approximate(f"{prim.GetPath()}: its cone is left out, it shines all around")
    _say_profile(stage, prim)


def _say_profile(stage: Stage, prim: Any) -> None:
    if stage.value(UsdLux.ShapingAPI(prim).GetShapingIesFileAttr()) is not None:
        stage.report.approximate(f"{prim.GetPath()}: its IES profile is left out")


def _sphere(stage: Stage, prim: Any, world: np.ndarray) -> Placed:
    light = UsdLux.SphereLight(prim)
    radius = float(stage.value(light.GetRadiusAttr(), 0.5))
    area = area_of_ball(world, max(radius, 1e-6))
    cone = float(stage.value(UsdLux.ShapingAPI(prim).GetShapingConeAngleAttr(), 90.0))
    is_point = bool(stage.value(light.GetTreatAsPointAttr(), False)) or radius <= 0.0
    if not is_point and cone >= 90.0:
        placed = _area_light(stage, prim, {"type": "sphere", "radius": radius}, [], area, world)
        return replace(placed, radius=radius)
    # Intensity of a sphere seen from far away: radiance times its disk, a quarter of its area.
    intensity = _radiance(stage, prim) * (0.25 * area * _normalisation(stage, prim, area))
    if cone >= 90.0:
        _say_shaping(stage, prim)
        return Placed({"light": point(intensity.tolist())})
    stage.report.approximate(f"{prim.GetPath()}: a sphere with a cone became a spot")
    _say_profile(stage, prim)
    if stage.value(UsdLux.ShapingAPI(prim).GetShapingFocusAttr(), 0.0) > 0.0:
        stage.report.approximate(f"{prim.GetPath()}: its cone is as bright at the edge (focus)")
    softness = float(stage.value(UsdLux.ShapingAPI(prim).GetShapingConeSoftnessAttr(), 0.0))
    cone = max(cone, 0.001)
    beam = cone * (1.0 - min(max(softness, 0.0), 1.0))
    return Placed(turned(spot(intensity.tolist(), cone, beam), "y"))


def _rectangle(stage: Stage, prim: Any, world: np.ndarray) -> Placed:
    light = UsdLux.RectLight(prim)
    width = float(stage.value(light.GetWidthAttr(), 1.0))
    height = float(stage.value(light.GetHeightAttr(), 1.0))
    if stage.value(light.GetTextureFileAttr()) is not None:
        stage.report.approximate(f"{prim.GetPath()}: its picture is left out")
    steps = [{"scale": [0.5 * width, 0.5 * height, 1.0]}, _TURNED]
    area = width * height * area_across(world)
    return _area_light(stage, prim, {"type": "rectangle"}, steps, area, world)


def _disk(stage: Stage, prim: Any, world: np.ndarray) -> Placed:
    radius = float(stage.value(UsdLux.DiskLight(prim).GetRadiusAttr(), 0.5))
    steps = [{"scale": [radius, radius, 1.0]}, _TURNED]
    area = math.pi * radius * radius * area_across(world)
    return _area_light(stage, prim, {"type": "disk"}, steps, area, world)


def _cylinder(stage: Stage, prim: Any, world: np.ndarray) -> Placed:
    light = UsdLux.CylinderLight(prim)
    radius = float(stage.value(light.GetRadiusAttr(), 0.5))
    half = 0.5 * float(stage.value(light.GetLengthAttr(), 1.0))
    shape = {"type": "cylinder", "p0": [-half, 0, 0], "p1": [half, 0, 0], "radius": radius}
    # Across, across and along, in the order that the mantle is measured in.
    area = area_of_mantle(world[:3, [1, 2, 0]], radius, 2.0 * half)
    return _area_light(stage, prim, shape, [], area, world)


def _distant(stage: Stage, prim: Any, world: np.ndarray) -> Placed:
    angle = float(stage.value(UsdLux.DistantLight(prim).GetAngleAttr(), 0.53))
    irradiance = _radiance(stage, prim)
    if not _is_normalised(stage, prim) and angle > 0.0:
        # Radiance of a disk of this opening angle.
        irradiance = irradiance * math.pi * math.sin(math.radians(0.5 * min(angle, 180.0))) ** 2
    wide = f"{prim.GetPath()}: a distant light, {angle:g} degrees wide"
    # What surrounds a scene is in no prototype, and is only turned.
    if angle >= NARROWEST_DISK and _keeps_angles(world[:3, :3]) and not prim.IsInPrototype():
        if angle > WIDEST_DISK:
            stage.report.approximate(f"{wide}, became a disk {WIDEST_DISK:g} degrees wide")
        return Placed(far_disk(irradiance.tolist(), min(angle, WIDEST_DISK)))
    if angle > 0.0:
        stage.report.approximate(f"{wide}, became parallel rays with hard shadows")
    return Placed(turned(parallel(irradiance.tolist()), "y"))


def _dome(stage: Stage, prim: Any, world: np.ndarray) -> Placed:
    radiance = _radiance(stage, prim).tolist()
    asset = stage.value(UsdLux.DomeLight(prim).GetTextureFileAttr())
    if asset is None or not asset.path:
        return _around({"type": "constant", "radiance": radiance})
    layout = stage.value(UsdLux.DomeLight(prim).GetTextureFormatAttr(), "automatic")
    if layout not in ("automatic", "latlong"):
        text = f"its picture of the format {layout} is taken for one of latitude and longitude"
        stage.report.approximate(f"{prim.GetPath()}: {text}")
    try:
        picture = picture_of(stage, asset)
    except OutOfReachError as error:
        stage.report.lacks_at(stage.name, str(prim.GetPath()), error, DARK)
        return _around({"type": "constant", "radiance": [0.5 * c for c in radiance]})
    found = {"file": picture} if isinstance(picture, str) else {"pixels": picture}
    data: Data = {"type": "environment", **found, "scale": radiance}
    linear = _pole(stage, prim, world)
    axes = linear / np.maximum(np.linalg.norm(linear, axis=0), 1e-30)
    if not _keeps_angles(linear):
        text = "is stretched: only its turn about the vertical is taken"
        stage.report.approximate(f"{prim.GetPath()}: {text}")
    elif axes[1, 1] < 1.0 - 1e-9 or np.linalg.det(axes) < 0.0:
        if abs(axes[1, 1]) < 0.5:
            text = "its pole is level, as UsdLux has it where orientToStageUpAxis is missing"
            stage.report.approximate(f"{prim.GetPath()}: {text}")
        matrix = np.eye(4)
        matrix[:3, :3] = axes
        return _around(data, transform={"matrix": matrix.tolist()})
    angle = math.degrees(math.atan2(axes[0, 2], axes[2, 2]))
    return _around(data | ({"rotate": angle} if abs(angle) > 1e-9 else {}))


def _around(light: Data, **more: Data) -> Placed:
    return Placed({}, {"light": light, **more})


def _pole(stage: Stage, prim: Any, world: np.ndarray) -> np.ndarray:
    """The axes of a dome's picture in the world, (3, 3), its third column towards the middle.

    The pole is +y of the prim; of a `DomeLight_1` the axis that its poleAxis names, the one that is
    up on the stage by default, to which +y is turned about x.
    """
    linear = world[:3, :3]
    if prim.GetTypeName() != "DomeLight_1":
        return linear
    pole = stage.value(UsdLux.DomeLight_1(prim).GetPoleAxisAttr(), UsdLux.Tokens.scene)
    if pole == UsdLux.Tokens.scene:
        pole = UsdGeom.GetStageUpAxis(stage.stage)
    # A quarter turn about x takes y to z, and z to -y.
    return linear[:, [0, 2, 1]] * [1.0, 1.0, -1.0] if pole == UsdGeom.Tokens.z else linear


_READERS = {
    "SphereLight": _sphere,
    "RectLight": _rectangle,
    "DiskLight": _disk,
    "CylinderLight": _cylinder,
    "DistantLight": _distant,
    "DomeLight": _dome,
    "DomeLight_1": _dome,
}
