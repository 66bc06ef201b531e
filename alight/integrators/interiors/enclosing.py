"""The bodies that a path is in, and what they leave of its light.

**The rule of bodies.** Materials that refract, and those with a random walk below them, bound a
body. Whoever crosses such a surface against its outer normal, in whatever way (refracted, or
through a hole), enters its body; whoever crosses it along the normal is back in the body around.
Reflection crosses nothing. A segment is dimmed by the body that was entered last. Other surfaces
change nothing, so a segment between two opaque things inside a body is dimmed as any other.

Paths know this from their own crossings, and so the same segment is dimmed alike from both sides.
Where they begin, a ray counts the boundaries that it leaves without having entered them; it is
traced only within the box around all bodies that absorb. What comes upon the inner side of a
boundary lies in its body, whatever was known before: errors, such as those of overlapping bodies,
do not last.

Bodies must be closed: what has crossed an open mesh stays below it until it crosses back. Light
that comes from infinity or goes there is not dimmed on this last segment, which has no length. Of
more than three bodies around one another the outermost is forgotten until its inner side is met.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel import intersect_closest
from alight.bsdfs.interiors.bodies import absorbs, absorption_below, left_after
from alight.core.constants import INFINITY
from alight.shapes.hit import side_of, spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import any_lane, count_bits, lanes, lanes_u32, lanes_vec3, mask_bits, where

#: Absorption, per metre (Vec3), of the body that a path is in, of the one around it and of the one
#: around that; 0 for empty space.
Bodies = namedtuple("Bodies", "inner middle outer")

#: Surfaces at most that a ray goes through to find out what a path begins in.
MOST_SURFACES = 256


@kernel
def no_bodies():
    """`Bodies` of paths in empty space."""
    nothing = lanes_vec3(0.0)
    return Bodies(nothing, nothing, nothing)


# Kernels below that are made for a program do nothing where no bodies absorb; what takes or returns
# `Bodies` has () in their place.

# ---------------------------------------------------------------- crossing boundaries


@specialised
def bodies_beyond(program):
    """In which bodies rays go on: ``(scene, bodies, surface, d, w) -> Bodies``.

    They came to the surface along d, in `bodies`, and leave it along w.
    """
    return _bodies_beyond if absorbs(program) else _stay


@kernel
def _bodies_beyond(scene, bodies, surface, d, w):
    body = absorption_below(scene, surface)
    was_inside, is_inside = side_of(d, surface.ng) > 0.0, side_of(w, surface.ng) < 0.0
    entered = (body.x >= 0.0) & ~was_inside & is_inside
    left = (body.x >= 0.0) & was_inside & ~is_inside
    within = Bodies(body, bodies.inner, bodies.middle)
    around = Bodies(bodies.middle, bodies.outer, lanes_vec3(0.0))
    return where(entered, within, where(left, around, bodies))


@kernel
def _stay(scene, bodies, surface, d, w):
    return bodies


@kernel
def _at_arrival(scene, bodies, surface, d, met):
    """In which bodies rays along d have come to a surface, those of the mask."""
    body = absorption_below(scene, surface)
    inside = met & (body.x >= 0.0) & (side_of(d, surface.ng) > 0.0)
    return replace(bodies, inner=where(inside, body, bodies.inner))


# ---------------------------------------------------------------- what is left of the light


@kernel
def _left_along(bodies, t, active):
    """What remains after t metres, a Vec3; all of it after infinitely many."""
    return left_after(bodies.inner, where(active & (t < INFINITY), t, 0.0))


@specialised
def come_to(program):
    """Ends of segments: ``(scene, path, surface, t, met, active) -> path``.

    Active paths have come t metres, those of the mask `met` to the surface.
    """
    return _come_to if absorbs(program) else _come_undimmed


@kernel
def _come_to(scene, path, surface, t, met, active):
    bodies = _at_arrival(scene, path.bodies, surface, path.d, met)
    beta = path.beta * _left_along(bodies, t, active)
    return replace(path, beta=where(active, beta, path.beta), bodies=bodies)


@kernel
def _come_undimmed(scene, path, surface, t, met, active):
    return path


@specialised
def cross_straight(program):
    """Shadow rays through surfaces: ``(scene, bodies, left, surface, ray, masks)``.

    Of `ray`, (d, t), those of the mask `going` come t metres along d, those of `met` to a surface;
    masks: (going, met). Returns the bodies behind it, and what is left of the light, a Vec3 or ().
    """
    return _cross_straight if absorbs(program) else _cross_undimmed


@kernel
def _cross_straight(scene, bodies, left, surface, ray, masks):
    d, t = ray
    going, met = masks
    bodies = _at_arrival(scene, bodies, surface, d, met)
    left = left * _left_along(bodies, t, going)
    return where(met, _bodies_beyond(scene, bodies, surface, d, d), bodies), left


@kernel
def _cross_undimmed(scene, bodies, left, surface, ray, masks):
    return bodies, left


@specialised
def left_along(program):
    """What is left of the light of shadow rays that nothing lets through in part.

    ``(bodies, t, active) -> Vec3`` after t metres, or (); all of it after infinitely many.
    """
    return _left_along if absorbs(program) else _left_undimmed


@kernel
def _left_undimmed(bodies, t, active):
    return ()


@specialised
def left_between(program):
    """The same between two surfaces: ``(scene, bodies, surface, w, t, active) -> Vec3``, or ().

    In `bodies` along w to the surface.
    """
    return _left_between if absorbs(program) else _all_between


@kernel
def _left_between(scene, bodies, surface, w, t, active):
    return _left_along(_at_arrival(scene, bodies, surface, w, active), t, active)


@kernel
def _all_between(scene, bodies, surface, w, t, active):
    return ()


@specialised
def dimmed(program):
    """``(value, left) -> Vec3``: light of which so much is left."""
    return _dimmed if absorbs(program) else _undimmed


@kernel
def _dimmed(value, left):
    return value * left


@kernel
def _undimmed(value, left):
    return value


@specialised
def all_left(program):
    """``all_left()``: of light before its way, a Vec3, or ()."""
    return _all_left if absorbs(program) else _nothing_kept


@kernel
def _all_left():
    return lanes_vec3(1.0)


@kernel
def _nothing_kept():
    return ()


# ---------------------------------------------------------------- where paths begin


@specialised
def empty_space(program):
    """``empty_space()``: the `Bodies` of rays that are in none, or ()."""
    return no_bodies if absorbs(program) else _nothing_kept


@kernel
def _may_be_inside(scene, p):
    box = scene.materials.bodies.box
    x = (p.x >= box[0]) & (p.x <= box[3])
    y = (p.y >= box[1]) & (p.y <= box[4])
    return x & y & (p.z >= box[2]) & (p.z <= box[5])


@kernel
def bodies_around(scene, o, d, active):
    """The `Bodies` around points o, found along any directions d, and how many rays that took."""
    bodies, none = no_bodies(), lanes_u32(0)
    found, entered, surfaces, rays = none, none, 0, 0
    going = active & _may_be_inside(scene, o)
    while surfaces < MOST_SURFACES and any_lane(going):
        rays += count_bits(mask_bits(going))
        hit = intersect_closest(scene, o, d, lanes(INFINITY), going)
        met = going & (hit.t < INFINITY)
        surface = make_surface(scene, hit, o, d, met)
        body = absorption_below(scene, surface)
        bounds, inner = met & (body.x >= 0.0), side_of(d, surface.ng) > 0.0
        around = bounds & inner & (entered == 0)
        bodies = Bodies(
            inner=where(around & (found == 0), body, bodies.inner),
            middle=where(around & (found == 1), body, bodies.middle),
            outer=where(around & (found == 2), body, bodies.outer),
        )
        found = where(around, found + 1, found)
        back = where(bounds & inner & ~around, entered - 1, entered)
        entered = where(bounds & ~inner, entered + 1, back)
        o = where(met, spawn_origin(surface.p, surface.error, surface.ng, d), o)
        surfaces += 1
        going = met & (found < 3)
    return bodies, rays


@specialised
def begin_inside(program):
    """``(scene, path, new) -> path``: those of the mask in the bodies around where they begin."""
    return _begin_inside if absorbs(program) else _begin_outside


@kernel
def _begin_inside(scene, path, new):
    bodies, rays = bodies_around(scene, path.o, path.d, new)
    return replace(path, bodies=where(new, bodies, path.bodies), rays=path.rays + rays)


@kernel
def _begin_outside(scene, path, new):
    return path
