"""Scene files of the pbrt renderer, versions 3 and 4.

A file becomes plain data of the native format, so that everything that works on native scenes works
on these. What is covered is listed in docs/pbrt.md.

Source: the documentation of the file formats (https://pbrt.org/fileformat-v4, fileformat-v3);
Pharr, Jakob and Humphreys, Physically Based Rendering, 4th edition (2023), whose program decides
what the documentation leaves open.
"""

from alight.formats.pbrt.scene import parse

__all__ = ["parse"]
