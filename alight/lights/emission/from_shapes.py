r"""Light that leaves shapes: a point by its area or its light, a direction by its cosine.

.. math:: p_A = 1 / A, \qquad p_\omega = \cos\theta / \pi

Where a texture has a map, the point is drawn by the map (`alight.lights.area_map`): in proportion
to its light.

Source: PBR4 section 16.1.2.
"""

from __future__ import annotations

from alight.core.constants import INV_PI, PI
from alight.core.frame import frame_from_normal, to_world
from alight.core.vec import dot, normalize
from alight.core.warps import square_to_cosine_hemisphere
from alight.lights.area_map import draw, map_at, square_density
from alight.lights.hits import radiance_of_shape
from alight.lights.shining import sample_area
from alight.lights.tables import INFO, MAPPED, Emission
from alight.shapes.hit import Hit, spawn_origin
from alight.shapes.surfaces import surface_from_rest
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    any_lane,
    gather,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    maximum,
    where,
)


@specialised
def place_on_shape(program):
    """``place_on_shape(scene, index, u, u2) -> (surface, density per square metre)``.

    A point of the lights `index`, which are shapes.
    """
    mapped = MAPPED in program.lights

    @kernel
    def place_on_shape(scene, index, u, u2):
        shape = gather(scene.lights.info, index * INFO + 1)
        start = gather(scene.lights.starts, index)
        shape, cdf = lanes_u32(0) + shape, scene.lights.emission
        s = sample_area(scene.shapes, cdf, start, shape, u, u2)
        density = lanes(0.0) + s.pdf
        if mapped:
            at = map_at(scene, index, lanes_u32(0) + s.prim)
            chosen = at != 0
            if any_lane(chosen):
                x, y = draw(scene, at, u, u2)
                square = where(chosen, x, u2[0]), where(chosen, y, u2[1])
                s = sample_area(scene.shapes, cdf, start, shape, u, square)
                density = where(chosen, s.pdf * square_density(scene, at, x, y), s.pdf)
        # The point is the hit of a ray that ends before it has begun.
        hit = Hit(lanes(0.0), lanes(0.0) + s.u, lanes(0.0) + s.v, shape, lanes_u32(0) + s.prim)
        surface = surface_from_rest(scene, hit, s.p, lanes_vec3(1.0), lanes_mask(True))
        return surface, density

    return place_on_shape


@kernel
def emit_from_shape(scene, index, u, u2, v2):
    """A ray from the lights `index`, which are shapes, as `Emission` before their choice.

    Parameters
    ----------
    scene : namedtuple
    index : uint32
    u, u2 : float and pair of floats
        Uniform in [0, 1), choose the point.
    v2 : pair of floats
        Uniform in [0, 1), choose the direction.
    """
    surface, pdf = place_on_shape(scene, index, u, u2)
    n = surface.ng
    a, b = frame_from_normal(n)
    d = normalize(to_world(a, b, n, square_to_cosine_hemisphere(v2)))
    drawn = pdf > 0.0
    # The cosine cancels that of the density.
    area = where(drawn, PI / where(drawn, pdf, 1.0), 0.0)
    return Emission(
        p=surface.p,
        n=n,
        o=spawn_origin(surface.p, surface.error, n, d),
        d=d,
        flux=radiance_of_shape(scene, index, surface, d) * area,
        light=lanes_u32(0),
        prim=surface.prim,
        choice=lanes(1.0),
        pdf_position=lanes(0.0) + pdf,
        pdf_direction=shape_direction_pdf(n, d),
        delta_position=lanes_mask(False),
        delta_direction=lanes_mask(False),
    )


@kernel
def shape_direction_pdf(n, d):
    """Density of the direction d per steradian, at a point of a shape with the normal n."""
    return INV_PI * maximum(dot(n, d), 0.0)
