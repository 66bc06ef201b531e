"""What decides a picture, as bytes, and its hash: the identity of films."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator

from alight.core.registry import versions
from alight.core.spec import Spec
from alight.scene.description import Scene
from alight.scene.flatten import FlatScene, PlacedCamera, PlacedLight, PlacedShape, flatten
from alight.shapes.arrays import ARRAYS, DISPLACEMENT, in_words, is_displaced


def content_hash(scene: Scene | FlatScene) -> str:
    """SHA-256 over everything that decides the picture, meshes by content, not by file name.

    Names of nodes, materials and files play no part, nor do parts that are not used.

    Raises
    ------
    SceneError
        If the scene cannot be rendered.
    """
    flat = flatten(scene) if isinstance(scene, Scene) else scene
    return hash_of(content_parts(flat))


def hash_of(parts: Iterable[bytes]) -> str:
    """SHA-256 over `content_parts`."""
    return hashlib.sha256(b"".join(part + b"\n" for part in parts)).hexdigest()


def described(flat: FlatScene) -> Iterator[Spec]:
    """Every description of a model that a scene uses."""
    yield from (flat.film.filter, flat.sampler, flat.integrator, flat.camera.camera)
    yield from flat.bsdfs
    yield from flat.media
    yield from (placed.shape for placed in flat.shapes)
    yield from (placed.light for placed in flat.lights)
    yield from (shape.light for shape in flat.shapes if shape.light is not None)
    yield from (placed.light for placed in flat.environments)


def content_parts(flat: FlatScene) -> Iterator[bytes]:
    """Everything that decides the picture, in parts; the camera is one of them."""
    registered = versions(described(flat))
    if registered:
        yield repr(registered).encode()
    for settings in (flat.film, flat.sampler, flat.integrator):
        yield _content(settings)
    yield camera_part(flat.camera)
    yield b"|".join(_placed_content(placed) for placed in flat.environments)
    for bsdf in flat.bsdfs:
        yield _content(bsdf)
    for mesh in flat.geometries:
        yield mesh.digest.encode()
    for light in flat.lights:
        yield _placed_content(light)
    cached: dict[int, bytes] = {}
    for shape in flat.shapes:
        if id(shape.shape) not in cached:
            cached[id(shape.shape)] = _content(shape.shape)
        light = b"" if shape.light is None else _content(shape.light)
        numbers = f"{shape.bsdf} {shape.geometry} ".encode()
        yield cached[id(shape.shape)] + numbers + light + shape.to_world.tobytes() + _moved(shape)
    # Nothing where there are no media: pictures from before there were any keep their hash.
    if flat.media:
        borders = [shape.border for shape in flat.shapes]
        yield f"{flat.start_medium} {borders}".encode()
        yield from (_content(medium) for medium in flat.media)


def camera_part(placed: PlacedCamera) -> bytes:
    """The part of the camera."""
    return _content(placed.camera) + placed.to_world.tobytes() + _moved(placed)


def _placed_content(placed: PlacedLight) -> bytes:
    return _content(placed.light) + placed.to_world.tobytes() + _moved(placed)


def _moved(placed: PlacedShape | PlacedLight | PlacedCamera) -> bytes:
    """What it does while the shutter is open: nothing where it rests, whatever the shutter."""
    return b"" if placed.motion is None else placed.motion.content


def _content(spec: Spec) -> bytes:
    """Describe a model without the arrays of meshes, which have a digest of their own."""
    left_out = (*ARRAYS, "file", "medium", "shutter")
    # Meshes from before there was any displacement keep their hash.
    if not is_displaced(spec):
        left_out += DISPLACEMENT
    fields = {name: in_words(value) for name, value in spec if name not in left_out}
    return json.dumps(fields, sort_keys=True).encode()
