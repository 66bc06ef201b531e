"""The scene: description, scene graph and manager, checks.

The usual names are exported here::

    from alight.scene import Scene, Node, look_at, translate
"""

from alight.core.errors import SceneError
from alight.scene.description import FilmSettings, Node, Scene
from alight.scene.flatten import FlatScene, flatten
from alight.scene.hashing import content_hash
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
    "content_hash",
    "flatten",
    "keyframes",
    "look_at",
    "matrix",
    "rotate",
    "scale",
    "translate",
]
