"""Parts of kernels that pictures of the zoo do not tell from others, for given random numbers."""

from __future__ import annotations

from functools import partial
from typing import Any
from unittest import mock

import numpy as np

from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.vec import Vec3
from alight.formats import loads
from alight.guiding.lookup import child_of
from alight.guiding.parallax import Focus, focus_at, from_middle, from_point
from alight.guiding.tables import FOCUS, LEAF_ROW
from alight.laws.bodies import Body
from alight.lights.emission.density import emission_density
from alight.lights.shining import sample_area, sample_shape
from alight.rendering.tracing import contribution_recorder
from alight.scene import flatten
from alight.scene.transform import Transform, rotate, scale, translate
from alight.shapes import MODELS
from alight.shapes.model import SHAPES
from lanewise.jit import instantiate
from lanewise.view import View
from tests.recorded.cases import zoo_lights, zoo_transport
from tests.recorded.cases.mathematics import N, directions, uniform
from tests.recorded.cases.trees import ends_of, parts_of
from tests.recorded.cases.zoo_guides import by_twin
from tests.recorded.zoo import SEED

#: Slanted and stretched, and mirrored.
PLACED: Transform = translate(0.3, -0.7, 0.5) @ rotate((1, 2, 3), 40) @ scale(0.7, -1.3, 1.1)


def _run(text: Any, *values: Any, program: Any = None) -> Any:
    with np.errstate(all="ignore"):
        return instantiate(text, program, compiled=False, lanes=N)(*values)


def _rows(*values: Any) -> list[Any]:
    """Numbers and vectors, lane by lane."""
    flat = [c for v in values for c in ((v.x, v.y, v.z) if isinstance(v, Vec3) else (v,))]
    found = [np.broadcast_to(v, N) for v in flat]
    return [np.where(np.isfinite(v), v, -1.0) if v.dtype.kind == "f" else v for v in found]


def guide() -> dict[str, Any]:
    """Quadrants that are divided further, and directions as the middle of a leaf sees them."""
    words = np.arange(16, dtype=np.uint32) + (5 << 4)
    children = [
        _run(child_of, np.resize(words, N), np.full(N, place, np.uint32))[:16] for place in range(4)
    ]
    leaves = uniform(3 * LEAF_ROW, 21, 0.2, 1.9)[:, 0]
    number = np.arange(N, dtype=np.uint32) % 3
    p, w = Vec3(*uniform(3, 22, -0.9, 2.6)), directions(23)
    table = type("Guide", (), {"leaves": View(np.ascontiguousarray(leaves))})()
    focus = _run(focus_at, table, number, p)
    found = Focus(focus.o, focus.r)
    middle = np.stack([leaves[i * LEAF_ROW + FOCUS :][:4] for i in range(3)])
    return {
        "children": children, "middles": middle, "focus": _rows(*focus),
        "from middle": _rows(*_run(from_middle, found, w)),
        "from point": _rows(*_run(from_point, found, w)),
    }  # fmt: skip


def _compiled(text: str, **options: Any) -> CompiledScene:
    return compile_scene(flatten(loads(text, "zoo.yaml")), structure="list", **options)


def emission(name: str) -> dict[str, Any]:
    """Tables of lights from which paths start, and densities of their rays."""
    found = _compiled(zoo_lights.SCENES[name], emits="always")
    lights = found.tables.lights
    count = int(parts_of(lights.starts)[0].size)
    index = (np.arange(N) % count).astype(np.uint32)
    values = index, Vec3(*uniform(3, 31, -1.5, 1.5)), directions(32), uniform(1, 33, 0.2, 3.0)[0]
    pdf = _run(emission_density, found.tables, *values, program=found.program)
    tables = {key: [ends_of(part) for part in parts_of(getattr(lights, key))]
              for key in ("emission", "starts", "per_area")}  # fmt: skip
    return {"densities": _rows(pdf), "tables": tables}


def by_area(number: int) -> dict[str, Any]:
    """Points chosen by area on a shape that is stretched and mirrored, with their densities."""
    body = Body(MODELS[number].EXAMPLES[0], PLACED)
    u, u2 = uniform(1, 41)[0], tuple(uniform(2, 42))
    shape = (np.arange(N) % len(body.shapes.rows)).astype(np.uint32)
    start = body.scene.lights.info.array.reshape(-1, 4)[shape, 3]
    lamps, cdf = body.scene.shapes, body.scene.lights.cdf
    s = body.run(sample_area, lamps, cdf, start, shape, u, u2)
    away = (2.0 * body.radius * uniform(3, 43, -1.0, 1.0)).astype(np.float32)
    p = Vec3(*(away + body.center.astype(np.float32)[:, None]))
    seen = body.run(sample_shape, lamps, cdf, start, shape, p, u, u2)
    return {"by area": _rows(s.p, s.u, s.v, s.prim, s.pdf), "from a point": _rows(*seen)}


def contributions(name: str) -> dict[str, Any]:
    """How light was found, path by path."""
    with mock.patch.object(contribution_recorder, "instantiate", by_twin):
        recorder = contribution_recorder.Recorder(_compiled(zoo_transport.SCENES[name]))
    found, picture = recorder.run(2, SEED, 2)
    return {key: ends_of(value) for key, value in found._asdict().items()} | {
        "sums": picture.sum(axis=(0, 1))
    }


CASES = (
    {"guide": guide}
    | {f"emission-{name}": partial(emission, name) for name in ("shapes", "beams", "many-tree")}
    | {
        f"by-area-{model.__name__.rpartition('.')[2]}": partial(by_area, number)
        for number, model in enumerate(MODELS)
        if SHAPES[model.EXAMPLES[0].type_name()].sample_area is not None
    }
    | {f"contributions-{name}": partial(contributions, name) for name in ("nested", "moving")}
)
