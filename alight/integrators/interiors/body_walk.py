r"""Random walks through bodies that scatter light, from where a path enters to where it leaves.

A body is what lies below a surface whose model has an `inside`: a homogeneous medium with the
extinction sigma and the albedo alpha, which scatters alike to all sides. A walk of n scatterings
and the length L adds to the throughput, for each channel,

.. math:: W = \alpha^n P \Big/ \sum_i \pi_i P_i, \qquad
    P = \Big(\frac{\sigma}{4 \pi}\Big)^n e^{-\sigma L},

with P_i the density of the walk by the way i to draw it. A walk takes one of six ways, with the
probabilities pi, and is weighted by the balance heuristic over all of them: each channel of colour
chooses distances, the more often the more light it carries, and either as light does, with the
density P, or as Dwivedi's scheme has it, which leads the walk back to the surface that it came
from,

.. math:: p(\omega) = \frac{1}{2 \pi w}\, \frac{1}{\nu - \omega_z}, \qquad
    w = \ln\frac{\nu + 1}{\nu - 1}, \qquad
    \sigma' = \Big(1 - \frac{\omega_z}{\nu}\Big)\, \sigma ,

with z out of the body where the walk began and nu the diffusion length in mean free paths. The
factors of a walk that depend on its directions cancel, all but the first and the last; with Z, how
far the walk has come along z, its density is

.. math:: P \cdot \Big(\frac{2}{w \nu}\Big)^n e^{\sigma Z / \nu}\,
    \frac{\nu - \omega_{z,0}}{\nu - \omega_{z,n}} .

So n, L, Z and two cosines are all that has to be known of it. In a half-space led walks come close
to equal weights. Elsewhere the weights are bounded all the same, since walks go the other ways too.

The body ends at the first surface from inside, whatever it is. A walk is part of an edge: it does
not count as depth. Nothing in it looks for lights: from there they are behind a surface that
scatters light. Where a body has no end, walks that leave it behind end earlier
(`alight.integrators.interiors.endless`).

Source: Křivánek and d'Eon 2014, A zero-variance-based sampling scheme for Monte Carlo subsurface
scattering, for the scheme and nu; Meng, Hanika and Dachsbacher 2016, Improving the Dwivedi sampling
scheme; Veach and Guibas 1995 for the balance heuristic; Wilkie et al. 2014 for the channels;
Chiang, Kutz and Burley 2016 for their probabilities.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel import intersect_closest
from alight.bsdfs.switch import has_bodies, inside_of, is_body
from alight.core.constants import INFINITY
from alight.core.frame import frame_from_normal
from alight.core.maths import exp, log, pow
from alight.core.vec import Vec3, absolute_vec3, dot, max_component, normalize
from alight.core.warps import direction_around_z
from alight.integrators.interiors.endless import chance_of_return
from alight.integrators.moments import at_times_of
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
    where,
)

#: Places among the numbers of a vertex: the way of a walk, and its first distance.
WAY, DISTANCE = 9, 10
#: How many walks are led back to the surface.
LED = 0.75
#: A channel that carries light is followed as if it were by so much brighter.
FAINT = 0.25
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
#: Larger exponents of e would overflow in float32.
MOST_EXPONENT = 80.0

#: What stays the same. extinction: sigma; albedo, rarity and led: logarithms of alpha, of sigma
#: over that of the first channel, and of 2 / (w nu); nu; share: pi (all of them Vec3); n: unit
#: normal out of the body; margin: rounding error there, metres.
Body = namedtuple("Body", "extinction albedo rarity led nu share n margin")

#: The way that a walk takes. led: mask; sigma, nu, width: of its channel.
Way = namedtuple("Way", "led sigma nu width")

#: A walk. The ray to its next place is that of its path. going: mask; u: number in [0, 1) for the
#: next distance; step: n; length, height: L and Z, metres; first: cosine of the first direction;
#: factor: 1 over the probability that it has survived.
Walk = namedtuple("Walk", "going body way u step length height first factor")


@kernel
def diffusion_length(albedo):
    """Nu for the albedo of one scattering, in mean free paths; from Křivánek and d'Eon 2014."""
    a = maximum(albedo, 1e-3)
    exponent = 2.44294 - 0.0215813 * a + 0.578637 / a
    nu = 1.0 / sqrt(maximum(1.0 - pow(a, exponent), 1e-6))
    return minimum(maximum(nu, LEAST_NU), MOST_NU)


@kernel
def _width(nu):
    return log((nu + 1.0) / (nu - 1.0))


@kernel
def pick(v, u):
    """One of three, by a number in [0, 3)."""
    return where(u < 1.0, v.x, where(u < 2.0, v.y, v.z))


@kernel
def shares_of(beta, albedo):
    """Probabilities of the channels: all have one that can carry light."""
    bright = absolute_vec3(beta) * (albedo + lanes_vec3(FAINT))
    total = bright.x + bright.y + bright.z
    # Not "total <= 0": a NaN is followed, and counted by the film.
    some = (total > 0.0) & (total < INFINITY)
    third = lanes_vec3(1.0 / 3.0)
    return where(some, bright * (1.0 / where(some, total, 1.0)), third)


@kernel
def _logarithms(v):
    return Vec3(log(maximum(v.x, 1e-30)), log(maximum(v.y, 1e-30)), log(maximum(v.z, 1e-30)))


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
    led = Vec3(
        log(2.0 / (_width(nu.x) * nu.x)),
        log(2.0 / (_width(nu.y) * nu.y)),
        log(2.0 / (_width(nu.z) * nu.z)),
    )
    rarity = _logarithms(extinction * (1.0 / extinction.x))
    share = shares_of(path.beta, albedo)
    return Body(
        extinction=extinction, albedo=_logarithms(albedo), rarity=rarity, led=led, nu=nu,
        share=share, n=surface.ng, margin=surface.error,
    )  # fmt: skip


@kernel
def _exponentials(v):
    return Vec3(
        exp(minimum(v.x, MOST_EXPONENT)),
        exp(minimum(v.y, MOST_EXPONENT)),
        exp(minimum(v.z, MOST_EXPONENT)),
    )


@kernel
def weight_of(walk, z):
    """W of a walk so far, for the cosine of its last direction."""
    body, n = walk.body, to_float(walk.step)
    # Logarithms of P, over that of the first channel and then over the largest.
    first = body.extinction.x
    thinner = body.extinction - lanes_vec3(1.0) * first
    plain = n * body.rarity - walk.length * thinner
    plain = plain - lanes_vec3(1.0) * max_component(plain)
    depth = Vec3(
        body.extinction.x * walk.height / body.nu.x,
        body.extinction.y * walk.height / body.nu.y,
        body.extinction.z * walk.height / body.nu.z,
    )
    turned = Vec3(
        (body.nu.x - walk.first) / (body.nu.x - z),
        (body.nu.y - walk.first) / (body.nu.y - z),
        (body.nu.z - walk.first) / (body.nu.z - z),
    )
    led = _exponentials(plain + n * body.led + depth) * turned
    mixed = dot(body.share, LED * led + (1.0 - LED) * _exponentials(plain))
    return _exponentials(plain + n * body.albedo) * (1.0 / maximum(mixed, 1e-30))


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


# ---------------------------------------------------------------- walks


@specialised
def begin_walks(program):
    """``(scene, path, surface, active) -> Walk``, where paths enter; () without bodies."""
    if not has_bodies(program):
        return _no_walks

    @kernel
    def begin_walks(scene, path, surface, active):
        entering = path.active & active & enters_body(scene, surface, path.d)
        walk = no_walks()
        if any_lane(entering):
            walk = _begin(scene, path, surface, entering)
        return walk

    return begin_walks


@kernel
def _no_walks(scene, path, surface, active):
    return ()


@kernel
def no_walks():
    """Walks, none of them going."""
    zero, none = lanes(0.0), lanes_vec3(0.0)
    body = Body(
        extinction=none, albedo=none, rarity=none, led=none, nu=none, share=none, n=none,
        margin=zero,
    )  # fmt: skip
    return Walk(
        going=lanes_mask(False), body=body, way=Way(lanes_mask(False), zero, zero, zero), u=zero,
        step=lanes_u32(0), length=zero, height=zero, first=zero, factor=zero,
    )  # fmt: skip


@kernel
def _begin(scene, path, surface, entering):
    """Choose the way of a walk, and the number of its first distance."""
    body = body_below(scene, path, surface, entering)
    dimension = vertex_dimension(path.depth)
    u = get_1d(path.sampler, dimension + WAY)
    share = body.share
    below, above = share.x, share.x + share.y
    # In [0, 3): the channel, and where in its part of [0, 1) u is.
    of_x = u / maximum(share.x, 1e-30)
    of_y = (u - below) / maximum(share.y, 1e-30)
    of_z = (u - above) / maximum(share.z, 1e-30)
    within = where(u < below, of_x, where(u < above, of_y, of_z))
    channel = where(u < below, 0.5, where(u < above, 1.5, 2.5))
    nu = pick(body.nu, channel)
    way = Way(within < LED, pick(body.extinction, channel), nu, _width(nu))
    u = get_1d(path.sampler, dimension + DISTANCE)
    return Walk(
        going=entering, body=body, way=way, u=u, step=lanes_u32(0), length=lanes(0.0),
        height=lanes(0.0), first=dot(path.d, body.n), factor=lanes(1.0),
    )  # fmt: skip


@kernel
def scatter(scene, path, walk):
    """One edge of each walk that is going.

    Returns
    -------
    path : as given
        o, d: the next ray, or one that meets the surface where the body ends, with the weight of
        the walk in `beta`; absorbed ones are no longer active.
    walk : Walk
    """
    body, way, going = walk.body, walk.way, walk.going
    z = dot(path.d, body.n)
    chosen = way.sigma * where(way.led, 1.0 - z / way.nu, 1.0)
    distance = -log(1.0 - walk.u) / chosen
    # Walks begin a margin below the surface, where rounding cannot hide it: they end there too.
    margin = where(z > 0.0, body.margin / maximum(z, LEAST_SLOPE), 0.0)
    hit = intersect_closest(scene, path.o, path.d, distance + margin, going)
    rays = path.rays + count_lanes(going)
    left = going & (hit.t < INFINITY)
    distance = where(left, maximum(hit.t - margin, 0.0), distance)
    walk = replace(
        walk, length=walk.length + distance, height=walk.height + z * distance,
        step=walk.step + where(left, lanes_u32(0), lanes_u32(1)),
    )  # fmt: skip

    # Where it leaves the body, or goes on.
    stream = stream_of(path.sampler, path.depth + OWN_STREAMS)
    u0, u1 = step_numbers(stream, 2 * walk.step)
    u2, u3 = step_numbers(stream, 2 * walk.step + 1)
    sloped = way.nu - (way.nu + 1.0) * exp(-u1 * way.width)
    cosine = where(way.led, sloped, 1.0 - 2.0 * u1)
    local = direction_around_z(minimum(maximum(1.0 - cosine, 0.0), 2.0), u2)
    s, t = frame_from_normal(body.n)
    d = normalize(local.x * s + local.y * t + local.z * body.n)
    scattered = going & ~left
    weight = weight_of(walk, where(left, z, dot(d, body.n)))

    # Absorbed now and then, by what a walk still may add.
    worth = max_component(body.share * weight) / max_component(body.share)
    worth = worth * chance_of_return(scene, path.o + distance * path.d)
    survival = minimum(worth * walk.factor * (1.0 / DIM), 1.0)
    longer = survival * (1.0 - LONG_POWER / maximum(to_float(walk.step), 2.0))
    survival = where(walk.step > LONG, longer, survival)
    survives = scattered & (u0 < survival)
    factor = where(survives, walk.factor / maximum(survival, 1e-30), walk.factor)

    through = replace(path, beta=path.beta * weight * factor, pdf=lanes(1.0), delta=left)
    on = replace(path, o=path.o + distance * path.d, d=d)
    active = path.active & (~scattered | survives)
    moved = where(left, through, where(survives, on, path))
    path = replace(moved, sampler=path.sampler, active=active, rays=rays)
    return path, replace(walk, going=survives, u=u3, factor=factor)


@specialised
def walk_through(program):
    """``(scene, path, walk) -> path``: all walks to their ends, one edge after the other."""
    if not has_bodies(program):
        return _stay_outside

    @kernel
    def walk_through(scene, path, walk):
        while any_lane(walk.going):
            path, walk = scatter(scene, path, walk)
        return path

    return walk_through


@specialised
def walk_on(program):
    """``(scene, path, walk, rest) -> (path, walk)``: until no more walks than `rest` are going."""
    moving = bool(program.motion)

    @kernel
    def walk_on(scene, path, walk, rest):
        seen = at_times_of(scene, path.sampler) if moving else scene
        while count_lanes(walk.going) > rest:
            path, walk = scatter(seen, path, walk)
        return path, walk

    return walk_on


@kernel
def _stay_outside(scene, path, walk):
    return path
