"""Outputs: picture formats, tone mapping, and files that are written whole or not at all."""

from alight.outputs.image import FORMATS, check_writable, read_image, write_image
from alight.outputs.tone_mapping import TONE_MAPS

__all__ = ["FORMATS", "TONE_MAPS", "check_writable", "read_image", "write_image"]
