"""Scene files in glTF 2.0 (.gltf and .glb). What is covered is listed in docs/formats.md.

Source: Khronos Group, glTF 2.0 specification (https://registry.khronos.org/glTF/specs/2.0).
"""

from alight.formats.gltf.scene import parse

__all__ = ["parse"]
