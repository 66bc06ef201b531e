"""Cameras of UsdGeom -> cameras of the native format."""

from __future__ import annotations

import math
from typing import Any

from alight.formats.scenes.cameras import Parallel, Perspective, angle_of
from alight.formats.usd.modules import UsdGeom
from alight.formats.usd.stage import Stage

Data = dict[str, Any]
#: Lenses and apertures are measured in tenths of the stage's unit.
_TENTH = 0.1


def read_camera(stage: Stage, prim: Any) -> tuple[Data, float]:
    """Read a camera.

    Returns
    -------
    dict
        Description of the native format, in units of the stage.
    float
        Width of its picture divided by the height.
    """
    camera = UsdGeom.Camera(prim)
    width = max(float(stage.value(camera.GetHorizontalApertureAttr(), 20.955)), 1e-6)
    height = max(float(stage.value(camera.GetVerticalApertureAttr(), 15.2908)), 1e-6)
    aspect = width / height
    for name in ("HorizontalApertureOffset", "VerticalApertureOffset"):
        if stage.value(getattr(camera, f"Get{name}Attr")(), 0.0):
            stage.report.approximate(f"{prim.GetPath()}: {name[0].lower()}{name[1:]} is left out")
    # Of OpenUSD since 24.11.
    exposed = getattr(camera, "ComputeLinearExposureScale", lambda time: 1.0)(stage.time)
    if exposed != 1.0 and exposed > 0.0:
        text = (
            f"its exposure is left out: show the picture with --exposure {math.log2(exposed):.3g}"
        )
        stage.report.approximate(f"{prim.GetPath()}: {text}")
    if stage.value(camera.GetProjectionAttr()) == UsdGeom.Tokens.orthographic:
        return Parallel(height * _TENTH).data(), aspect
    focal = max(float(stage.value(camera.GetFocalLengthAttr(), 50.0)), 1e-6)
    fov = angle_of(height, focal)
    stop = float(stage.value(camera.GetFStopAttr(), 0.0))
    distance = float(stage.value(camera.GetFocusDistanceAttr(), 0.0))
    if stop > 0.0 and distance > 0.0:
        radius = 0.5 * focal * _TENTH / stop
        return Perspective(fov, "y", radius, distance).data(), aspect
    return Perspective(fov).data(), aspect
