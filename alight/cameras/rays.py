"""The camera of a program: what the main loop calls, and the change of basis for the host."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alight.cameras.basis import project_points, unproject_points
from alight.cameras.model import CAMERAS
from alight.core.motion import matrix_at, placed, turned
from alight.core.vec import normalize
from lanewise.jit import kernel, specialised
from lanewise.simd import lanes_u32

if TYPE_CHECKING:
    from alight.core.spec import Camera


@specialised
def generate_ray(program):
    """``generate_ray(scene, film_x, film_y, u_lens)``: origin and unit direction of a ray.

    Film coordinates are pixels of the *full* film (x right, y down, the first pixel's centre at
    (0.5, 0.5)), so that a crop window is a cut-out of the whole picture. `u_lens` is a pair in
    [0, 1)^2.
    """
    generate = CAMERAS[program.camera].generate_ray

    @kernel
    def generate_ray(scene, film_x, film_y, u_lens):
        return generate(scene.camera, film_x, film_y, u_lens)

    if "camera" not in program.motion:
        return generate_ray

    @kernel
    def generate_moving_ray(scene, film_x, film_y, u_lens):
        o, d = generate(scene.camera, film_x, film_y, u_lens)
        m = matrix_at(scene.motions, lanes_u32(scene.motions.camera[0] - 1), scene.time)
        return placed(m, o), normalize(turned(m, d))

    return generate_moving_ray


def sees_far(program) -> bool:
    """Whether the camera sees directions of its own from each point of its film."""
    return CAMERAS[program.camera].connect_far is not None


@specialised
def connect_camera(program):
    """``connect_camera(scene, p, u_lens)``: `alight.cameras.connection.Connection` of points."""
    connect = CAMERAS[program.camera].connect
    assert connect is not None

    @kernel
    def connect_camera(scene, p, u_lens):
        return connect(scene.camera, p, u_lens)

    return connect_camera


@specialised
def connect_far_camera(program):
    """``connect_far_camera(scene, d, u_lens)``: the same of what is infinitely far along d."""
    connect = CAMERAS[program.camera].connect_far
    assert connect is not None

    @kernel
    def connect_far_camera(scene, d, u_lens):
        return connect(scene.camera, d, u_lens)

    return connect_far_camera


def project(
    camera: Camera, to_world: ArrayLike, size: tuple[int, int], points: ArrayLike
) -> NDArray[np.float64]:
    """Where world points appear in the picture.

    Parameters
    ----------
    camera : Camera
    to_world : (4, 4) float
        Camera to world.
    size : (int, int)
        Width and height of the full film in pixels.
    points : (..., 3) float
        World space, metres.

    Returns
    -------
    (..., 3) float64
        x right, y down in pixels of the full film, and the depth: distance along the viewing axis
        in the camera's own space. x and y are NaN for points that a perspective camera has
        behind it.

    Notes
    -----
    A thin lens is taken at its centre: that is where points in focus appear.
    """
    model = CAMERAS[camera.type_name()]
    matrix = np.asarray(to_world, np.float64)
    extents = model.half_extents(camera, *size)
    return project_points(points, extents, size, matrix, model.PERSPECTIVE)


def unproject(
    camera: Camera, to_world: ArrayLike, size: tuple[int, int], raster: ArrayLike
) -> NDArray[np.float64]:
    """World points of film coordinates and depths: the inverse of `project`."""
    model = CAMERAS[camera.type_name()]
    matrix = np.asarray(to_world, np.float64)
    extents = model.half_extents(camera, *size)
    return unproject_points(raster, extents, size, matrix, model.PERSPECTIVE)
