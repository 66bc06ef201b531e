"""Every number that cameras, films, filters, samplers, integrators and media are asked for matters.

What a reader asks for is noted while it reads a file that says nothing; then each number is said.
"""

import pytest

from alight.formats.pbrt import settings
from alight.formats.pbrt.media import COVERED as MEDIA
from alight.formats.pbrt.parameters import Parameters
from tests.formats.pbrt.test_every_number_counts import outcome

BALL = 'Shape "sphere"'
CELLS = '"integer nx" 1 "integer ny" 1 "integer nz" 2 '
#: What some of them need.
CONTENT = {
    "uniformgrid": f'{CELLS}"float density" [1 2]',
    "heterogeneous": f'{CELLS}"float density" [1 2]',
    "rgbgrid": f'{CELLS}"rgb sigma_a" [1 2 3 4 5 6]', "realistic": '"string lensfile" "lens.dat"',
}  # fmt: skip
#: A lens of 50 mm: curvature, distance, index, diameter.
LENS = "50 1 1.5 20\n-50 0 1 20\n0 40 0 10\n"
SETTINGS = {
    "Camera": settings.CAMERAS, "Film": settings.FILMS, "PixelFilter": settings.FILTERS,
    "Sampler": tuple(settings.SAMPLERS), "Integrator": (*settings.PATHS, *settings.FROM_LIGHTS),
}  # fmt: skip
#: What plays no part by itself: focus without a lens, the size of a film without one, and words for
#: a camera of the other kind; films of pbrt 3 have no sensitivity.
WITHOUT = {
    ("perspective", "focaldistance"), ("perspective", "screenscale"), ("orthographic", "fov"),
    ("perspective", "halffov"), *((film, "diagonal") for film in settings.FILMS),
    ("image", "iso"),
}  # fmt: skip


@pytest.fixture
def asked(monkeypatch):
    """What directives are asked for: (directive, type, name) -> (default, whether it is whole)."""
    noted = {}
    for method in ("number", "integer", "positive"):
        ask = getattr(Parameters, method)

        def note(self, name, default, ask=ask, method=method):
            kind = self.directive.type
            noted[self.directive.name, kind, name] = default, method == "integer"
            return ask(self, name, default)

        monkeypatch.setattr(Parameters, method, note)
    return noted


def judge(kind, names, tell, silent):
    """Each number by itself has its default, and changes what is read, or is said."""
    for name, (default, whole) in names.items():
        if (kind, name) in WITHOUT:
            continue
        word = "integer" if whole else "float"
        if default is not None and default > 0.0:
            assert tell(f'"{word} {name}" {default!r}')[0] == silent[0], (kind, name, default)
        other = default + 1 if whole else 0.8 * default + 0.03
        assert tell(f'"{word} {name}" {other!r}') != silent, f"{kind}: {name} is without effect"


@pytest.mark.parametrize("directive", SETTINGS)
def test_each_number_of_a_setting_matters(directive, asked, tmp_path):
    (tmp_path / "lens.dat").write_text(LENS)
    judged = 0
    for kind in SETTINGS[directive]:
        content = CONTENT.get(kind, "")

        def tell(words, kind=kind, content=content):
            head = f'{directive} "{kind}" {words} {content}\n'
            # What moves shows the shutter, what shines the exposure.
            moving = "ActiveTransform EndTime Translate 1 0 0 ActiveTransform All\n"
            text = f'{moving}LightSource "point" {BALL}'
            return outcome(text, head=head, folder=tmp_path)

        asked.clear()
        silent = tell("")
        names = {n: found for (d, t, n), found in asked.items() if (d, t) == (directive, kind)}
        judge(kind, names, tell, silent)
        judged += len(names)
    assert judged > 3


@pytest.mark.parametrize("kind", MEDIA)
def test_each_number_of_a_medium_matters(kind, asked):
    def tell(words):
        given = f'"string type" "{kind}" {words} {CONTENT.get(kind, "")}'
        shining = "" if kind == "rgbgrid" else '"rgb Le" [1 1 1]'
        return outcome(f'MakeNamedMedium "m" {given} {shining} MediumInterface "m" "" {BALL}')

    silent = tell("")
    names = {n: found for (d, _, n), found in asked.items() if d == "MakeNamedMedium"}
    names = {n: found for n, found in names.items() if n not in ("nx", "ny", "nz")}
    judge(kind, names, tell, silent)
    assert {"scale", "g"} <= set(names)
