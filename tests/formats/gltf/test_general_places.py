"""Places in general position: chains deeper than ours may be, and what has no matrix of its own."""

import math

import numpy as np
import pytest

from alight.formats.gltf.nodes import DEEPEST
from alight.scene.flatten import flatten
from tests.formats import bare
from tests.formats.gltf.maker import POINTS, Maker
from tests.formats.gltf.test_animations import animated, points_at
from tests.formats.gltf.test_bodies import look


def some_node(rng):
    """Keys of a node in general position, and its matrix."""
    shift, scale = rng.uniform(-1.0, 1.0, 3), rng.uniform(0.5, 1.5, 3)
    x, y, z, w = turn = rng.normal(size=4)
    # Hamilton's product q v q*, written as a matrix.
    whole = np.array([[w, -z, y], [z, w, -x], [-y, x, w]]) @ np.array(
        [[w, -z, y], [z, w, -x], [-y, x, w]]
    ) + np.outer([x, y, z], [x, y, z])
    matrix = np.eye(4)
    matrix[:3, :3] = whole / (turn @ turn) * scale
    matrix[:3, 3] = shift
    if rng.random() < 0.3:
        return {"matrix": matrix.T.ravel().tolist()}, matrix
    return {
        "translation": shift.tolist(), "rotation": (turn / np.linalg.norm(turn)).tolist(),
        "scale": scale.tolist(),
    }, matrix  # fmt: skip


@pytest.mark.parametrize("deep", [2, DEEPEST, DEEPEST + 1, DEEPEST + 6])
def test_every_node_of_a_chain_stands_where_the_product_says(deep, tmp_path):
    """With a mesh at each, also where nodes are multiplied together."""
    rng, m, product, wanted = np.random.default_rng(109), Maker(), np.eye(4), []
    for number in range(deep + 1):
        keys, matrix = some_node(rng)
        m.node(mesh=m.square(), name=f"n{number}", children=[number + 1], **keys)
        product = product @ matrix
        wanted.append(product)
    del m.json["nodes"][-1]["children"]
    m.json |= {"scene": 0, "scenes": [{"nodes": [0]}]}
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    placed = flatten(bare.load(tmp_path / "a.gltf")).shapes
    found = {shape.name.split("/")[-1]: shape.to_world for shape in placed}
    assert len(found) == deep + 1
    for number, matrix in enumerate(wanted):
        np.testing.assert_allclose(
            found[f"n{number}"], matrix, rtol=1e-5, atol=1e-5 * np.abs(matrix).max()
        )


def test_targets_of_a_node_with_a_matrix_are_animated(tmp_path):
    """Its place cannot be; the weights of its mesh can."""
    m = Maker()
    square = m.square()
    target = {"POSITION": m.accessor(np.full((4, 3), 1.0, "<f4"))}
    m.json["meshes"][square]["primitives"][0]["targets"] = [target]
    matrix = np.eye(4)
    matrix[:3, 3] = 1.0, 2.0, 3.0
    node = m.node(mesh=square, matrix=matrix.T.ravel().tolist())
    animated(m, (node, "weights", [0, 1], [0.0, 1.0], "LINEAR"))
    found = points_at(m, 0.25, tmp_path)
    np.testing.assert_allclose(found, np.add(POINTS, [1.25, 2.25, 3.25]), atol=1e-6)


@pytest.mark.parametrize("strength", [0.25, 1.0])
@pytest.mark.parametrize("index", [1.2, 1.8])
def test_the_reflection_of_a_body_is_that_of_its_index_by_its_strength(index, strength, tmp_path):
    extensions = {
        "KHR_materials_ior": {"ior": index},
        "KHR_materials_specular": {"specularFactor": strength},
    }
    found, _ = look(tmp_path, extensions=extensions)
    straight_on = strength * ((index - 1.0) / (index + 1.0)) ** 2
    assert found.ior == pytest.approx((1 + math.sqrt(straight_on)) / (1 - math.sqrt(straight_on)))
