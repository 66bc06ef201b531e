"""When a sample sees the scene: each has one time, which all rays of its path keep.

It is a dimension of its own of the sampler, uniform between the opening (0) and the closing (1) of
the shutter, and a pure function of the sample, so that nothing has to be carried along.
"""

from __future__ import annotations

from collections import namedtuple

from alight.compiled.at_times import AtTimes, AtTimesInMedia
from alight.samplers.sampling import get_1d
from lanewise.jit import kernel, specialised

#: Dimension of the time, see `alight.integrators.walk`.
TIME = 4

#: `AtTimes` of contributions.
AtTimesRecorded = namedtuple(
    "AtTimesRecorded", "shapes materials lights accel camera filter motions log time"
)


@specialised
def at_times_of(program):
    """``at_times_of(scene, sampler)``: the scene at the times of these samples."""
    if not program.motion:
        return always
    if program.media:
        return at_times_in_media
    return at_times_recorded if program.integrator == "contributions" else at_times


@kernel
def always(scene, sampler):
    """Nothing moves."""
    return scene


@kernel
def at_times(scene, sampler):
    """What kernels ask for, and when."""
    return AtTimes(
        shapes=scene.shapes,
        materials=scene.materials,
        lights=scene.lights,
        accel=scene.accel,
        camera=scene.camera,
        filter=scene.filter,
        motions=scene.motions,
        time=get_1d(sampler, TIME),
    )


@kernel
def at_times_in_media(scene, sampler):
    """The same of a scene with media."""
    return AtTimesInMedia(
        shapes=scene.shapes,
        materials=scene.materials,
        lights=scene.lights,
        accel=scene.accel,
        camera=scene.camera,
        filter=scene.filter,
        media=scene.media,
        motions=scene.motions,
        time=get_1d(sampler, TIME),
    )


@kernel
def at_times_recorded(scene, sampler):
    """The same with a log."""
    return AtTimesRecorded(
        shapes=scene.shapes,
        materials=scene.materials,
        lights=scene.lights,
        accel=scene.accel,
        camera=scene.camera,
        filter=scene.filter,
        motions=scene.motions,
        log=scene.log,
        time=get_1d(sampler, TIME),
    )
