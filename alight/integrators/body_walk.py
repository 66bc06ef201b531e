r"""Random walks through bodies that scatter light, from where a path enters to where it leaves.

A body is what lies below a surface whose model has an `inside`: a homogeneous medium with the
extinction sigma and the albedo alpha, which scatters alike to all sides. A walk of n scatterings
adds to the throughput

.. math:: W = \prod_{k=1}^{n} \alpha \, p_s(\omega_k) \, \sigma\, e^{-\sigma t_k} \cdot
    e^{-\sigma t_{n+1}} \Big/ \sum_i \pi_i P_i

for each channel, with p_s = 1 / 4 pi, and P_i the density of the walk by the way i to draw it. A
walk takes one of six ways, with the probabilities pi, and is weighted by the balance heuristic over
all of them: each channel of colour chooses distances, and either as light does, or as Dwivedi's
scheme has it, which leads the walk back to the surface that it came from,

.. math:: p(\omega) = \frac{1}{2 \pi \ln\frac{\nu + 1}{\nu - 1}}\, \frac{1}{\nu - \omega_z},
    \qquad \sigma' = \Big(1 - \frac{\omega_z}{\nu}\Big)\, \sigma ,

with z out of the body where the walk began and nu the diffusion length in mean free paths. In a
half-space that comes close to walks of equal weights. Elsewhere the weights are bounded all the
same, since walks go the other ways too.

The body ends at the first surface from inside, whatever it is. A walk is part of an edge: it does
not count as depth. Nothing in it looks for lights: from there they are behind a surface that
scatters light.

Source: Křivánek and d'Eon 2014, A zero-variance-based sampling scheme for Monte Carlo subsurface
scattering, for the scheme and nu; Meng, Hanika and Dachsbacher 2016, Improving the Dwivedi sampling
scheme; Veach and Guibas 1995 for the balance heuristic; Wilkie et al. 2014 for the channels.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel import intersect_closest
from alight.bsdfs.switch import has_bodies, inside_of, is_body
from alight.core.constants import INFINITY, INV_FOUR_PI, INV_PI
from alight.core.frame import frame_from_normal
from alight.core.maths import exp, log, pow
from alight.core.vec import Vec3, dot, max_component, normalize
from alight.core.warps import direction_around_z
from alight.integrators.volume_walk import mean
from alight.integrators.walk import count_lanes, vertex_dimension
from alight.lights.choice import lit_normal
from alight.media.tables import step_numbers, stream_of
from alight.samplers.sampling import get_1d
from alight.shapes.hit import side_of
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import (
    any_lane,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    sqrt,
    to_float,
    to_uint,
    where,
)

#: Places among the numbers of a vertex: the way of a walk, and its first distance.
WAY, DISTANCE = 9, 10
#: How many walks are led back to the surface.
LED = 0.75
#: A walk goes on for sure while its weight is above this.
DIM = 0.5
#: Walks of so many scatterings are rare. Those that go on survive to n scatterings with the
#: probability (LONG / n)^LONG_POWER, since without absorption in an endless body their number has
#: no mean. In a white half-space 1 % of the light needs more.
LONG, LONG_POWER = 20_000, 1.5
#: Numbers of the streams of walks begin here, behind those that media use.
OWN_STREAMS = 1 << 15
#: Bounds of nu: at 1 and at infinity its logarithm has no digits left.
LEAST_NU, MOST_NU = 1.001, 40.0
#: Mean free paths are at least so many rounding errors of the place.
LEAST_STEPS = 4.0
#: Below this cosine, the margin under the surface grows no more along a ray.
LEAST_SLOPE = 0.02

#: A walk. o, d: as of a path; d points along the ray to the next scattering; plain, led (Vec3):
#: densities of the walk by the ways of each channel, over that of the way that it takes; albedo
#: (Vec3): product of the albedos.
Walk = namedtuple("Walk", "o d plain led albedo")

#: What stays the same. extinction, albedo, nu (Vec3): of the body; inverse: 1 / nu; width: the
#: logarithm in the density; n: unit normal out of the body.
Body = namedtuple("Body", "extinction albedo nu inverse width n")


@kernel
def diffusion_length(albedo):
    """Nu for the albedo of one scattering, in mean free paths; from Křivánek and d'Eon 2014."""
    a = maximum(albedo, 1e-3)
    exponent = 2.44294 - 0.0215813 * a + 0.578637 / a
    nu = 1.0 / sqrt(maximum(1.0 - pow(a, exponent), 1e-6))
    return minimum(maximum(nu, LEAST_NU), MOST_NU)


@kernel
def body_below(scene, path, surface, entering):
    """The `Body` that paths enter."""
    found = inside_of(scene, surface, entering)
    most = 1.0 / (LEAST_STEPS * maximum(surface.error, 1e-30))
    extinction = Vec3(
        minimum(found.extinction.x, most),
        minimum(found.extinction.y, most),
        minimum(found.extinction.z, most),
    )
    albedo = found.albedo
    nu = Vec3(diffusion_length(albedo.x), diffusion_length(albedo.y), diffusion_length(albedo.z))
    width = Vec3(_width(nu.x), _width(nu.y), _width(nu.z))
    inverse = Vec3(1.0 / nu.x, 1.0 / nu.y, 1.0 / nu.z)
    return Body(extinction, albedo, nu, inverse, width, surface.ng)


@kernel
def _width(nu):
    return log((nu + 1.0) / (nu - 1.0))


@kernel
def pick(v, channel):
    """One of three."""
    return where(channel == 0, v.x, where(channel == 1, v.y, v.z))


@kernel
def _sloped(body, z):
    """Dwivedi's densities of a direction, per steradian."""
    return Vec3(
        0.5 * INV_PI / (body.width.x * (body.nu.x - z)),
        0.5 * INV_PI / (body.width.y * (body.nu.y - z)),
        0.5 * INV_PI / (body.width.z * (body.nu.z - z)),
    )


@kernel
def _passed(sigma, t):
    return Vec3(exp(-sigma.x * t), exp(-sigma.y * t), exp(-sigma.z * t))


@kernel
def _stretched(body, z):
    """Sigma' of the three channels."""
    return Vec3(
        body.extinction.x * (1.0 - z * body.inverse.x),
        body.extinction.y * (1.0 - z * body.inverse.y),
        body.extinction.z * (1.0 - z * body.inverse.z),
    )


@kernel
def _weight(walk):
    """W of the walk so far."""
    mixed = LED * mean(walk.led) + (1.0 - LED) * mean(walk.plain)
    return walk.albedo * walk.plain * (1.0 / maximum(mixed, 1e-30))


@specialised
def enters_body(program):
    """``(scene, surface, d) -> mask``: what leaves the surface along d is in a body."""
    if not has_bodies(program):
        return _enters_nothing

    @kernel
    def enters_body(scene, surface, d):
        return is_body(scene, surface.bsdf) & (side_of(d, surface.ng) < 0.0)

    return enters_body


@kernel
def _enters_nothing(scene, surface, d):
    return lanes_mask(False)


@specialised
def lit_side(program):
    """``(scene, surface, wo) -> normal``: `lit_normal`; only lights outside shine on a body."""
    bodies = has_bodies(program)

    @kernel
    def lit_side(scene, surface, wo):
        n = lit_normal(surface.ns, wo)
        if bodies:
            n = where(is_body(scene, surface.bsdf), surface.ns, n)
        return n

    return lit_side


@specialised
def walk_inside(program):
    """``(scene, path, surface, active) -> (path, rays)``: `walk_through`, where paths enter."""
    if not has_bodies(program):
        return _stay_outside

    @kernel
    def walk_inside(scene, path, surface, active):
        entering = path.active & active & enters_body(scene, surface, path.d)
        if any_lane(entering):
            path = walk_through(scene, path, surface, entering)
        return path, path.rays

    return walk_inside


@kernel
def _stay_outside(scene, path, surface, active):
    return path, path.rays


@kernel
def walk_through(scene, path, surface, entering):
    """Lead paths that enter a body at a surface to the last edge inside.

    Returns
    -------
    as given
        o, d: a ray that meets the surface where the body ends; with the weight in `beta`; absorbed
        ones are no longer active.
    """
    body = body_below(scene, path, surface, entering)
    dimension = vertex_dimension(path.depth)
    stream = stream_of(path.sampler, path.depth + OWN_STREAMS)
    u = get_1d(path.sampler, dimension + WAY)
    led = u < LED
    u = where(led, u / LED, (u - LED) / (1.0 - LED))
    channel = to_uint(minimum(3.0 * u, 2.0))
    sigma, nu = pick(body.extinction, channel), pick(body.nu, channel)
    width, inverse_nu = pick(body.width, channel), pick(body.inverse, channel)

    one = lanes_vec3(1.0)
    walk, factor = Walk(path.o, path.d, one, one, one), lanes(1.0)
    u = get_1d(path.sampler, dimension + DISTANCE)
    going, rays, step = entering, path.rays, lanes_u32(0)
    s, t = frame_from_normal(body.n)
    ended = lanes_mask(False)
    while any_lane(going):
        z = dot(walk.d, body.n)
        stretched = _stretched(body, z)
        chosen = where(led, sigma * (1.0 - z * inverse_nu), sigma)
        distance = -log(1.0 - u) / chosen
        # Walks begin a margin below the surface, where rounding cannot hide it: they end there too.
        margin = where(z > 0.0, surface.error / maximum(z, LEAST_SLOPE), 0.0)
        hit = intersect_closest(scene, walk.o, walk.d, distance + margin, going)
        rays += count_lanes(going)
        left = going & (hit.t < INFINITY)
        distance = where(left, maximum(hit.t - margin, 0.0), distance)
        # Densities of this step by all ways, over that of the way that it took.
        plain, back = _passed(body.extinction, distance), _passed(stretched, distance)
        plain = where(left, plain, plain * body.extinction)
        back = where(left, back, back * stretched)
        taken = where(led, pick(back, channel), pick(plain, channel))
        inverse = 1.0 / maximum(taken, 1e-30)
        moved = replace(walk, plain=walk.plain * plain * inverse, led=walk.led * back * inverse)
        walk = where(going, moved, walk)
        going = going & ~left

        # Absorbed now and then, by what a walk still may add.
        scattered = replace(walk, o=walk.o + distance * walk.d, albedo=walk.albedo * body.albedo)
        walk = where(going, scattered, walk)
        u0, u1 = step_numbers(stream, 2 * step)
        u2, u3 = step_numbers(stream, 2 * step + 1)
        weight = max_component(_weight(walk)) * factor
        survival = minimum(weight * (1.0 / DIM), 1.0)
        longer = survival * (1.0 - LONG_POWER / maximum(to_float(step), 2.0))
        survival = where(step > LONG, longer, survival)
        survives = u0 < survival
        ended = ended | (going & ~survives)
        going = going & survives
        factor = where(going, factor / maximum(survival, 1e-30), factor)

        # Where it goes on.
        sloped = nu - (nu + 1.0) * exp(-u1 * width)
        z = where(led, sloped, 1.0 - 2.0 * u1)
        local = direction_around_z(minimum(maximum(1.0 - z, 0.0), 2.0), u2)
        d = normalize(local.x * s + local.y * t + local.z * body.n)
        z = dot(d, body.n)
        back = _sloped(body, z)
        taken = where(led, pick(back, channel), INV_FOUR_PI)
        inverse = 1.0 / taken
        turned = replace(
            walk, d=d, plain=walk.plain * (INV_FOUR_PI * inverse), led=walk.led * back * inverse
        )
        walk = where(going, turned, walk)
        u = u3
        step = step + 1
    beta = path.beta * _weight(walk) * factor
    through = replace(
        path, o=walk.o, d=walk.d, beta=beta, pdf=lanes(1.0), delta=entering,
        active=path.active & ~ended,
    )  # fmt: skip
    return replace(where(entering, through, path), sampler=path.sampler, rays=rays)
