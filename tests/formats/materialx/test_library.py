"""Our tables against MaterialX's own library, where its package is installed."""

import pytest

from alight.formats.materialx import gltf_pbr, open_pbr, preview_surface, standard_surface
from alight.formats.materialx.pointwise import POINTWISE

mx = pytest.importorskip("MaterialX")


@pytest.fixture(scope="module")
def library():
    """The standard library."""
    document = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), document)
    return document


def numbers(text):
    if text in ("true", "false"):
        return [float(text == "true")]
    return [float(x) for x in text.split(",")]


@pytest.mark.parametrize("reader", [standard_surface, open_pbr, gltf_pbr, preview_surface])
def test_inputs_and_defaults_of_shaders(reader, library):
    name = {"open_pbr": "open_pbr_surface", "preview_surface": "UsdPreviewSurface"}.get(
        reader.__name__.rpartition(".")[2], reader.__name__.rpartition(".")[2]
    )
    definition = library.getNodeDef(f"ND_{name}_surfaceshader")
    given = {i.getName(): i.getValueString() for i in definition.getActiveInputs()}
    frames = {n for n in given if n.endswith(("normal", "tangent"))}
    assert set(given) - frames == set(reader.INPUTS)
    for key, default in reader.INPUTS.items():
        if given[key]:
            wanted = default if isinstance(default, tuple) else (default,)
            assert numbers(given[key]) == pytest.approx(list(wanted)), key


def test_inputs_and_defaults_of_nodes(library):
    for category, (_, arguments) in POINTWISE.items():
        definitions = library.getMatchingNodeDefs(category)
        assert definitions, category
        kinds = ("color3", "float", "vector3")
        definition = min(definitions, key=lambda d: (*kinds, d.getType()).index(d.getType()))
        given = {i.getName(): i.getValueString() for i in definition.getActiveInputs()}
        assert set(given) == {name for name, _ in arguments}, category
        for name, default in arguments:
            wanted = default if isinstance(default, tuple) else (default,)
            found = numbers(given[name])
            # Values of ifgreater are 1 and 0; vectors of one number are that number.
            assert found == pytest.approx([*wanted] * (len(found) // len(wanted))), (category, name)
