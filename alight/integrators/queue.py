"""Paths waiting for their next step until they fill a packet.

With each path waits what else its next step needs: nothing (`NO_HIT`), what its ray has hit, or its
walk through a body.
"""

from __future__ import annotations

from alight.core.vec import Vec3
from alight.integrators.interiors.body_walk import no_walks
from alight.integrators.walk import count_lanes, empty_paths
from lanewise.jit import kernel, specialised
from lanewise.records import local_records, put_records, records_at, replace
from lanewise.simd import as_int, lane_index, lanes_u32, lanes_vec3, packing

#: Paths that a queue holds: two packets, so that one can be read or written from any place in the
#: first.
ROOM = 32
#: The same of walks, which may fill three before their turn comes.
WALKS = 64

#: What waits with a path whose ray has not been traced yet.
NO_HIT = ()


def _keeps_direct(program) -> bool:
    """Whether `L_direct` is in use."""
    return "direct" in program.aovs


@specialised
def kept(program):
    """``kept(path)``: a path without what it can be given anew; uniform numbers do not wait."""
    keeps_direct = _keeps_direct(program)

    @kernel
    def kept(path):
        sampler = replace(path.sampler, seed=0)
        path = replace(path, sampler=sampler, active=True, rays=0)
        if not keeps_direct:
            path = replace(path, L_direct=Vec3(0.0, 0.0, 0.0))
        return path

    return kept


@specialised
def restored(program):
    """``restored(settings, path, count)``: the path of which `kept` has kept a part."""
    keeps_direct = _keeps_direct(program)

    @kernel
    def restored(settings, path, count):
        sampler = replace(path.sampler, seed=lanes_u32(settings.seed))
        path = replace(path, sampler=sampler, active=lane_index() < count, rays=as_int(0))
        if not keeps_direct:
            path = replace(path, L_direct=lanes_vec3(0.0))
        return path

    return restored


@kernel
def empty_queue(hit):
    """Room for paths, and for what each has hit: `NO_HIT`, or any `Hit`."""
    return local_records(ROOM, (kept(empty_paths()), hit))


@kernel
def put(queue, at, path, hit):
    """Append the active paths, and what they hit, from number `at` on; the new length.

    The others follow them, where only inactive lanes read.
    """
    put_records(queue, ROOM, at, packing(path.active), (kept(path), hit))
    return at + count_lanes(path.active)


@kernel
def take(settings, queue, at, count, hit):
    """The paths from number `at` on, and what they hit; `hit` says what was put there."""
    path, found = records_at(queue, ROOM, at, (kept(empty_paths()), hit))
    return restored(settings, path, count), found


@kernel
def no_walks_wait():
    """Room for walks."""
    return local_records(WALKS, (kept(empty_paths()), no_walks()))


@kernel
def put_walks(walks, at, path, walk):
    """Append the walks that are going, with their paths; as `put`."""
    put_records(walks, WALKS, at, packing(walk.going), (kept(path), walk))
    return at + count_lanes(walk.going)


@kernel
def take_walks(settings, walks, at, count):
    """The paths from number `at` on, and their walks."""
    path, walk = records_at(walks, WALKS, at, (kept(empty_paths()), no_walks()))
    path = restored(settings, path, count)
    return path, replace(walk, going=path.active)
