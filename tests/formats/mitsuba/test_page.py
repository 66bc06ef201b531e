"""What docs/mitsuba.md says is so: it names all that is covered, and its messages are ours."""

import re

from alight.core.errors import SceneError
from alight.formats import loads
from alight.formats.mitsuba import emitters, films, integrators, scene, sensors, shapes, textures
from tests.docs.pages import ROOT, blocks

PAGE = ROOT / "docs" / "mitsuba.md"


def test_page_names_every_plugin_that_is_covered():
    covered = {
        *shapes.COVERED, *scene.MATERIALS, *emitters.NODES, "constant", *textures.COVERED,
        *sensors.COVERED, *films.FILMS, *films.OTHER_FILMS, *films.SAMPLERS, *integrators.COVERED,
    }  # fmt: skip
    named = set(re.findall(r"`([\w-]+)`", PAGE.read_text(encoding="utf-8")))
    assert covered - named == set()


def test_message_of_the_page_is_the_one_that_its_file_gets():
    [file], [message] = blocks(PAGE, "xml"), blocks(PAGE, "text")
    try:
        loads(file, "scene.xml")
    except SceneError as error:
        assert f"error: {error}".strip() == message.strip()
    else:
        raise AssertionError("the file of the page is not refused")
