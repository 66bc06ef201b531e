"""What docs/pbrt.md says is so: it names all that is covered, and its messages are ours."""

import re

from alight.core.errors import SceneError
from alight.formats import loads
from alight.formats.pbrt import colors, lights, media, settings, shapes, world
from tests.docs.pages import ROOT

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
