"""As `test_every_number_counts`: colours, points, flags and words that are asked for.

Each has the default of pbrt's documentation, each part of it matters, and a word that means nothing
is said.
"""

import re

import pytest

from alight.formats import dumps
from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.textures import Source
from tests.formats.pbrt.reading import read
from tests.formats.pbrt.test_every_number_counts import CONTENT, DIRECTIVES, outcome

#: eta and k of copper, in linear sRGB.
COPPER = {"eta": [0.20101, 0.92375, 1.1022], "k": [3.9133, 2.453, 2.1421]}
WHITE, BLACK, HALF, QUARTER = ([value] * 3 for value in (1.0, 0.0, 0.5, 0.25))
_MIX = {"tex1": BLACK, "tex2": WHITE}
_KD = {"Kd": QUARTER, "Ks": QUARTER}
#: Of skin, per millimetre, and of nothing else that is said.
_SKIN = {
    "mfp": WHITE, "reflectance": None, "Kd": None,
    "sigma_a": [0.0011, 0.0024, 0.014], "sigma_s": [2.55, 3.21, 3.77],
}  # fmt: skip
#: As the documentation of pbrt 4 has them, and that of 3 for what only that has. None: another
#: parameter decides.
COLORS = {
    "bilerp": {"v00": BLACK, "v01": WHITE, "v10": BLACK, "v11": WHITE},
    "checkerboard": {"tex1": WHITE, "tex2": BLACK},
    "coatedconductor": {
        "conductor.eta": COPPER["eta"], "conductor.k": COPPER["k"], "reflectance": None,
    },
    "coateddiffuse": {"reflectance": HALF},
    "conductor": COPPER | {"reflectance": None},
    "constant": {"value": WHITE},
    "diffuse": {"reflectance": HALF},
    "diffusetransmission": {"reflectance": QUARTER, "transmittance": QUARTER},
    "directionmix": _MIX,
    "disney": {"color": HALF},
    "dots": {"inside": WHITE, "outside": BLACK},
    "glass": {"Kr": WHITE, "Kt": WHITE},
    "hair": {"reflectance": None, "sigma_a": None},
    "kdsubsurface": _SKIN,
    "matte": {"Kd": HALF},
    "metal": COPPER,
    "mirror": {"Kr": [0.9] * 3},
    "mix": _MIX,
    "plastic": _KD,
    "scale": {"scale": WHITE, "tex": WHITE},
    "subsurface": _SKIN,
    "substrate": {"Kd": HALF, "Ks": HALF},
    "translucent": _KD | {"reflect": HALF, "transmit": HALF},
    "uber": _KD | {"opacity": None},
}  # fmt: skip
#: What is said to become something plainer.
PLAINER = {("substrate", "Ks"), ("translucent", "Ks"), ("dots", "inside")}
#: What some of them need to have an effect.
WITH = {"mfp": '"rgb reflectance" [0.3 0.2 0.1]'}
FLAGS = {"remaproughness": True, "thin": False, "invert": False}
POINTS = {
    "from": (0.0, 0.0, 0.0), "to": (0.0, 0.0, 1.0), "p1": (0.0, 0.0, 0.0), "p2": (1.0, 1.0, 1.0),
}  # fmt: skip


@pytest.fixture
def asked(monkeypatch):
    """What directives are asked for: (what, directive, type) -> {name: default}."""
    noted = {}

    def watch(owner, method, called, directive_of):
        ask = getattr(owner, method)

        def note(self, name, *defaults):
            directive = directive_of(self)
            names = noted.setdefault((called, directive.name, directive.type), {})
            names[name] = defaults[0] if defaults else None
            return ask(self, name, *defaults)

        monkeypatch.setattr(owner, method, note)

    for method in ("flag", "word", "triple"):
        watch(Parameters, method, method, lambda self: self.directive)
    watch(Parameters, "number", "any number", lambda self: self.directive)
    watch(Source, "number", "any number", lambda self: self.p.directive)
    watch(Source, "color", "color", lambda self: self.p.directive)
    return noted


def each(asked, method, directive):
    """(type, name, default, what of a parameter's text makes the outcome) of all that is asked."""
    kinds, form = DIRECTIVES[directive]
    for kind in kinds:
        asked.clear()
        content = CONTENT.get(f"{directive} {kind}", CONTENT.get(kind, ""))
        if len(outcome(form.format(kind, content))) == 1:
            continue
        for name, default in list(asked.get((method, directive, kind), {}).items()):
            if f' {name}"' in content:
                continue
            yield kind, name, default, lambda t, k=kind, c=content: form.format(k, f"{t} {c}")


@pytest.mark.parametrize("directive", ["Material", "Texture"])
def test_colours_have_their_defaults_and_each_channel_matters(directive, asked):
    judged = 0
    for kind, name, default, text in each(asked, "color", directive):
        place = f"{kind}: {name}"
        assert default == COLORS[kind][name], place

        def said(r, g, b, name=name, text=text):
            return text(f'"rgb {name}" [{r} {g} {b}] {WITH.get(name, "")}')

        if default is not None:
            assert outcome(said(*default))[0] == outcome(text(WITH.get(name, "")))[0], place
        if (kind, name) in PLAINER:
            continue
        base = outcome(said(0.21, 0.43, 0.67))
        others = [(0.3, 0.43, 0.67), (0.21, 0.5, 0.67), (0.21, 0.43, 0.7)]
        assert len({base, *(outcome(said(*other)) for other in others)}) == 4, place
        # And none stands in the place of another one.
        if len(base) > 1:
            numbers = re.findall(r"\b0\.(?:21|43|67)\b", dumps(read(said(0.21, 0.43, 0.67))))
            assert numbers in ([], ["0.21", "0.43", "0.67"]), place
        judged += 1
    assert judged > 10


@pytest.mark.parametrize("directive", ["Material", "Texture"])
def test_flags_have_their_defaults_and_matter(directive, asked):
    judged = 0
    for kind, name, default, text in each(asked, "flag", directive):
        assert default == FLAGS[name], f"{kind}: {name}"
        # No roughness is none, however it is measured.
        numbers = [n for n in asked[("any number", directive, kind)] if "roughness" in n]
        rough = " ".join(f'"float {n}" 0.3' for n in numbers)
        silent, same, other = (
            outcome(text(f"{flag} {rough}"))
            for flag in ("", *(f'"bool {name}" {str(v).lower()}' for v in (default, not default)))
        )
        assert same[0] == silent[0] != other[0], f"{kind}: {name}"
        judged += 1
    assert judged


@pytest.mark.parametrize("directive", ["LightSource", "Shape"])
def test_points_have_their_defaults_and_each_coordinate_matters(directive, asked):
    judged = 0
    for kind, name, default, text in each(asked, "triple", directive):
        assert tuple(default) == POINTS[name], f"{kind}: {name}"

        def said(*point, name=name, text=text):
            return outcome(text(f'"point3 {name}" [{point[0]} {point[1]} {point[2]}]'))

        assert said(*default)[0] == outcome(text(""))[0], f"{kind}: {name}"
        base = (0.5, 0.3, 0.2)
        moved = [said(*(b + 0.1 * (i == axis) for i, b in enumerate(base))) for axis in range(3)]
        assert len({said(*base), *moved}) == 4, f"{kind}: {name}"
        judged += 1
    assert judged


@pytest.mark.parametrize("directive", DIRECTIVES)
def test_words_that_mean_nothing_are_said(directive, asked):
    for kind, name, _, text in each(asked, "word", directive):
        silent, said = outcome(text("")), outcome(text(f'"string {name}" "nonsense"'))
        assert said != silent, f"{kind}: {name}"
