"""Scene files of the Mitsuba renderer, versions 0.6 and 3 (XML).

A file becomes plain data of the native format, so that everything that works on native scenes works
on these. What is covered is listed in docs/mitsuba.md.

Source: the documentation of Mitsuba 3 (https://mitsuba.readthedocs.io) and of Mitsuba 0.6; what
they leave open was found by experiment with Mitsuba 3.
"""

from alight.formats.mitsuba.scene import Parsed, parse

__all__ = ["Parsed", "parse"]
