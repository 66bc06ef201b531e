"""What docs/pbrt.md says is so: it names all that is covered, and its messages are ours."""

import re

import pytest

from alight.core.errors import SceneError
from alight.formats import loads
from alight.formats.pbrt import colors, lights, media, settings, shapes, world
from tests.docs.pages import ROOT
from tests.formats.pbrt.reading import read, read_old

PAGE = ROOT / "docs" / "pbrt.md"


def test_page_names_everything_that_is_covered():
    covered = {
        *shapes.COVERED, *world.MATERIALS, *lights.COVERED, *world.TEXTURES,
        *settings.CAMERAS, *settings.FILMS, *settings.FILTERS, *settings.SAMPLERS,
        *settings.PATHS, *settings.FROM_LIGHTS, *media.COVERED, *colors.KINDS, *colors.SPACES,
    } - {""}  # fmt: skip
    named = set(re.findall(r"`([\w-]+)`", PAGE.read_text(encoding="utf-8")))
    assert covered - named == set()


def test_message_of_the_page_is_the_one_that_its_file_gets():
    text = PAGE.read_text(encoding="utf-8")
    [file] = re.findall(r'```text title="scene.pbrt"\n(.*?)```', text, re.DOTALL)
    [message] = re.findall(r"```text\n(.*?)```", text, re.DOTALL)
    try:
        loads(file, "scene.pbrt")
    except SceneError as error:
        assert f"error: {error}".strip() == message.strip()
    else:
        raise AssertionError("the file of the page is not refused")


SKIES = 'LightSource "infinite"\n'
STRAIGHT = '"point3 P" [0 0 0  0 0 1  0 0 2  0 0 3]'
#: Shortest files in which the page's second column holds; the name alone where there is nothing.
PLAIN = {
    "bilinearmesh": '"point3 P" [0 0 0 1 0 0 0 1 0 1 1 0]',
    "curve": STRAIGHT, "heightfield": '"integer nu" 2 "integer nv" 2 "float Pz" [0 0 0 1]',
    "trianglemesh": '"point3 P" [0 0 0 1 0 0 0 1 0] "integer indices" [0 1 2]',
    "loopsubdiv": '"point3 P" [0 0 0 1 0 0 0 1 0] "integer indices" [0 1 2]',
}  # fmt: skip
#: The same of the third, where the name alone is not enough.
WARNED = {
    "coateddiffuse": '"float roughness" 0.5', "hair": '"texture color" "t"',
    "curve": f'{STRAIGHT} "string type" "ribbon" "normal N" [0 0 1 0 0 1]',
    "nurbs": '"integer nu" 2 "integer nv" 2 "integer uorder" 2 "integer vorder" 2 "float uknots" '
    '[0 0 1 1] "float vknots" [0 0 1 1] "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0]',
}  # fmt: skip
#: They need files or other materials; a ribbon is a kind of curve.
LEFT_OUT = {"plymesh", "measured", "imagemap", "mix", "ribbon"}
ROWS = {
    "shapes": 'Shape "{}" {}',
    "materials of pbrt 4": 'Material "{}" {}\nShape "sphere"',
    "materials of pbrt 3": 'Material "{}" {}\nShape "sphere"',
    "textures": 'Texture "u" "spectrum" "{}" {}\nMaterial "diffuse" "texture reflectance" "u"\n'
    'Shape "sphere"',
}


def heads(cell):
    """Names of a list that are not within brackets."""
    while (shorter := re.sub(r"\([^()]*\)", "", cell)) != cell:
        cell = shorter
    return set(re.findall(r"`(\w+)`", cell)) - LEFT_OUT


@pytest.mark.parametrize("kind", ROWS)
def test_what_the_page_gives_a_warning_for_has_one_and_the_rest_has_none(kind):
    text = PAGE.read_text(encoding="utf-8")
    [(covered, warned)] = re.findall(rf"^\| {kind} \| (.*?) \| (.*?) \|$", text, re.MULTILINE)
    load = read_old if kind.endswith("3") else read
    wrong = []
    for names, words, told in ((covered, PLAIN, False), (warned, WARNED, True)):
        for name in heads(names):
            body = ROWS[kind].format(name, words.get(name, ""))
            scene = load(f'{SKIES}Texture "t" "spectrum" "checkerboard"\n{body}')
            found = any(f'"{name}"' in text for text in scene.warnings)
            wrong += [name] * (found != told)
    assert not wrong


def test_curves_that_move_are_triangles_and_that_is_said():
    moves = "ActiveTransform EndTime Translate 1 0 0 ActiveTransform All\n"
    # Ribbons are triangles at rest, too.
    for words, told in ((STRAIGHT, True), (WARNED["curve"], False)):
        found = read(f'{SKIES}{moves}Shape "curve" {words}')
        assert any('"curve" moves: triangles' in text for text in found.warnings) == told
