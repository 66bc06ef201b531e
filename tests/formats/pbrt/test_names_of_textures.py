"""Textures by their names: of which kind, and in which colour space, they are."""

import numpy as np
import pytest

from tests.formats.pbrt.reading import read

#: ITU-R BT.2087: linear BT.2020 to BT.709.
FROM_BT2020 = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]]


def material(text):
    scene = read(f'{text}\nShape "sphere"')
    [node] = [node for _, _, node in scene.walk() if node.shape is not None]
    return scene.bsdfs[node.bsdf] if isinstance(node.bsdf, str) else node.bsdf


@pytest.mark.parametrize("first", ["float", "spectrum"])
def test_a_name_means_a_texture_of_the_kind_that_is_asked_for(first):
    lines = [
        'Texture "t" "float" "constant" "float value" 0.25',
        'Texture "t" "spectrum" "constant" "rgb value" [0.5 0.6 0.7]',
    ]
    lines = lines if first == "float" else lines[::-1]
    asked = 'Texture "u" "float" "scale" "texture tex" "t" "float scale" 0.5\n'
    asked += 'Texture "v" "spectrum" "scale" "texture tex" "t" "float scale" 0.5\n'
    asked += 'Material "coateddiffuse" "texture reflectance" "v" "texture roughness" "u"'
    asked += ' "bool remaproughness" false'
    found = material("\n".join([*lines, asked])).bsdf
    # Below the coat it is a little darker.
    share = np.array(found.diffuse_reflectance) / [0.25, 0.3, 0.35]
    assert share.min() > 0.9 and share.max() - share.min() < 0.01
    assert found.alpha == pytest.approx(0.125)


@pytest.mark.parametrize("around", ["srgb", "rec2020"])
@pytest.mark.parametrize("of_texture", ["srgb", "rec2020"])
def test_a_texture_is_in_the_space_of_its_definition_and_nothing_else_is(of_texture, around):
    """Wherever it is asked for, and whatever is read after it."""
    spaces = {"srgb": np.eye(3), "rec2020": np.array(FROM_BT2020)}
    found = material(f"""
ColorSpace "{of_texture}"
Texture "t" "spectrum" "constant" "rgb value" [0.3 0.4 0.5]
ColorSpace "{around}"
Material "diffusetransmission" "texture reflectance" "t" "rgb transmittance" [0.2 0.1 0.3]
""")
    first, second = spaces[of_texture] @ [0.3, 0.4, 0.5], spaces[around] @ [0.2, 0.1, 0.3]
    numbers = [np.array(v) for v in dict(found).values() if isinstance(v, tuple) and len(v) == 3]
    for wanted in (first, second):
        assert any(np.allclose(wanted, number, atol=1e-3) for number in numbers), numbers
