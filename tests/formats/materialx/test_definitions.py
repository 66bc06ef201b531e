"""Nodes that documents define, and the interfaces of graphs."""

import pytest

from tests.formats.materialx.reading import (
    core,
    document,
    link,
    material,
    node,
    problem,
    value,
)


def base(folder, *nodes, head=""):
    """The colour that a standard surface gets from a node x, and what was said."""
    bsdf, said = material(link("base_color", "color3", "x"), folder, *nodes, head=head)
    return core(bsdf)["base_color"], said


def definition(name, category="tint", more="", inputs="", output=True):
    """A definition, and the graph that gives its input "in"."""
    gives = '<output name="out" type="color3"/>' if output else ""
    head = f'<nodedef name="{name}" node="{category}"{more}>{inputs}{gives}</nodedef>'
    taken = node("dot", "d", "color3", '<input name="in" type="color3" interfacename="in"/>')
    graph = f'<nodegraph name="N{name}" nodedef="{name}">{taken}'
    return head + graph + '<output name="out" type="color3" nodename="d"/></nodegraph>'


def tinted(numbers):
    """An input with its default."""
    return value("in", "color3", numbers)


@pytest.mark.parametrize(("own", "meant"), [("", 0.1), (tinted("0.2, 0.2, 0.2"), 0.2)])
def test_definitions_inherit_inputs_and_outputs(own, meant, tmp_path):
    parent = definition("A", "other", inputs=tinted("0.1, 0.1, 0.1"))
    child = definition("B", more=' inherit="A"', inputs=own, output=False)
    found, _ = base(tmp_path, parent, child, node("tint", "x", "color3"))
    assert found == [meant] * 3


def test_what_inherits_from_itself_or_from_nothing(tmp_path):
    text = definition("A", more=' inherit="B"') + definition("B", more=' inherit="A"')
    whole = document(link("base_color", "color3", "x"), text, node("tint", "x", "color3"))
    assert "inherits from itself" in problem(whole, tmp_path)
    text = definition("A", more=' inherit="lost"', inputs=tinted("0.1, 0.1, 0.1"))
    found, said = base(tmp_path, text, node("tint", "x", "color3"))
    assert found == [0.1] * 3
    assert any('no nodedef "lost"' in line for line in said)


@pytest.mark.parametrize(("version", "meant"), [("", 0.2), ("1.0", 0.1), ("3.0", 0.3)])
def test_the_version_that_is_wanted_or_the_default_one_counts(version, meant, tmp_path):
    several = [
        definition(
            f"A{i}",
            more=f' version="{i}.0"' + (' isdefaultversion="true"' if i == 2 else ""),
            inputs=tinted(f"0.{i}, 0.{i}, 0.{i}"),
        )
        for i in (1, 2, 3)
    ]
    used = node("tint", "x", "color3")
    if version:
        used = used.replace('name="x"', f'name="x" version="{version}"')
    found, _ = base(tmp_path, *several, used)
    assert found == [meant] * 3


@pytest.mark.parametrize(
    ("outer", "inner", "head", "meant"),
    [
        ("", "srgb_texture", "", "srgb"),
        ("", "srgb_texture", "lin_rec709", "srgb"),
        ("lin_rec709", "srgb_texture", "", "linear"),
        ("srgb_texture", "", "", "srgb"),
        ("", "", "srgb_texture", "srgb"),
        ("", "", "", "linear"),
    ],
)
def test_files_of_interfaces_have_the_colour_space_of_either_side(
    outer, inner, head, meant, tmp_path
):
    outer, inner, head = (f' colorspace="{s}"' if s else "" for s in (outer, inner, head))
    file = value("map", "filename", "a.png", outer)
    shown = node("image", "i", "color3",
                 f'<input name="file" type="filename" interfacename="map"{inner}/>')  # fmt: skip
    graph = f'<nodegraph name="g">{file}{shown}<output name="o" type="color3" nodename="i"/>'
    used = '<dot name="x" type="color3"><input name="in" type="color3" nodegraph="g"/></dot>'
    found, _ = base(tmp_path, graph + "</nodegraph>", used, head=head)
    assert found["color_space"] == meant
