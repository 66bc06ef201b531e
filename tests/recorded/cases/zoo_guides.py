"""Guides after training, and pictures with them, by the NumPy twin."""

from dataclasses import replace
from functools import partial
from unittest import mock

import numpy as np

from alight.compiled.scene import compile_scene
from alight.films import fixed_point
from alight.formats import loads
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.rendering.training import guide_training, trainer
from alight.scene import flatten
from lanewise.jit import instantiate
from tests.recorded.cases.trees import ends_of
from tests.recorded.cases.zoo_lights import LENS, ROOM, SKY, SOURCES
from tests.recorded.cases.zoo_transport import MASKS, MEDIA
from tests.recorded.zoo import LAMP, SEED, scene

_FILM = "{size: [10, 6]}"
SCENES = {
    "room": scene(ROOM + LENS + MASKS + SOURCES + LAMP, film=_FILM, environment=SKY % "",
        integrator='{type: path, max_depth: 6, guiding: "on"}'),
    "camera": scene(ROOM + LENS + SOURCES, film=_FILM,
        integrator='{type: path, max_depth: 5, guiding: camera, light_sampling: bsdf}'),
    "fog": scene(ROOM + LAMP, film=_FILM, medium="fog", media=MEDIA,
        integrator='{type: volpath, max_depth: 5, guiding: "on"}'),
}  # fmt: skip


def by_twin(text, program=None, **options):
    """`instantiate` of the twin, with packets that cost little."""
    kernel = instantiate(text, program, compiled=False, lanes=256)
    return np.errstate(all="ignore")(kernel)


def guided(name: str, rounds: int = 5) -> dict[str, object]:
    """What a guide has learnt after some rounds, and the picture with it."""
    described = compile_scene(
        flatten(loads(SCENES[name], "zoo.yaml")), structure="list", aovs=("guide_share",)
    )
    small = replace(described, small_view=described.small_view._replace(size=(10, 6)))
    with mock.patch.object(trainer, "instantiate", by_twin):
        scene_with_guide, training = guide_training.trained(
            small, seed=SEED, threads=1, rounds=rounds
        )
    guide = scene_with_guide.guide
    values = make_settings(described.integrator, seed=SEED, replicates=1, guide=guide)
    tile = Tile(0, 0, *described.size)
    kernels = make_kernels(scene_with_guide, compiled=False)
    film, rays = render_tile(kernels, scene_with_guide, values, tile, np.array([[[0, 4], [0, 4]]]))
    fixed_point.carry(film.sums)
    answer = {key: getattr(training, key) for key in ("paths", "vertices", "arrivals", "gain")}
    answer |= {name: ends_of(table.array) for name, table in guide._asdict().items()}
    share = film.aovs["guide_share"]
    fixed_point.carry(share)
    return answer | {
        "rays": rays,
        "picture": fixed_point.to_float(film.sums)[:, :, 0] / 4,
        "guide_share": fixed_point.to_float(share) / 4,
    }


CASES = {name: partial(guided, name) for name in SCENES}
