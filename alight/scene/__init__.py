"""The scene: description, scene graph and manager, file formats, checks.

The usual names are exported here::

    from alight.scene import Scene, Node, load, look_at, translate
"""

from alight.core.errors import SceneError
from alight.scene.description import FilmSettings, Node, Scene
from alight.scene.files import builtin_names, dumps, load, loads, save
from alight.scene.flatten import FlatScene, content_hash, flatten
from alight.scene.keyframes import keyframes
from alight.scene.manager import SceneManager
from alight.scene.transform import Transform, look_at, matrix, rotate, scale, translate

__all__ = [
    "FilmSettings",
    "FlatScene",
    "Node",
    "Scene",
    "SceneError",
    "SceneManager",
    "Transform",
    "builtin_names",
    "content_hash",
    "dumps",
    "flatten",
    "keyframes",
    "load",
    "loads",
    "look_at",
    "matrix",
    "rotate",
    "save",
    "scale",
    "translate",
]
