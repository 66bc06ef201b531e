"""Places that a document looks its pictures up at, and how brushes stretch what they reflect.

Source: MaterialX 1.39, the library's node graphs; specifications of UsdPreviewSurface (2.6), of
Standard Surface (1.0.1) and of OpenPBR (1.1).
"""

import math

import numpy as np
import pytest

from tests.formats.materialx.reading import link, material, node, picture, value

#: Nodes of coordinates by double entry (decision 38).
NODES = (
    "place2d", "place2d the other way", "rotate2d", "add", "subtract", "subtract from", "multiply",
    "divide", "UsdTransform2d",
)  # fmt: skip


def turned(degrees):
    """As ``rotate2d`` turns coordinates, so that a picture turns the other way."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[c, s], [-s, c]])


def pair(name, numbers):
    return value(name, "vector2", ", ".join(f"{x:.9g}" for x in numbers))


def placing(kind, rng):
    """Category and inputs of a node, the name of its coordinates, and what it makes of (n, 2)."""
    a, b, c = rng.uniform(0.3, 2.0, (3, 2))
    angle = rng.uniform(-180.0, 180.0)
    if kind.startswith("place2d"):
        order = int("other" in kind)
        words = [pair("pivot", a), pair("scale", b), pair("offset", c)]
        words += [value("rotate", "float", angle), value("operationorder", "integer", order)]

        def place(x):
            x = x - a
            x = (x - c) @ turned(angle).T / b if order else (x / b) @ turned(angle).T - c
            return x + a

        return "place2d", words, "texcoord", place
    if kind == "rotate2d":
        return kind, [value("amount", "float", angle)], "in", lambda x: x @ turned(angle).T
    if kind == "UsdTransform2d":
        words = [pair("scale", a), value("rotation", "float", angle), pair("translation", b)]
        return kind, words, "in", lambda x: (x * a) @ turned(-angle).T + b
    if kind == "subtract from":
        return "subtract", [pair("in1", a)], "in2", lambda x: a - x
    simple = {"add": np.add, "subtract": np.subtract, "multiply": np.multiply, "divide": np.divide}
    return kind, [pair("in2", a)], "in1", lambda x: simple[kind](x, a)


def matrix_in(data):
    """The matrix of the only picture of a description."""
    if isinstance(data, dict) and data.get("type") == "bitmap":
        return np.array(data["to_uv"]["matrix"])
    for part in data.values() if isinstance(data, dict) else ():
        found = matrix_in(part)
        if found is not None:
            return found
    return None


@pytest.mark.parametrize("kind", NODES)
def test_nodes_of_coordinates_are_their_formulas_one_after_the_other(kind, tmp_path):
    rng = np.random.default_rng(len(kind))
    after = NODES[NODES.index(kind) - 1]
    nodes, last, x = [node("texcoord", "C", "vector2")], "C", rng.uniform(-1.0, 2.0, (5, 2))
    wanted = x
    for i, one in enumerate((kind, after)):
        category, words, name, place = placing(one, rng)
        nodes.append(node(category, f"N{i}", "vector2", *words, link(name, "vector2", last)))
        last, wanted = f"N{i}", place(wanted)
    shown = picture("p", "color3", link("texcoord", "vector2", last))
    data, _ = material(link("base_color", "color3", "p"), tmp_path, *nodes, shown)
    matrix = matrix_in(data)
    np.testing.assert_allclose(x @ matrix[:, :2].T + matrix[:, 2], wanted, atol=1e-6)


@pytest.mark.parametrize(
    "category", ["place2d", "rotate2d", "add", "subtract", "multiply", "divide", "UsdTransform2d"]
)
def test_a_node_that_says_nothing_leaves_coordinates_as_they_are(category, tmp_path):
    name = {"place2d": "texcoord", "rotate2d": "in", "UsdTransform2d": "in"}.get(category, "in1")
    nodes = [node("texcoord", "C", "vector2"),
             node(category, "N", "vector2", link(name, "vector2", "C"))]  # fmt: skip
    shown = picture("p", "color3", link("texcoord", "vector2", "N"))
    data, _ = material(link("base_color", "color3", "p"), tmp_path, *nodes, shown)
    assert "to_uv" not in str(data)


def test_tiles_are_scaled_moved_and_measured(tmp_path):
    rng = np.random.default_rng(2)
    tiling, offset, image, tile = rng.uniform(0.3, 2.0, (4, 2))
    names = ("uvtiling", "uvoffset", "realworldimagesize", "realworldtilesize")
    words = [pair(n, v) for n, v in zip(names, (tiling, offset, image, tile), strict=True)]
    file = value("file", "filename", "a.png")
    shown = node("tiledimage", "p", "color3", file, *words)
    data, _ = material(link("base_color", "color3", "p"), tmp_path, shown)
    x = rng.uniform(-1.0, 2.0, (5, 2))
    matrix = matrix_in(data)
    wanted = (x * tiling - offset) / image * tile
    np.testing.assert_allclose(x @ matrix[:, :2].T + matrix[:, 2], wanted, atol=1e-6)


def widths(core):
    """Roughness of the facets along the brush and across it, as `principled` and glTF have it."""
    across = core["roughness"] ** 2
    return across + (1.0 - across) * core["anisotropy"] ** 2, across


@pytest.mark.parametrize("strength", [0.2, 0.7])
@pytest.mark.parametrize("roughness", [0.2, 0.6])
def test_brushes_stretch_facets_as_their_shader_says(roughness, strength, tmp_path):
    alpha, turn = roughness**2, 0.15
    words = [
        value("specular_roughness", "float", roughness), value("base_color", "color3", "1, 1, 1"),
        value("specular_anisotropy", "float", strength), value("specular_rotation", "float", turn),
    ]  # fmt: skip
    core = material("".join(words), tmp_path)[0]["bsdf"]
    aspect = math.sqrt(1.0 - strength)
    assert widths(core) == pytest.approx((alpha / aspect, alpha * aspect))
    assert core["anisotropy_rotation"] == pytest.approx(2.0 * math.pi * turn)
    words = [
        value("specular_roughness", "float", roughness),
        value("specular_roughness_anisotropy", "float", strength),
    ]
    core = material("".join(words), tmp_path, category="open_pbr_surface")[0]["bsdf"]
    along = alpha * math.sqrt(2.0 / (1.0 + (1.0 - strength) ** 2))
    assert widths(core) == pytest.approx((along, (1.0 - strength) * along))
