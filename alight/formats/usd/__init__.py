"""Scenes of OpenUSD (.usd, .usda, .usdc, .usdz), read by Pixar's `usd-core`.

A stage becomes plain data of the native format, so that everything that works on native scenes
works on these. What is covered is listed in docs/usd.md.

Source: Pixar, OpenUSD documentation (openusd.org): UsdGeom, UsdShade, UsdLux, and the
specification of UsdPreviewSurface, version 2.6.
"""
