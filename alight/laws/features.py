"""Laws of integrators: what a scene may have besides, each either refuses or renders as all others.

Each of `FEATURES` is a small scene; a new feature of scenes is one more of them. An integrator that
transports light and does not refuse the scene has the picture of the path tracer: so one that
forgets a feature is found.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.errors import OptionError, SceneError
from alight.core.noise_only import noise_only_fields
from alight.core.registry import default_of
from alight.core.spec import Integrator
from alight.formats import loads
from alight.laws.integrators import REPLICATES, picture
from alight.laws.remembered import remembered
from alight.laws.report import demand
from alight.laws.statistics import LARGEST_Z
from alight.rendering.schedules.schedule import Uniform
from alight.rendering.tiles.light_paths import check_light_paths
from alight.rendering.tiles.tile_kernel import Tile
from alight.rendering.training.guide_training import is_to_be_guided, trained
from alight.scene import flatten

#: Pixels of a side, and samples of each.
SIDE, SPP = 8, 8
#: Rounds that train a guide.
ROUNDS = 2
#: Errors of float32, relative.
ROUNDING = 1e-5


class Feature(NamedTuple):
    """A scene with something that integrators may forget.

    Attributes
    ----------
    nodes : str
        What is added to `SCENE`.
    options : tuple of (str, object)
        What integrators that have such options get.
    by_chance : bool
        Whether integrators that lead no path to a light find enough of it to be judged.
    """

    nodes: str
    options: tuple[tuple[str, object], ...] = ()
    by_chance: bool = True


SCENE = """
alight: 1
camera: {type: pinhole, fov: 40, transform: {look_at: {origin: [0, 0, 3], target: [0, 0, 0]}}}
film: {size: [8, 8]}
sampler: independent
environment: {type: constant, radiance: 0.5}
nodes:
  ball: {shape: {type: sphere, radius: 0.5}, bsdf: {type: diffuse, reflectance: 0.7}}
  lamp:
    shape: disk
    light: {type: area, radiance: 4}
    transform: [{rotate: {axis: x, angle: 90}}, {translate: [0, 1.5, 0.5]}]
"""
GLASS = "type: dielectric, int_ior: 1.0, ext_ior: 1.0, attenuation_distance: 1.5, attenuation_color"
FEATURES = {
    "a camera and a lamp in coloured glass with a bubble": Feature(f"""
  tank: {{shape: {{type: sphere, radius: 4}}, bsdf: {{{GLASS}: [0.2, 0.5, 0.9]}}}}
  bubble:
    shape: {{type: sphere, center: [0.4, 0.2, 1.2], radius: 0.5}}
    bsdf: {{type: dielectric, int_ior: 1.0, ext_ior: 1.0}}
"""),
    "a ball in rough coloured glass": Feature(
        f"""
  shell:
    shape: {{type: sphere, radius: 0.9}}
    bsdf: {{{GLASS.replace("dielectric, int_ior: 1.0", "rough_dielectric, int_ior: 1.3")}:
      [0.9, 0.4, 0.2], alpha: 0.5}}
""",
        by_chance=False,
    ),
    "a ball in a mask of coloured glass": Feature(f"""
  shell:
    shape: {{type: sphere, radius: 0.9}}
    bsdf: {{type: mask, opacity: 0.5, bsdf: {{{GLASS}: [0.9, 0.4, 0.2]}}}}
"""),
    "a ball in a blend of coloured glasses": Feature(f"""
  shell:
    shape: {{type: sphere, radius: 0.9}}
    bsdf: {{type: blend, weight: 0.3, bsdfs: [{{{GLASS}: [0.9, 0.4, 0.2]}}, {{{GLASS}: 0.1}}]}}
"""),
    "a ball behind a mask": Feature("""
  veil:
    shape: {type: sphere, radius: 0.9}
    bsdf: {type: mask, opacity: 0.5, bsdf: {type: diffuse, reflectance: [0.9, 0.3, 0.1]}}
"""),
    "a ball behind nothing": Feature("""
  nothing: {shape: {type: sphere, radius: 0.9}, bsdf: {type: "null"}}
"""),
    "hidden lights": Feature(
        """
  near:
    shape: {type: sphere, center: [0.2, 0, 1.5], radius: 0.3}
    light: {type: area, radiance: [4, 1, 1]}
""",
        (("hide_emitters", True),),
    ),
    "a body that scatters": Feature("""
  wax:
    shape: {type: sphere, center: [0, 0, 0.6], radius: 0.5}
    bsdf: {type: subsurface, radius: 0.5}
"""),
}


def renders_what_it_does_not_refuse(spec: Integrator, name: str) -> None:
    """A scene with an optional feature is refused, or has the picture of a path tracer."""
    feature = FEATURES[name]
    if not spec.transports or (spec.finds_light_by_chance and not feature.by_chance):
        return
    mine = _with_options(spec, feature)
    found = _sums(mine, feature.nodes)
    if found is not None:
        other = _sums(_tracer_like(mine), feature.nodes)
        assert other is not None
        _demand_same(name, found, other)


def _with_options(spec: Integrator, feature: Feature) -> Integrator:
    """An integrator as it renders a scene with a feature.

    Paths are as long as they can be: whether a hole is the end of an edge, each decides itself.
    """
    fields = type(spec).model_fields
    more = dict(option for option in feature.options if option[0] in fields)
    if "max_depth" in fields and fields["max_depth"].default is None:
        more |= {"max_depth": None, "russian_roulette": "throughput"}
    return spec.replaced(**more)


def _tracer_like(spec: Integrator) -> Integrator:
    """The path tracer with the options that decide the picture."""
    tracer, free = default_of(Integrator), {"type", *noise_only_fields(spec)}
    shared = {n: v for n, v in spec if n in type(tracer).model_fields and n not in free}
    if spec.longest_path is not None:
        shared |= {"max_depth": spec.longest_path, "russian_roulette": "none"}
    return tracer.replaced(**shared)


def _compiled(spec: Integrator, nodes: str) -> CompiledScene | None:
    """The scene with this integrator; None if it refuses it."""
    try:
        scene = loads(SCENE + nodes, "feature").replaced(integrator=spec)
        compiled = compile_scene(flatten(scene), structure="list")
        if spec.splats:
            check_light_paths(compiled, Uniform(0, SPP))
    except (SceneError, OptionError):
        return None
    if is_to_be_guided(compiled):
        compiled, _ = trained(compiled, seed=1, threads=1, rounds=ROUNDS)
    return compiled


@remembered(2 * len(FEATURES))
def _sums(spec: Integrator, nodes: str) -> np.ndarray | None:
    """Means (quadrants and channels, pixels, replicates) of the picture; None if it is refused."""
    scene = _compiled(spec, nodes)
    if scene is None:
        return None
    found = picture(scene, Tile(0, 0, SIDE, SIDE), spp=SPP) * (REPLICATES / SPP)
    half = SIDE // 2
    blocks = found.reshape(2, half, 2, half, REPLICATES, 3).transpose(0, 2, 5, 1, 3, 4)
    return blocks.reshape(12, half * half, REPLICATES)


def _demand_same(name: str, mine: np.ndarray, other: np.ndarray) -> None:
    """Equal within the noise of the difference: the same numbers have much in common."""
    difference = mine - other
    expected = other.mean(axis=(1, 2))
    # Light paths are shared by the pixels of a replicate, which all err together then.
    pixels = (difference.var(axis=2, ddof=1) / REPLICATES).mean(axis=1) / difference.shape[1]
    blocks = difference.mean(axis=1).var(axis=1, ddof=1).mean() / REPLICATES
    variance = np.maximum(pixels, blocks) + (ROUNDING * expected) ** 2
    z = difference.mean(axis=(1, 2)) / np.sqrt(variance)
    worst = int(np.argmax(np.abs(z)))
    a, b = (side[worst].mean() for side in (mine, other))
    text = f"mean {a:.5g}, that of a path tracer {b:.5g}"
    demand(abs(z[worst]) < LARGEST_Z, f"{name}: {text}, {abs(z[worst]):.1f} standard errors")


#: Of the first example of an integrator, for each of `FEATURES`.
FIRST_LAWS = (renders_what_it_does_not_refuse,)
