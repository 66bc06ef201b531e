"""Mixtures of materials by a colour, as pbrt 3 has them."""

import pytest

from tests.formats.pbrt.reading import read_old


@pytest.mark.parametrize(
    ("amount", "weight", "is_said"),
    [("0.25 0.25 0.25", 0.25, False), ("1 0 0", 0.212671, True), ("0 1 0", 0.715160, True)],
)
def test_pbrt_3_mixes_by_a_colour(amount, weight, is_said):
    """Where its channels differ one share is taken for all: that of their luminance."""
    body = f"""MakeNamedMaterial "a" "string type" "matte"
    MakeNamedMaterial "b" "string type" "glass"
    MakeNamedMaterial "m" "string type" "mix" "rgb amount" [{amount}]
        "string namedmaterial1" "a" "string namedmaterial2" "b"
    NamedMaterial "m" Shape "sphere" """
    scene = read_old(body)
    assert scene.bsdfs["m"].weight == pytest.approx(weight)
    assert any("their luminance is taken for all" in line for line in scene.warnings) == is_said
