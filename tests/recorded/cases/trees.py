"""Trees over shapes: their tables, and pictures that the NumPy twin makes with them."""

from functools import partial

import numpy as np

from alight.compiled.scene import CompiledScene, compile_scene
from alight.films import fixed_point
from alight.formats import loads
from alight.scene import flatten
from tests.recorded.cases import zoo_shapes
from tests.recorded.cases.zoo_materials import GEM
from tests.recorded.cases.zoo_transport import MOVING
from tests.recorded.zoo import FLOOR, SEED, STAGE, scene
from tests.twin import film_of

_CLAY = "{type: diffuse, reflectance: [0.7, 0.4, 0.3]}"
#: A mesh that is in the scene often enough to be kept once.
CROWD = "".join(
    f"\n  copy {i}: {{instance: gem, transform: [{{scale: {0.2 + 0.03 * i}}}, "
    f"{{rotate: {{axis: [1, 0.2, {0.1 * i}], angle: {37 * i}}}}}, "
    f"{{translate: [{-1.4 + 0.41 * i}, {0.4 + 0.3 * (i % 3)}, {0.5 - 0.3 * (i % 4)}]}}]}}"
    for i in range(8)
)
WAVES = """
  water:
    shape: {type: mesh, file: "builtin:waves"}
    bsdf: {type: rough_conductor, alpha: 0.2}
    transform: [{scale: 0.25}, {rotate: {axis: [1, 0.2, 0], angle: -20}}, {translate: [0.2, 0.2, -0.8]}]
"""  # noqa: E501
SCENES = {
    "shapes": scene(STAGE + zoo_shapes.ROUND + zoo_shapes.FLAT),
    "hills": scene(STAGE + zoo_shapes.HILLS + zoo_shapes.ROUND),
    "strands": scene(STAGE + zoo_shapes.STRANDS % ("b_spline", "catmull_rom")),
    "copies": scene(STAGE + zoo_shapes.COPIES + CROWD, prototypes=zoo_shapes.TOOL + GEM % _CLAY),
    "moving": scene(FLOOR + MOVING + GEM % _CLAY),
}


def compiled(name: str, builder: str) -> CompiledScene:
    """With everything that has bounds in the tree."""
    return compile_scene(flatten(loads(SCENES[name], "zoo.yaml")), structure="bvh", builder=builder)


def tables(name: str, builder: str) -> dict[str, object]:
    """Every table of a tree: of long ones the ends, and sums that depend on the order."""
    found = compiled(name, builder)
    answer: dict[str, object] = {"plan": found.program.accel}
    counts = ("triangles", "listed", "nodes", "blocks", "leaves", "depth", "sah_cost")
    answer |= {name: found.stats[name] for name in counts}
    for field, table in found.tables.accel._asdict().items():
        answer |= {f"{field}{k}": ends_of(part) for k, part in enumerate(parts_of(table))}
    return answer


def parts_of(table: object) -> list[np.ndarray]:
    """The arrays of a table, or of a tuple of them, flat."""
    if isinstance(table, tuple):
        return [array for part in table for array in parts_of(part)]
    return [np.ravel(getattr(table, "array", table))]


def ends_of(array: np.ndarray) -> dict[str, object]:
    """How an array begins and ends, and a sum that depends on the order."""
    array = np.ravel(array)
    if array.dtype.kind in "ui":
        array = array.astype(np.int64)
    known = np.isfinite(array) & (np.abs(array) < 1e30)
    order = 1.0 + np.arange(array.size) % 97
    total = float(np.where(known, array, 0).astype(float) @ order)
    return {"size": array.size, "begins": array[:32], "ends": array[-16:], "sum": total}


def picture(name: str) -> np.ndarray:
    """Mean radiance (height, width, 3)."""
    found = compile_scene(flatten(loads(MESHES[name], "zoo.yaml")), structure="bvh")
    return fixed_point.to_float(film_of(found, 1, SEED, 1).sums)[:, :, 0]


#: The twin follows rays through trees of triangles.
BOARD = """
  board:
    bsdf: {type: diffuse, reflectance: [0.3, 0.5, 0.4]}
    shape: {type: mesh, vertices: [[-3, -0.1, -3], [-2.8, 0.1, 3], [3.1, 0, 2.9], [2.9, -0.2, -3.1]], faces: [[0, 1, 2], [0, 2, 3]]}
"""  # noqa: E501
MESHES = {
    "meshes": scene(BOARD + zoo_shapes.HILLS + GEM % _CLAY),
    "copies": scene(BOARD + CROWD, prototypes=GEM % _CLAY),
}

CASES = {
    f"tables/{name}-{builder}": partial(tables, name, builder)
    for name in SCENES
    for builder in ("sah", "median")
} | {f"pictures/{name}": partial(picture, name) for name in MESHES}
