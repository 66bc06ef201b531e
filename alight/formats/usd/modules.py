"""The modules of `usd-core` that are used; they come without types."""

from __future__ import annotations

from importlib import import_module
from typing import Any

Ar: Any = import_module("pxr.Ar")
Sdf: Any = import_module("pxr.Sdf")
Tf: Any = import_module("pxr.Tf")
Usd: Any = import_module("pxr.Usd")
UsdGeom: Any = import_module("pxr.UsdGeom")
UsdLux: Any = import_module("pxr.UsdLux")
UsdShade: Any = import_module("pxr.UsdShade")
UsdSkel: Any = import_module("pxr.UsdSkel")
UsdUtils: Any = import_module("pxr.UsdUtils")
