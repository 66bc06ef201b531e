"""Outputs: picture formats, tone mapping, and files that are written whole or not at all."""

from alight.outputs.image import FORMATS, check_writable, read_image, write_image

__all__ = ["FORMATS", "check_writable", "read_image", "write_image"]
