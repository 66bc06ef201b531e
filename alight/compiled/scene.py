"""From a flat scene to arrays: the only place that knows the models and their tables."""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.accel.accelerator import build_accelerator
from alight.bsdfs.interiors.absorption import ABSORBING
from alight.bsdfs.interiors.bodies import ENDLESS
from alight.compiled.area_maps import Textures
from alight.compiled.bodies import may_be_endless, with_ball, with_bodies
from alight.compiled.cameras import SmallView, compile_camera, small_view
from alight.compiled.displacement import displaced, told
from alight.compiled.ground import ground_of
from alight.compiled.kept import Kept
from alight.compiled.lights import CompiledLights, compile_lights, light_textures
from alight.compiled.materials import PackedMaterials
from alight.compiled.media import compile_media
from alight.compiled.motion import MotionTable
from alight.compiled.photons import with_photons
from alight.compiled.program import Program
from alight.compiled.rendering_space import WORLD, Ball, in_rendering_space, origin_for
from alight.compiled.shapes import CompiledShapes, compile_shapes
from alight.compiled.surfaces import Surfaces, surfaces_of
from alight.compiled.warnings.bodies import warnings_of_bodies
from alight.compiled.warnings.contacts import warnings_of_contacts
from alight.compiled.warnings.edges import warnings_of_edges
from alight.compiled.warnings.sizes import warnings_of_sizes
from alight.core.motion import RIGID
from alight.core.registry import versions
from alight.core.spec import Integrator
from alight.core.uv_sets import UV_SETS
from alight.films.mattes import MATTES
from alight.filters.importance import compile_filter
from alight.guiding.tables import Guide
from alight.lights.ground import SHADOW, Ground
from alight.lights.tables import INFO as LIGHT_INFO
from alight.media.tables import EMISSIVE
from alight.samplers.sampling import sampler_key
from alight.scene.description import NO_LIGHT
from alight.scene.flatten import FlatScene
from alight.scene.hashing import described

#: The tables that kernels are given; each is a namedtuple of `View`.
SceneTables = namedtuple("SceneTables", "shapes materials lights accel camera filter")


#: The same of a scene with media; kernels of other scenes know of none.
SceneWithMedia = namedtuple("SceneWithMedia", (*SceneTables._fields, "media"))


#: The same of scenes in which something moves while the shutter is open;
#: `alight.integrators.moments` adds the times.
MovingScene = namedtuple("MovingScene", (*SceneTables._fields, "motions"))
MovingWithMedia = namedtuple("MovingWithMedia", (*SceneWithMedia._fields, "motions"))


@dataclass(frozen=True)
class CompiledScene:
    """A scene as kernels see it.

    Attributes
    ----------
    tables : SceneTables, SceneWithMedia, MovingScene or MovingWithMedia
        Arrays; picklable.
    program : Program
        What the kernels must be specialised on.
    size : (int, int)
        Width and height of the full film in pixels.
    crop : (int, int, int, int) or None
        x, y, width, height of the window to render.
    content_hash : str
        Names everything that decides the picture.
    integrator : Integrator
        Description, for its numbers.
    stats : dict
        Counts, bytes and seconds of the acceleration structure.
    warnings : tuple of str
        All that is legal but suspicious: what the description tells, what had to be changed in
        pictures, and what only a compiled scene tells.
    small_view : SmallView or None
        Of integrators that want a guide: where its training starts.
    guide : Guide or None
        What its program asks for, see `alight.rendering.training.guide_training`.
    surfaces : Surfaces or None
        Of scenes whose layers name what is seen.
    ground : Ground or None
        Of scenes whose shadows are caught on it.
    origin : (3,) float64, metres
        Where in the world the origin of the tables' coordinates is.
    ball : Ball or None
        In the world, around all finite shapes, if there are any.
    """

    tables: SceneTables | SceneWithMedia | MovingScene | MovingWithMedia
    program: Program
    size: tuple[int, int]
    crop: tuple[int, int, int, int] | None
    content_hash: str
    integrator: Integrator
    stats: dict[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    small_view: SmallView | None = None
    guide: Guide | None = None
    surfaces: Surfaces | None = None
    ground: Ground | None = None
    origin: NDArray[np.float64] = field(default_factory=lambda: WORLD)
    ball: Ball | None = None


def compile_scene(
    flat: FlatScene,
    content_hash: str = "",
    *,
    aovs: tuple[str, ...] = (),
    structure: str = "auto",
    builder: str = "sah",
    threads: int = 1,
    emits: bool = False,
    kept: Kept | None = None,
) -> CompiledScene:
    """Arrays and program of a scene.

    Parameters
    ----------
    flat : FlatScene
    content_hash : str
        Kept with the result.
    aovs : tuple of str
        Further layers that the kernels must gather.
    structure : {"auto", "list", "bvh", "none"}
        How rays find surfaces; "list" tests every primitive (and runs in the NumPy twin), "none" is
        for those who send no rays.
    builder : {"sah", "median"}
        How the tree is divided.
    threads : int
        For building the BVH.
    emits : bool
        Make the tables of `alight.lights.emission.sampling`, which integrators that splat have
        anyway, and those with a guide where it is possible.
    kept : Kept, optional
        Of the compilation before: the tree is taken from there if all shapes are in their places.

    Raises
    ------
    SceneError
        If it does, and there is a light at which no light path can start.
    """
    kept = kept or Kept()
    given, flat = flat, displaced(flat, kept)
    stats = {"displaced": told(given, flat)} if given is not flat else {}
    packed = PackedMaterials(flat.bsdfs, light_textures(flat))
    space = _shapes_in_their_space(flat, UV_SETS in packed.texture_names, kept)
    flat, shapes, paths, origin = space.flat, space.shapes, space.paths, space.origin
    materials = packed.tables(origin)
    if ABSORBING in packed.bsdf_names:
        materials = with_bodies(materials, flat)
    endless = may_be_endless(flat, shapes)
    if endless:
        materials = with_ball(materials, shapes)
    accel, plan, of_accel = kept(
        f"{structure} by {builder}",
        partial(build_accelerator, structure=structure, builder=builder, threads=threads),
        shapes.triangles,
        shapes.analytic,
        shapes.unbounded,
        shapes.instances,
        shapes.geometries,
        shapes.moving,
        shapes.many,
    )
    of_light = light_motions(flat, shapes, paths)
    textures = Textures(materials, packed.texture_names)
    lights = _lights_for(flat, shapes, emits, kept, textures)
    tables = SceneTables(
        shapes=shapes.tables,
        materials=materials,
        lights=lights.tables,
        accel=accel,
        camera=compile_camera(flat.camera.camera, flat.camera.to_world, flat.film.size, origin),
        filter=compile_filter(flat.film.filter),
    )
    media, phases = (), ()
    if flat.media and flat.integrator.sees_media:
        of_media, media, phases = compile_media(flat, shapes)
        tables = SceneWithMedia(*tables, of_media)
    camera = paths.number(flat.camera.motion)
    motion = _what_moves(shapes.motions, of_light, camera)
    if motion:
        motion += (RIGID,) * paths.is_rigid
        motions = paths.tables(shapes.motions, of_light, camera)
        tables = (MovingWithMedia if media else MovingScene)(*tables, motions)
    program = Program(
        shapes=shapes.kinds,
        bsdfs=(*packed.bsdf_names, ENDLESS) if endless else packed.bsdf_names,
        textures=packed.texture_names,
        lights=lights.kinds,
        light_shapes=lights.shapes,
        single_light=lights.tables.info.size == LIGHT_INFO and not lights.has_tree,
        light_tree=lights.has_tree,
        accel=plan,
        camera=flat.camera.camera.type_name(),
        sampler=sampler_key(flat.sampler),
        filter=flat.film.filter.type_name(),
        integrator=flat.integrator.type_name(),
        options=compile_time_options(flat.integrator),
        aovs=aovs,
        media=media,
        phases=phases,
        motion=motion,
        registered=versions(described(given)),
        environments=lights.environments,
    )
    if flat.integrator.aims_at_lamps and structure != "none":
        tables = with_photons(program, tables, shapes.center, shapes.radius)
    return CompiledScene(
        tables=tables,
        program=program,
        size=flat.film.size,
        crop=flat.film.crop,
        content_hash=content_hash,
        integrator=flat.integrator,
        stats=of_accel | stats,
        small_view=small_view(flat.camera, flat.film.size) if flat.integrator.wants_guide else None,
        surfaces=surfaces_of(flat, shapes) if set(MATTES) & set(aovs) else None,
        ground=ground_of(flat, shapes, program, tables) if SHADOW in aovs else None,
        origin=origin,
        ball=space.ball,
        warnings=_warnings(given, space, lights.is_dark and EMISSIVE not in media),
    )


def _warnings(given: FlatScene, space: _Space, is_dark: bool) -> tuple[str, ...]:
    """All that is suspicious; given: the scene before its meshes were displaced."""
    flat = space.flat
    return (
        *flat.warnings,
        *flat.notes,
        *warnings_of_bodies(given),
        *warnings_of_edges(flat, space.shapes),
        *warnings_of_contacts(flat, space.origin),
        *warnings_of_sizes(flat, space.shapes),
        *_darkness(flat, is_dark),
    )


class _Space(NamedTuple):
    """A scene in rendering space: its shapes, the ball around them in the world, its motions."""

    flat: FlatScene
    shapes: CompiledShapes
    paths: MotionTable
    origin: NDArray[np.float64]
    ball: Ball | None


def _shapes_in_their_space(flat: FlatScene, uv_sets: bool, kept: Kept) -> _Space:
    """Compile the shapes where they are, and again around their middle if that is far away."""
    paths = MotionTable()
    shapes = compile_shapes(flat, paths, uv_sets=uv_sets, kept=kept)
    ball = Ball(shapes.center, shapes.radius) if shapes.extents else None
    origin = origin_for(flat, ball)
    if origin.any():
        flat, paths = in_rendering_space(flat, origin), MotionTable()
        shapes = compile_shapes(flat, paths, uv_sets=uv_sets, kept=kept)
    return _Space(flat, shapes, paths, origin, ball)


def _lights_for(
    flat: FlatScene, shapes: CompiledShapes, emits: bool, kept: Kept, textures: Textures
) -> CompiledLights:
    """The lights, with the tables that the scene's integrator needs."""
    integrator = flat.integrator
    own = "if possible" if integrator.way_of_guiding in ("on", "auto") else "never"
    return compile_lights(
        flat,
        shapes,
        integrator.choice_of_lights,
        compensated=integrator.combines,
        emits="always" if emits or integrator.splats else own,
        aims=integrator.aims_at_lamps,
        kept=kept,
        textures=textures,
    )


def _what_moves(of_shape: list[int], of_light: list[int], camera: int) -> tuple[str, ...]:
    """`Program.motion`."""
    found = {"shapes": any(of_shape), "lights": any(of_light), "camera": camera > 0}
    return tuple(name for name, moves in found.items() if moves)


def light_motions(flat: FlatScene, shapes: CompiledShapes, paths: MotionTable) -> list[int]:
    """Of each light, in the order of `compile_lights`, the number of its motion + 1."""
    shining = [
        shapes.motions[index]
        for index, row in enumerate(shapes.rows)
        if flat.shapes[row.source].light is not None
    ]
    surroundings = [0] * len(flat.environments)
    return shining + [paths.number(placed.motion) for placed in flat.lights] + surroundings


def _darkness(flat: FlatScene, is_dark: bool) -> tuple[str, ...]:
    """A warning for what only the pictures of textures and environments tell."""
    if flat.integrator.needs_light and is_dark and NO_LIGHT not in flat.warnings:
        return (NO_LIGHT,)
    return ()


#: Numbers of integrators that kernels are given while they run (`alight.integrators.walk`), and
#: what the tables and `Program.light_tree` say.
RUN_TIME = {"max_depth", "rr_depth", "distance", "light_choice", "guiding"}


def compile_time_options(integrator: Integrator) -> tuple[tuple[str, Any], ...]:
    """All fields of an integrator but those of `RUN_TIME`: they select and shape kernel text."""
    chosen = [(name, value) for name, value in integrator if name not in {"type", *RUN_TIME}]
    return tuple(sorted(chosen, key=lambda option: option[0]))
