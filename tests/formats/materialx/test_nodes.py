"""Nodes of MaterialX: constants are folded, textures and pictures show what the nodes compute."""

import math

import numpy as np
import pytest

from alight.core.fields import Model
from alight.core.srgb import decode_srgb
from alight.scene.build import Builder
from tests.formats.materialx.reading import (
    TEXELS,
    core,
    document,
    link,
    material,
    node,
    parsed,
    picture,
    problem,
    texels,
    value,
)

LINEAR = decode_srgb(TEXELS / 255.0)


def base(folder, *nodes, of="x", kind="color3", head=""):
    """The colour that a standard surface gets from a node, and what was said."""
    bsdf, said = material(link("base_color", kind, of), folder, *nodes, head=head)
    return core(bsdf)["base_color"], said


@pytest.mark.parametrize(
    ("category", "inputs", "meant"),
    [
        ("add", (0.25, 0.5), 0.75),
        ("multiply", (0.25, 0.5), 0.125),
        ("subtract", (0.75, 0.5), 0.25),
        ("divide", (0.25, 0.5), 0.5),
        ("power", (0.25, 0.5), 0.5),
        ("min", (0.25, 0.5), 0.25),
        ("max", (0.25, 0.5), 0.5),
        ("modulo", (0.75, 0.5), 0.25),
    ],
)
def test_numbers_are_folded(category, inputs, meant, tmp_path):
    both = [value(f"in{i + 1}", "color3", f"{x}, {x}, {x}") for i, x in enumerate(inputs)]
    found, _ = base(tmp_path, node(category, "x", "color3", *both))
    assert found == pytest.approx([meant] * 3)


def test_nodes_with_other_inputs_are_folded(tmp_path):
    color = value("in", "color3", "0.2, 0.4, 0.6")
    found, _ = base(tmp_path, node("invert", "x", "color3", color))
    assert found == pytest.approx([0.8, 0.6, 0.4])
    ends = "".join(value(k, "float", v) for k, v in (("inlow", 0.2), ("inhigh", 0.6)))
    found, _ = base(tmp_path, node("remap", "x", "color3", color, ends))
    assert found == pytest.approx([0.0, 0.5, 1.0])
    hsv = node("rgbtohsv", "y", "color3", color)
    found, _ = base(tmp_path, hsv, node("hsvtorgb", "x", "color3", link("in", "color3", "y")))
    assert found == pytest.approx([0.2, 0.4, 0.6])
    turned = value("amount", "vector3", "0.3333333, 1, 1")
    found, _ = base(tmp_path, node("hsvadjust", "x", "color3", color, turned))
    assert found == pytest.approx([0.6, 0.2, 0.4], abs=1e-6)
    found, _ = base(tmp_path, node("saturate", "x", "color3", color, value("amount", "float", 0)))
    assert found == pytest.approx([0.2722287 * 0.2 + 0.6740818 * 0.4 + 0.0536895 * 0.6] * 3)


def test_pictures_keep_their_colour_space_and_edges(tmp_path):
    edges = value("uaddressmode", "string", "clamp"), value("filtertype", "string", "closest")
    found, _ = base(tmp_path, picture("x", "color3", *edges))
    meant = {"type": "bitmap", "file": "a.png", "color_space": "srgb", "wrap": "clamp",
             "wrap_v": "repeat", "interpolation": "nearest"}  # fmt: skip
    assert found == meant
    found, _ = base(tmp_path, picture("x", space=""))
    assert found["color_space"] == "linear"
    found, _ = base(tmp_path, picture("x", space=""), head=' colorspace="srgb_texture"')
    assert found["color_space"] == "srgb"


def test_sums_and_products_become_textures(tmp_path):
    half = value("in2", "color3", "0.5, 0.25, 0.125")
    product = node("multiply", "x", "color3", link("in1", "color3", "p"), half)
    found, _ = base(tmp_path, picture(), product)
    assert found["type"] == "multiply"
    np.testing.assert_allclose(texels(found, tmp_path), LINEAR * [0.5, 0.25, 0.125], atol=1e-6)
    both = node("multiply", "x", "color3", link("in1", "color3", "p"), link("in2", "color3", "p"))
    found, _ = base(tmp_path, picture(), both)
    np.testing.assert_allclose(texels(found, tmp_path), LINEAR**2, atol=1e-6)
    less = node("subtract", "x", "color3", value("in1", "color3", "1, 1, 1"),
                link("in2", "color3", "p"))  # fmt: skip
    found, _ = base(tmp_path, picture(), less)
    np.testing.assert_allclose(texels(found, tmp_path), 1.0 - LINEAR, atol=1e-6)


def test_mixtures_by_a_mask(tmp_path):
    mask = picture("m", "float")
    ends = value("fg", "color3", "1, 0, 0.5"), value("bg", "color3", "0, 1, 0.5")
    found, _ = base(tmp_path, mask, node("mix", "x", "color3", *ends, link("mix", "float", "m")))
    share = TEXELS[..., :1] / 255.0
    meant = share * [1.0, 0.0, 0.5] + (1.0 - share) * [0.0, 1.0, 0.5]
    np.testing.assert_allclose(texels(found, tmp_path), meant, atol=1e-6)
    two = link("fg", "color3", "p"), value("bg", "color3", "0, 0, 1"), link("mix", "float", "m")
    found, _ = base(tmp_path, picture(), mask, node("mix", "x", "color3", *two))
    assert found["type"] == "mix"
    meant = share * LINEAR + (1.0 - share) * [0.0, 0.0, 1.0]
    np.testing.assert_allclose(texels(found, tmp_path), meant, atol=1e-6)


@pytest.mark.parametrize(
    ("category", "inputs", "function"),
    [
        ("power", value("in2", "float", 2), lambda x: x**2),
        ("smoothstep", "", lambda x: x * x * (3 - 2 * x)),
        ("contrast", value("amount", "float", 3), lambda x: np.clip(3 * (x - 0.5) + 0.5, 0, 1)),
        ("clamp", value("low", "float", 0.2) + value("high", "float", 0.6),
         lambda x: np.clip(x, 0.2, 0.6)),
        ("range", value("gamma", "float", 2), np.sqrt),
    ],
)  # fmt: skip
def test_other_nodes_compute_the_picture_anew(category, inputs, function, tmp_path):
    name = "in1" if category == "power" else "in"
    found, said = base(
        tmp_path, picture(), node(category, "x", "color3", link(name, "color3", "p"), inputs)
    )
    np.testing.assert_allclose(texels(found, tmp_path), function(LINEAR), atol=1e-5)
    assert not any("left out" in line for line in said)


def test_pictures_that_lie_differently_are_not_computed_anew(tmp_path):
    moved = node("place2d", "t", "vector2", value("scale", "vector2", "2, 2"))
    other = picture("q", "color3", link("texcoord", "vector2", "t"))
    less = node("difference", "x", "color3", link("fg", "color3", "p"), link("bg", "color3", "q"))
    found, said = base(tmp_path, picture(), moved, other, less)
    assert found["file"] == "a.png"
    assert any('"difference" is left out' in line for line in said)


def test_long_chains_become_one_picture(tmp_path):
    chain = [picture("x0")]
    for i in range(60):
        both = [link(f"in{k}", "color3", f"x{i}") for k in (1, 2)]
        chain.append(node("multiply", f"x{i + 1}", "color3", *both))
    found, _ = base(tmp_path, *chain, of="x3")
    np.testing.assert_allclose(texels(found, tmp_path), LINEAR**8, atol=1e-5)
    found, said = base(tmp_path, *chain, of="x60")
    assert not any("left out" in line for line in said)
    # White stays white; all else has become black.
    assert np.array_equal(texels(found, tmp_path) > 0.5, LINEAR == 1.0)


@pytest.mark.parametrize(("count", "message"), [(70, ""), (300, "more than 80 nodes")])
def test_deep_networks_are_read_or_refused(count, message, tmp_path):
    one = value("in2", "color3", "0.001, 0, 0")
    chain = [node("constant", "x0", "color3", value("value", "color3", "0.1, 0.2, 0.3"))]
    chain += [
        node("add", f"x{i + 1}", "color3", link("in1", "color3", f"x{i}"), one)
        for i in range(count)
    ]
    if message:
        text = document(link("base_color", "color3", f"x{count}"), *chain)
        assert message in problem(text, tmp_path)
    else:
        found, _ = base(tmp_path, *chain, of=f"x{count}")
        assert found == pytest.approx([0.17, 0.2, 0.3])


def test_coordinates_that_come_from_themselves(tmp_path):
    turned = node("place2d", "t", "vector2", link("texcoord", "vector2", "t"))
    found, said = base(tmp_path, turned, picture("x", "color3", link("texcoord", "vector2", "t")))
    assert "to_uv" not in found
    assert any("from themselves" in line for line in said)


def test_channels_are_taken_apart_and_put_together(tmp_path):
    apart = node("separate3", "s", "multioutput", link("in", "color3", "p"))
    swapped = node("combine3", "x", "color3", *(
        link(f"in{i + 1}", "float", "s", f' output="out{c}"') for i, c in enumerate("bgr")
    ))  # fmt: skip
    found, _ = base(tmp_path, picture(), apart, swapped)
    np.testing.assert_allclose(texels(found, tmp_path), LINEAR[..., ::-1], atol=1e-6)
    same = swapped.replace("outb", "outx").replace("outr", "outb").replace("outx", "outr")
    found, _ = base(tmp_path, picture(), apart, same)
    assert found["type"] == "bitmap"
    one = node("extract", "x", "float", link("in", "color3", "p"), value("index", "integer", 1))
    found, _ = base(tmp_path, picture(), one)
    np.testing.assert_allclose(texels(found, tmp_path), LINEAR[..., [1]].repeat(3, 2), atol=1e-6)


def uv_at(texture, point):
    """Where a texture is looked up, from (u, v)."""
    matrix = np.array(texture["to_uv"]["matrix"])
    return matrix @ [*point, 1.0]


def test_coordinates_go_through_place2d_as_its_graph_says(tmp_path):
    inputs = [
        value("pivot", "vector2", "0.5, 0.25"), value("scale", "vector2", "2, 4"),
        value("rotate", "float", 30), value("offset", "vector2", "0.1, 0.2"),
    ]  # fmt: skip
    for order in (0, 1):
        more = value("operationorder", "integer", order)
        placed = node("place2d", "t", "vector2", *inputs, more)
        found, _ = base(tmp_path, placed, picture("x", "color3", link("texcoord", "vector2", "t")))
        c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
        turn = np.array([[c, s], [-s, c]])
        at = np.array([0.9, 0.3]) - [0.5, 0.25]
        if order == 0:
            meant = turn @ (at / [2, 4]) - [0.1, 0.2] + [0.5, 0.25]
        else:
            meant = (turn @ (at - [0.1, 0.2])) / [2, 4] + [0.5, 0.25]
        np.testing.assert_allclose(uv_at(found, (0.9, 0.3)), meant, atol=1e-6)


def test_tiled_images_and_scaled_coordinates(tmp_path):
    inputs = value("uvtiling", "vector2", "3, 2") + value("uvoffset", "vector2", "0.5, 0.25")
    tiled = picture("x", "color3", inputs).replace("<image", "<tiledimage")
    tiled = tiled.replace("</image", "</tiledimage")
    found, _ = base(tmp_path, tiled)
    np.testing.assert_allclose(uv_at(found, (0.5, 0.5)), [1.0, 0.75])
    uv = node("texcoord", "t", "vector2")
    double = node("multiply", "d", "vector2", link("in1", "vector2", "t"),
                  value("in2", "vector2", "2, 4"))  # fmt: skip
    found, _ = base(tmp_path, uv, double, picture("x", "color3", link("texcoord", "vector2", "d")))
    np.testing.assert_allclose(uv_at(found, (0.5, 0.25)), [1.0, 1.0])


def test_ramps_rise_from_edge_to_edge(tmp_path):
    ends = value("valuel", "color3", "1, 0, 0") + value("valuer", "color3", "0, 1, 0")
    found, _ = base(tmp_path, node("ramplr", "x", "color3", ends))
    built = Builder().model(Model("texture", "textures"), found, "")
    assert built.type_name() == "mix"
    matrix = built.weight.texture.to_uv.matrix
    shown = built.weight.texture.pixels.texels[0, :, 0]
    # The centres of the first and of the last texel hold 0 and 1.
    half = 0.5 / len(shown)
    assert (shown[0], shown[-1]) == (0.0, 1.0)
    np.testing.assert_allclose(matrix @ [0.0, 0.5, 1.0], [half, 0.5])
    np.testing.assert_allclose(matrix @ [1.0, 0.5, 1.0], [1.0 - half, 0.5])


@pytest.mark.parametrize(("axis", "category"), [(0, "ramplr"), (1, "ramptb")])
def test_functions_of_ramps_are_no_straight_lines(axis, category, tmp_path):
    ends = ["valuel", "valuer"] if axis == 0 else ["valueb", "valuet"]
    inputs = [value(name, "float", number) for name, number in zip(ends, (0, 1), strict=True)]
    square = node("power", "x", "float", link("in1", "float", "r"), value("in2", "float", 2))
    # What is computed of a picture that was computed lies on the surface as that does.
    both = node("difference", "y", "float", link("fg", "float", "r"), link("bg", "float", "x"))
    for of, function in (("x", lambda t: t * t), ("y", lambda t: t - t * t)):
        ramp = node(category, "r", "float", *inputs)
        found, said = base(tmp_path, ramp, square, both, of=of, kind="float")
        assert not any("left out" in line for line in said)
        picture = Builder().model(Model("texture", "textures"), found["texture"], "")
        texels = picture.pixels.texels[..., 0]
        for at in (0.0, 0.3, 0.5, 0.9, 1.0):
            u, v = picture.to_uv.matrix @ np.insert([0.5, 1.0], axis, at)
            row, column = (1.0 - v) * texels.shape[0] - 0.5, u * texels.shape[1] - 0.5
            assert texels[round(row), round(column)] == pytest.approx(function(at), abs=2e-3)


@pytest.mark.parametrize("which", range(5))
def test_switches_show_one_of_their_inputs(which, tmp_path):
    inputs = [value(f"in{i + 1}", "color3", f"0.{i}, 0.5, 0.5") for i in range(4)]
    number = value("which", "integer", which)
    found, _ = base(tmp_path, node("switch", "x", "color3", *inputs, number))
    # There is no fifth one: nothing is shown.
    assert found == pytest.approx([0.1 * which, 0.5, 0.5] if which < 4 else [0.0] * 3)


@pytest.mark.parametrize(("category", "factor"), [("premult", 0.5), ("unpremult", 2.0)])
def test_colours_are_multiplied_by_their_alpha_or_divided(category, factor, tmp_path):
    color = value("in", "color4", "0.2, 0.3, 0.4, 0.5")
    found, _ = base(tmp_path, node(category, "x", "color4", color), kind="color4")
    assert found == pytest.approx([factor * c for c in (0.2, 0.3, 0.4)])


def test_graphs_and_their_interfaces(tmp_path):
    graph = (
        '<nodegraph name="G"><input name="tint" type="color3" value="0.5, 0.25, 0.125"/>'
        + node("multiply", "m", "color3", value("in1", "color3", "0.5, 1, 1"),
               '<input name="in2" type="color3" interfacename="tint"/>')
        + '<output name="o" type="color3" nodename="m"/></nodegraph>'
    )  # fmt: skip
    shader = '<input name="base_color" type="color3" nodegraph="G" output="o"/>'
    bsdf, _ = material(shader, tmp_path, graph)
    assert core(bsdf)["base_color"] == [0.25, 0.25, 0.125]
    own = (
        '<nodedef name="ND_twice" node="twice"><input name="in" type="color3" value="0, 0, 0"/>'
        '<output name="out" type="color3"/></nodedef>'
        '<nodegraph name="NG_twice" nodedef="ND_twice">'
        + node("add", "a", "color3", '<input name="in1" type="color3" interfacename="in"/>',
               '<input name="in2" type="color3" interfacename="in"/>')
        + '<output name="out" type="color3" nodename="a"/></nodegraph>'
    )  # fmt: skip
    used = [node("twice", n, "color3", value("in", "color3", c)) for n, c in
            (("x", "0.1, 0.2, 0.3"), ("y", "0, 0, 0"))]  # fmt: skip
    found, _ = base(tmp_path, own, *used)
    assert found == pytest.approx([0.2, 0.4, 0.6])


def test_documents_of_1_37(tmp_path):
    text = (
        '<materialx version="1.37"><material name="M"><shaderref name="s" node="standard_surface">'
        '<bindinput name="base_color" type="color3" value="0.1, 0.2, 0.3"/></shaderref></material>'
        "</materialx>"
    )
    found = core(parsed(text, tmp_path).data["bsdfs"]["M"])
    assert found["base_color"] == pytest.approx([0.1, 0.2, 0.3])


def test_colours_in_other_spaces_become_linear(tmp_path):
    shader = value("base_color", "color3", "0.5, 0.5, 0.5", ' colorspace="srgb_texture"')
    bsdf, _ = material(shader, tmp_path)
    assert core(bsdf)["base_color"] == pytest.approx([0.2140411] * 3)
    shader = value("base_color", "color3", "0.5, 0.5, 0.5", ' colorspace="acescg"')
    bsdf, _ = material(shader, tmp_path)
    assert core(bsdf)["base_color"] == pytest.approx([0.5] * 3, abs=1e-6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<scene/>", "must be a <materialx>"),
        ("<materialx", "is not XML"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><materialx/>', "document type declarations"),
        ('<materialx version="1.39"/>', "holds no material"),
        (document(link("base_color", "color3", "lost")), 'there is no node "lost"'),
        (document(value("base", "float", "much")), 'must be a number, got "much"'),
        (document(link("base_color", "color3", "x"),
                  node("add", "x", "color3", link("in1", "color3", "x"))), "contains itself"),
        (document(link("normal", "vector3", "x"),
                  node("dot", "x", "vector3", link("in", "vector3", "y")),
                  node("dot", "y", "vector3", link("in", "vector3", "x"))), "contains itself"),
        (document('<input name="base_color" type="color3" nodegraph="g"/>',
                  '<nodegraph name="g"><output name="o" type="color3" nodegraph="g"/></nodegraph>'),
         "is connected to itself"),
        (document('<input name="base_color" type="color3" output="o"/>',
                  '<output name="o" type="color3" output="o"/>'), "is connected to itself"),
        (document('<input name="base_color" type="color3" output="o0"/>',
                  *(f'<output name="o{i}" type="color3" output="o{i + 1}"/>' for i in range(900))),
         "more than 160 others"),
        (document(link("base_color", "color3", "p"), picture(file="b.png")), "no such file"),
        (document(link("base_color", "color3", "p"), picture(file="../b.png")), "leads out of"),
    ],
)  # fmt: skip
def test_problems_have_their_place(text, message, tmp_path):
    found = problem(text, tmp_path)
    assert message in found
    assert "a.mtlx" in found


def test_unknown_nodes_and_missing_pictures(tmp_path):
    found, said = base(tmp_path, node("worleynoise2d", "x", "color3"))
    assert found == [0.5] * 3
    assert any('node "worleynoise2d" is not covered' in line for line in said)
    shader = link("base_color", "color3", "p")
    bsdf, said = material(shader, tmp_path, picture(file="b.png"), lenient=True)
    assert "pixels" in core(bsdf)["base_color"]
    assert any("magenta" in line for line in said)


def test_each_material_is_a_ball_and_one_can_be_chosen(tmp_path):
    from alight.formats import load
    from alight.formats.scenes.made_up import without_floor

    both = [
        node("standard_surface", f"S{n}", "surfaceshader", value("metalness", "float", n))
        + node(
            "surfacematerial", f"M{n}", "material", link("surfaceshader", "surfaceshader", f"S{n}")
        )
        for n in (0, 1)
    ]
    path = tmp_path / "a.mtlx"
    path.write_text(f'<materialx version="1.39">{"".join(both)}</materialx>')
    scene = without_floor(load(path))
    assert list(scene.nodes) == ["M0", "M1"]
    assert scene.nodes["M1"].transform.matrix[0, 3] == pytest.approx(2.4)
    assert list(without_floor(load(path, variant="M1")).nodes) == ["M1"]
    with pytest.raises(ValueError, match='there is no material "M2"'):
        load(path, variant="M2")


@pytest.mark.parametrize("count", [1, 2, 5, 9, 10])
def test_balls_stand_side_by_side_in_rows_as_long_as_there_are_rows(count, tmp_path):
    balls = [
        node("standard_surface", f"S{n}", "surfaceshader")
        + node(
            "surfacematerial", f"M{n}", "material", link("surfaceshader", "surfaceshader", f"S{n}")
        )
        for n in range(count)
    ]
    text = f'<materialx version="1.39">{"".join(balls)}</materialx>'
    nodes = parsed(text, tmp_path).data["nodes"]
    places = np.array([nodes[f"M{n}"]["transform"][-1]["translate"] for n in range(count)])
    away = np.linalg.norm(places[:, None] - places, axis=2) + 9.0 * np.eye(count)
    assert away.min() >= 2.4 - 1e-9
    rows = (np.ptp(places, axis=0) / 2.4).round() + 1
    columns = math.ceil(math.sqrt(count))
    assert rows.tolist() == [columns, 1, math.ceil(count / columns)]
