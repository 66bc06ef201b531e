"""Files of version 0.x: what they mean where they say less."""

import pytest

from tests.formats.mitsuba.reading import read, read_bsdf


@pytest.mark.parametrize("kind", ["conductor", "roughconductor"])
def test_metals_without_a_name_are_copper_in_old_files(kind):
    named = read_bsdf('<string name="material" value="Cu"/>', f'type="{kind}"', "0.5.0")
    assert read_bsdf("", f'type="{kind}"', "0.5.0") == named
    assert read_bsdf("", f'type="{kind}"') != named


@pytest.mark.parametrize(
    ("gamma", "space", "is_told"), [(1.0, "linear", 0), (-1.0, "auto", 0), (1.8, "auto", 1)]
)
def test_pictures_of_old_files_may_be_linear(gamma, space, is_told):
    body = f"""<texture type="bitmap" name="reflectance">
    <string name="filename" value="letters.png"/>
    <float name="gamma" value="{gamma}"/></texture>"""
    scene = read(f'<bsdf id="it" type="diffuse">{body}</bsdf>', "0.5.0")
    assert scene.bsdfs["it"].reflectance.color_space == space
    assert len([w for w in scene.warnings if "gamma" in w]) == is_told
