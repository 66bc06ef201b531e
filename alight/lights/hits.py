"""What rays find that hit a shape which shines, whatever lights a scene has."""

from __future__ import annotations

from alight.core.vec import dot
from alight.lights.choice import chosen_probability, light_index
from alight.lights.model import LIGHTS, LightModel
from alight.lights.moving import moving_pdf
from alight.lights.tables import INFO
from alight.shapes.hit import ShapeHit
from lanewise.jit import kernel, specialised
from lanewise.simd import any_lane, gather, lanes, lanes_u32, lanes_vec3, where


def on_shapes(program) -> tuple[LightModel, ...]:
    """The lights of the program that are shapes which shine."""
    return tuple(m for name, m in LIGHTS.items() if name in program.lights and m.is_on_shape)


@specialised
def emitted(program):
    """``emitted(scene, surface, wo)``: radiance that a surface itself sends along the unit wo."""
    if not on_shapes(program):

        @kernel
        def dark(scene, surface, wo):
            return lanes_vec3(0.0)

        return dark

    @kernel
    def on_outer_side(scene, surface, wo):
        shines = (surface.light > 0) & (dot(wo, surface.ng) > 0.0)
        radiance = radiance_of_shape(scene, light_index(surface.light), surface, wo)
        return where(shines, radiance, lanes_vec3(0.0))

    return on_outer_side


@specialised
def light_pdf(program):
    """Density of `alight.lights.sampling.sample_light` for a direction that has hit an area light.

    ``light_pdf(scene, light, p, wi, distance, surface)``: `light` is ``surface.light``, 0 where the
    surface does not shine (the density is 0 then); p, wi, distance: from where, unit direction,
    metres to the hit.
    """
    if not on_shapes(program):

        @kernel
        def without_area_lights(scene, light, p, wi, distance, surface):
            return lanes(0.0)

        return without_area_lights

    @kernel
    def with_area_lights(scene, light, p, wi, distance, surface):
        shines = light > 0
        index, prim = light_index(light), where(shines, surface.prim, 0)
        hit = ShapeHit(prim, wi, distance, cosine=-dot(wi, surface.ng))
        density = pdf_of_shape(scene, index, p, hit)
        return where(shines, density * chosen_probability(scene, index, prim, p, shines), 0.0)

    return with_area_lights


@specialised
def pdf_of_shape(program):
    """``pdf_of_shape(scene, index, p, hit)``: of the lights `index` at a `ShapeHit`."""
    chain = _pdf_chain(on_shapes(program))
    return moving_pdf(chain) if "lights" in program.motion else chain


def _pdf_chain(models: tuple[LightModel, ...]):
    """A kernel that runs each light's `pdf` where it was hit."""
    own, number = models[0].pdf, models[0].number
    assert own is not None
    if len(models) == 1:
        return own
    others = _pdf_chain(models[1:])

    @kernel
    def choose(scene, index, p, hit):
        result = others(scene, index, p, hit)
        mine = lanes_u32(0) + gather(scene.lights.info, index * INFO) == number
        if any_lane(mine):
            result = where(mine, own(scene, index, p, hit), result)
        return result

    return choose


@specialised
def radiance_of_shape(program):
    """``(scene, index, surface, wo)``: what the lights `index` emit on their outer side."""
    return _emission_chain(on_shapes(program))


def _emission_chain(models: tuple[LightModel, ...]):
    """A kernel that runs each light's `emitted` where it was hit."""
    own, number = models[0].emitted, models[0].number
    assert own is not None
    if len(models) == 1:
        return own
    others = _emission_chain(models[1:])

    @kernel
    def choose(scene, index, surface, wo):
        result = others(scene, index, surface, wo)
        mine = lanes_u32(0) + gather(scene.lights.info, index * INFO) == number
        if any_lane(mine):
            result = where(mine, own(scene, index, surface, wo), result)
        return result

    return choose
