"""Scene -> text -> scene and scene -> file -> scene give the same scene, bit for bit."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from alight.cameras.pinhole import Pinhole
from alight.core.registry import FAMILIES, modules
from alight.core.spec import Light, Shape
from alight.formats import builtin_names, dumps, load, loads, save
from alight.lights.area import Area
from alight.scene import (
    FilmSettings,
    Node,
    Scene,
    content_hash,
    look_at,
    matrix,
    rotate,
    scale,
    translate,
)
from alight.scene.plain_yaml import parse, parse_value, resolve, write
from alight.shapes.mesh import Mesh
from alight.shapes.sphere import Sphere


def examples(family):
    """Draw one of the example descriptions of a family."""
    return st.sampled_from([e for module in modules(family) for e in module.EXAMPLES])


numbers = st.floats(-1e6, 1e6)
names = st.text(min_size=1, max_size=12).filter(
    lambda n: n == n.strip() and n.isprintable() and not set(n) & set("/.[]=")
)
triples = st.tuples(numbers, numbers, numbers)
steps = st.one_of(
    st.builds(lambda v: translate(*v), triples),
    st.builds(rotate, st.sampled_from(["x", "y", "z", (1.0, 2.0, 3.0)]), numbers),
    st.builds(scale, st.floats(0.1, 10.0)),
    st.builds(scale, st.floats(-3.0, -0.1), st.floats(0.1, 10.0), st.floats(0.1, 10.0)),
    st.builds(lambda x: look_at((x, 1.0, 2.0), (x, 0.3, -5.0)), numbers),
    st.builds(lambda x: matrix([[1, 0, x, 0], [0, 1, 0, x], [0, 0, 1, 0], [0, 0, 0, 1]]), numbers),
)


@st.composite
def transforms(draw):
    """Compose a few steps."""
    result = translate(0.0, 0.0, 0.0)
    for step in draw(st.lists(steps, max_size=4)):
        result = step @ result
    return result


@st.composite
def nodes(draw, depth=2):
    """Build a node tree from examples."""
    shape: Shape | None = draw(st.none() | examples("shapes"))
    lights = [e for e in draw(st.just(all_lights())) if e.placement == "node"]
    light: Light | None = draw(st.sampled_from([None, *lights])) if shape is None else None
    if shape is not None and shape.finite and draw(st.booleans()):
        light = Area(radiance=draw(st.floats(0.0, 1e6)))
    children = {}
    if depth:
        children = draw(st.dictionaries(names, nodes(depth=depth - 1), max_size=2))
    return Node(
        transform=draw(transforms()),
        shape=shape,
        bsdf=draw(st.none() | examples("bsdfs")),
        light=light,
        children=children,
    )


def all_lights():
    """List all example lights."""
    return [e for module in modules("lights") for e in module.EXAMPLES]


@st.composite
def scenes(draw):
    """Build a scene from examples of every family."""
    skies = [e for e in all_lights() if e.placement == "environment"]
    return Scene(
        camera=Node(camera=draw(examples("cameras")), transform=draw(transforms())),
        film=FilmSettings(size=(64, 48), crop=(1, 2, 3, 4), filter=draw(examples("filters"))),
        sampler=draw(examples("samplers")),
        integrator=draw(examples("integrators")),
        environment=draw(st.sampled_from([None, *skies])),
        textures=draw(st.dictionaries(names, examples("textures"), max_size=2)),
        bsdfs=draw(st.dictionaries(names, examples("bsdfs"), max_size=3)),
        nodes=draw(st.dictionaries(names, nodes(), max_size=3)),
    )


@given(scene=scenes())
@settings(max_examples=60, deadline=None)
def test_text_round_trip_is_exact(scene):
    again = loads(dumps(scene), check=False)
    assert again == scene
    assert dumps(again) == dumps(scene)


@pytest.mark.parametrize("name", builtin_names())
def test_builtin_scenes_survive_a_round_trip(name):
    scene = load(name)
    assert loads(dumps(scene)) == scene
    assert content_hash(loads(dumps(scene))) == content_hash(scene)


@pytest.mark.parametrize("family", FAMILIES)
def test_every_example_is_an_immutable_value(family):
    for module in modules(family):
        for example in module.EXAMPLES:
            assert example == example.replaced()
            assert hash(example) == hash(example.replaced())
            with pytest.raises(ValueError, match="never changes"):
                example.type = "other"


@given(number=st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_are_written_exactly(number):
    again = parse_value(write({"x": number}))["x"]
    assert isinstance(again, float)
    assert np.float64(again).tobytes() == np.float64(number).tobytes()


@given(text=st.text().filter(lambda t: not any(0xD800 <= ord(c) < 0xE000 for c in t)))
def test_texts_are_written_exactly(text):
    assert parse_value(write({"x": text})) == {"x": text}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 0.001), ("1E5", 1e5), (".5", 0.5), ("-2.", -2.0), ("+3", 3), ("007", 7),
        ("yes", "yes"), ("on", "on"), ("true", True), ("null", None), ("~", None), ("", None),
        ("0x10", "0x10"), ("1_000", "1_000"), ("1:30", "1:30"), (".inf", math.inf), ("nan", "nan"),
        ("1" * 30, float("1" * 30)),
    ],
)  # fmt: skip
def test_plain_scalars_have_the_type_that_they_look_like(text, value):
    assert resolve(text) == value
    assert type(resolve(text)) is type(value)


def test_negative_zeros_are_kept():
    shape = Sphere(center=(-0.0, 0.0, 0.0))
    scene = Scene(camera=Node(camera=Pinhole()), nodes={"a": Node(shape=shape)})
    assert repr(loads(dumps(scene)).nodes["a"].shape) == repr(shape)


def test_json_is_read():
    scene = loads('{"alight": 1, "camera": {"type": "pinhole", "fov": 4.5e1},\n "nodes": {}}')
    assert scene.camera.camera.fov == 45.0


def test_large_meshes_go_to_ply_files_and_come_back(tmp_path):
    rng = np.random.default_rng(1)
    large = Mesh(
        vertices=rng.normal(size=(300, 3)).astype(np.float32),
        faces=rng.integers(0, 300, (200, 3)),
        normals=rng.normal(size=(300, 3)),
        uvs=rng.random((300, 2)),
        colors=rng.random((300, 3)),
    )
    scene = Scene(camera=Node(camera=modules("cameras")[0].EXAMPLES[0]), nodes={
        "a": Node(shape=large), "b": Node(shape=large, transform=translate(1, 0, 0)),
    })  # fmt: skip
    save(scene, tmp_path / "saved.yaml")
    assert len(list(tmp_path.glob("*.ply"))) == 1
    again = load(tmp_path / "saved.yaml")
    assert content_hash(again) == content_hash(scene)
    # Saved elsewhere, the file is still found.
    (tmp_path / "deeper").mkdir()
    save(again, tmp_path / "deeper" / "copy.yaml")
    assert content_hash(load(tmp_path / "deeper" / "copy.yaml")) == content_hash(scene)


def test_saving_leaves_no_half_file(tmp_path):
    with pytest.raises(ValueError, match=r"must end in \.yaml"):
        save(load("cornell-box"), tmp_path / "scene.txt")
    save(load("cornell-box"), tmp_path / "scene.json")
    assert [path.name for path in tmp_path.iterdir()] == ["scene.json"]


def test_scenes_are_saved_as_gltf_and_what_it_cannot_hold_is_told(tmp_path):
    lost = save(load("fog"), tmp_path / "scene.glb")
    assert any("media" in line for line in lost)
    assert load(tmp_path / "scene.glb").nodes
    assert save(load("fog"), tmp_path / "scene.yaml") == ()


def test_content_hash_sees_all_that_decides_the_picture_and_nothing_else():
    base = load("cornell-box")
    changes = [
        "camera.fov=40", "film.size=[64, 64]", "film.filter=tent", "sampler=halton",
        "integrator.max_depth=7", "bsdfs.white.reflectance[1]=0.5", "environment=constant",
        "nodes.light.light.radiance=3", "nodes.floor.bsdf=red", "nodes.floor.shape=disk",
        "nodes.floor.shape.flip_normals=true", "nodes.back.transform={translate: [0, 0, -1.001]}",
        "film.replicates=8",
    ]  # fmt: skip
    hashes = [content_hash(load("cornell-box", [change])) for change in changes]
    assert len({content_hash(base), *hashes}) == len(changes) + 1
    renamed = base.replaced(nodes={f"n{i}": node for i, node in enumerate(base.nodes.values())})
    assert content_hash(renamed) == content_hash(base)


@pytest.mark.parametrize("name", ["a: b", "yes", "3", "a, b", "{c", "-", "null", "#", "1e3"])
def test_names_in_short_mappings_are_quoted_where_they_must_be(name):
    data = {"nodes": {"a": {name: 1, "b": name}}}
    assert parse(write(data), "a.yaml")[0] == data
