r"""Where the camera is, and how it moves.

The pivot is a point of the scene: orbits turn about it, dollies go towards it, and moves across the
view are such that it stays under the pointer. With p the pivot, R a rotation and M the camera's
matrix, an orbit is :math:`M' = T(p)\, R\, T(-p)\, M`: first about the vertical, then about the
camera's own horizontal axis, up to the poles and no further.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.cameras.model import CAMERAS
from alight.core.spec import Camera
from alight.scene import Node
from alight.scene.flatten import PlacedCamera
from alight.scene.transform import is_singular, matrix, rotate, translate
from alight.view import protocol

Array = NDArray[np.float64]

#: Radians that a drag over the height of the picture turns.
TURN = math.pi

#: What a camera calls the distance of the plane that is sharp.
FOCUS = "focus_distance"

#: Closest to a pole, and narrowest and widest field of view, in degrees.
POLE, NARROWEST, WIDEST = 0.5, 0.5, 170.0


@dataclass(frozen=True)
class Pose:
    """A camera in its place, and the point that it turns about.

    Parameters
    ----------
    camera : Camera
    to_world : (4, 4) float64
    pivot : (3,) float64, metres
    up : (3,) float64
        Unit vector: the vertical about which orbits turn.
    """

    camera: Camera
    to_world: Array
    pivot: Array
    up: Array

    @classmethod
    def of(cls, placed: PlacedCamera) -> Pose:
        """Start from a camera of the scene, as it is when its shutter opens.

        The pivot is the point of the view's axis that is nearest to the origin of the world, or,
        where that lies behind, a metre ahead.
        """
        to_world = placed.to_world
        if placed.motion is not None:
            to_world = placed.motion.at(0.0) @ to_world
        own = to_world[:3, 1]
        # The axis of the world that is nearest to the camera's own vertical.
        up = np.zeros(3)
        axis = int(np.argmax(np.abs(own)))
        up[axis] = math.copysign(1.0, own[axis])
        origin, ahead = to_world[:3, 3], -_unit(to_world[:3, 2])
        distance = float(-origin @ ahead)
        return cls(
            placed.camera, to_world, origin + ahead * (distance if distance > 0.0 else 1.0), up
        )

    @property
    def node(self) -> Node:
        """The camera as a scene has it."""
        return Node(transform=matrix(self.to_world), camera=self.camera)

    @property
    def sharp(self) -> Pose:
        """The same without the blur of a lens."""
        return self._with(aperture_radius=0.0)

    @property
    def has_focus(self) -> bool:
        """Whether the camera has a plane that is sharp."""
        return FOCUS in dict(self.camera)

    def depth_of(self, point: Array) -> float:
        """Distance of a point along the view, in the camera's own space, as its focus is."""
        return -float((np.linalg.inv(self.to_world) @ [*point, 1.0])[2])

    def _with(self, **values: Any) -> Pose:
        """Change those values that the camera has."""
        known = {name: value for name, value in values.items() if name in dict(self.camera)}
        return replace(self, camera=self.camera.replaced(**known)) if known else self

    @property
    def origin(self) -> Array:
        """Where it stands."""
        return self.to_world[:3, 3]

    @property
    def distance(self) -> float:
        """From the camera to the pivot, along the view; never 0."""
        along = float(np.dot(self.pivot - self.origin, -_unit(self.to_world[:3, 2])))
        return max(along, 1e-6 * float(np.linalg.norm(self.origin)) + 1e-9)

    def moved(self, event: protocol.Event, size: tuple[int, int]) -> Pose:
        """Move as the browser asks; `size` is that of the film, in pixels."""
        match event:
            case protocol.Orbit(x, y):
                return self._orbit(x, y)
            case protocol.Pan(x, y):
                height = self._height(size)
                return self._shifted(-x * height, y * height, 0.0)
            case protocol.Fly(right, up, ahead):
                far = self.distance
                return self._shifted(right * far, up * far, ahead * far)
            case protocol.Dolly(by):
                return self._dolly(min(max(by, -3.0), 3.0))
            case protocol.Roll(by):
                back = self.to_world[:3, 2]
                return self._turned(rotate(tuple(back), -math.degrees(by)).matrix, self.origin)
            case protocol.Widen(by):
                return self._widened(math.exp(min(max(by, -3.0), 3.0)))
        raise ValueError(f"{event} moves nothing")

    @property
    def is_usable(self) -> bool:
        """Whether the numbers are still such that a picture can be taken."""
        return bool(np.isfinite(self.pivot).all()) and not is_singular(self.to_world)

    def _orbit(self, x: float, y: float) -> Pose:
        turned = self._turned(rotate(tuple(self.up), -math.degrees(TURN * x)).matrix, self.pivot)
        # Beyond a pole left and right would change places.
        back = _unit(turned.to_world[:3, 2])
        height = math.degrees(math.asin(min(max(float(back @ self.up), -1.0), 1.0)))
        wanted = min(max(height + math.degrees(TURN * y), POLE - 90.0), 90.0 - POLE)
        right = np.cross(self.up, back)
        if np.linalg.norm(right) < 1e-9:
            right = turned.to_world[:3, 0]
        tilt = rotate(tuple(_unit(right)), height - wanted).matrix
        return turned._turned(tilt, self.pivot)

    def _turned(self, rotation: Array, about: Array) -> Pose:
        there, back = translate(*about).matrix, translate(*-about).matrix
        return replace(self, to_world=there @ rotation @ back @ self.to_world)

    def _shifted(self, right: float, up: float, ahead: float) -> Pose:
        """Move camera and pivot together, in metres along the camera's axes."""
        u, v, w = (_unit(self.to_world[:3, axis]) for axis in range(3))
        step = right * u + up * v - ahead * w
        to_world = self.to_world.copy()
        to_world[:3, 3] += step
        return replace(self, to_world=to_world, pivot=self.pivot + step)

    def _dolly(self, by: float) -> Pose:
        """Make the distance to the pivot exp(-by) times as long."""
        if not CAMERAS[self.camera.type_name()].PERSPECTIVE:
            return self._widened(math.exp(-by))
        to_world = self.to_world.copy()
        to_world[:3, 3] = self.pivot + (self.origin - self.pivot) * math.exp(-by)
        return replace(self, to_world=to_world)

    def _widened(self, factor: float) -> Pose:
        values: dict[str, Any] = dict(self.camera)
        if "fov" in values:
            fov = min(max(values["fov"] * factor, NARROWEST), WIDEST)
            return replace(self, camera=self.camera.replaced(fov=fov))
        if "height" in values:
            return replace(self, camera=self.camera.replaced(height=values["height"] * factor))
        return self

    def _height(self, size: tuple[int, int]) -> float:
        """Metres that the picture is high at the pivot."""
        model = CAMERAS[self.camera.type_name()]
        _, half = model.half_extents(self.camera, *size)
        scale = float(np.linalg.norm(self.to_world[:3, 1]))
        if not model.PERSPECTIVE:
            return 2.0 * half * scale
        return 2.0 * half * self.distance * scale / float(np.linalg.norm(self.to_world[:3, 2]))


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)
