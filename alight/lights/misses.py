"""What rays find that leave the scene: the light of all environments together."""

from __future__ import annotations

from alight.core.vec import row_vec3
from alight.lights.halves import sum_of
from alight.lights.model import LIGHTS
from alight.lights.tables import row_of
from lanewise.jit import kernel, specialised
from lanewise.simd import lanes, lanes_vec3


def environments_of(program) -> tuple[str, ...]:
    """Names of the models of the program's lights from infinity, in the order of their rows."""
    if program.environments:
        return program.environments
    return tuple(name for name in program.lights if name in LIGHTS and LIGHTS[name].is_around)


def _radiance_of(name: str, back: int):
    radiance = LIGHTS[name].radiance
    assert radiance is not None

    @kernel
    def colored(scene, p, d):
        return row_vec3(scene.lights.data, row_of(scene, back)) * radiance(scene, back, d)

    return colored


def _density_of(name: str, back: int):
    density = LIGHTS[name].pdf
    assert density is not None

    @kernel
    def chosen(scene, p, d):
        return density(scene, back, p, d) * scene.lights.data[row_of(scene, back) + 3]

    return chosen


@specialised
def environment_radiance(program):
    """``environment_radiance(scene, d)``: radiance of a ray that leaves the scene along unit d."""
    names = tuple(enumerate(environments_of(program)[::-1], 1))
    # Portals send nothing.
    parts = tuple(_radiance_of(name, back) for back, name in names if LIGHTS[name].radiance)
    if not parts:

        @kernel
        def black(scene, d):
            return lanes_vec3(0.0)

        return black
    total = sum_of(parts)

    @kernel
    def from_anywhere(scene, d):
        return total(scene, d, d)

    return from_anywhere


@specialised
def environment_pdf(program):
    """Density of `sample_light` for a ray that leaves the scene.

    ``environment_pdf(scene, p, d)``: p, d: the vertex that it comes from, and its unit direction.
    """
    names = tuple(enumerate(environments_of(program)[::-1], 1))
    if not names:

        @kernel
        def impossible(scene, p, d):
            return lanes(0.0)

        return impossible
    return sum_of(tuple(_density_of(name, back) for back, name in names))
