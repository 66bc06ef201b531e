"""As `test_every_number_counts`: colours, points, flags and words of plugins.

Each has the default of Mitsuba's documentation, each part of it matters, and a word that means
nothing is said.
"""

import re

import pytest

from alight.formats.mitsuba.properties import Properties
from tests.formats.mitsuba.test_every_number_counts import CONTENT, OBJECTS, outcome

_MIRRORED = {"specular_reflectance": 1.0}
_CLEAR = _MIRRORED | {"specular_transmittance": 1.0}
_PLASTIC = _MIRRORED | {"diffuse_reflectance": 0.5}
_GLOSSY = {"specular_reflectance": 0.2, "diffuse_reflectance": 0.5}
#: As the documentation of Mitsuba 3 has them, and that of 0.6 for what only that has; without the
#: tint of coats and the lines of grids, of which it is said that something plainer is shown.
COLORS = {
    "bsdf": {
        "conductor": _MIRRORED, "dielectric": _CLEAR,
        "difftrans": {"transmittance": 0.5}, "diffuse": {"reflectance": 0.5}, "phong": _GLOSSY,
        "plastic": _PLASTIC, "pplastic": _PLASTIC, "principled": {"base_color": 0.5},
        "principledthin": {"base_color": 0.5},
        "roughconductor": _MIRRORED, "roughdielectric": _CLEAR,
        "roughdiffuse": {"reflectance": 0.5}, "roughplastic": _PLASTIC, "thindielectric": _CLEAR,
        "ward": _GLOSSY,
    },
    "texture": {
        "checkerboard": {"color0": 0.4, "color1": 0.2},
        "gridtexture": {"color0": 0.2},
    },
    "emitter": {
        "directional": {"irradiance": 1.0}, "point": {"intensity": 1.0}, "spot": {"intensity": 1.0},
    },
}  # fmt: skip
FLAGS = {
    "ensure_energy_conservation": True, "face_normals": False, "flip_invalid_normals": True,
    "flip_normals": False, "hide_emitters": False, "nonlinear": False, "raw": False,
    "use_shadowing_function": True,
}  # fmt: skip
#: Weights that do not add up to 1 are scaled, whatever it says, and that is said.
WITHOUT = {"ensure_energy_conservation"}
POINTS = {
    "center": (0.0, 0.0, 0.0), "p0": (0.0, 0.0, 0.0), "p1": (0.0, 0.0, 1.0),
    "position": None, "direction": None, "sun_direction": None, "value": None,
}  # fmt: skip


@pytest.fixture
def asked(monkeypatch):
    """What plugins are asked for: method -> (tag, type, name) -> default."""
    noted = {"flag": {}, "word": {}, "triple": {}}

    def watch(method):
        ask = getattr(Properties, method)

        def note(self, name, *defaults):
            of = self.element.tag, self.element.type, name
            noted[method][of] = defaults[0] if defaults else None
            return ask(self, name, *defaults)

        monkeypatch.setattr(Properties, method, note)

    for method in noted:
        watch(method)
    return noted


def form_of(tag, kind):
    """What the text of a parameter makes the outcome of a file with one plugin."""
    form, content = OBJECTS[tag][1], CONTENT.get(kind, "")

    def said(text=""):
        return outcome(form.format(kind, text + content), "3.0.0")

    return said


def each(asked, method, tag):
    """(type, name, default, `form_of`) of what the plugins of a tag are asked for."""
    for kind in OBJECTS[tag][0]:
        said = form_of(tag, kind)
        content = CONTENT.get(kind, "")
        silent = said()
        for (t, k, name), default in list(asked[method].items()):
            if (t, k) == (tag, kind) and f'name="{name}"' not in content and len(silent) > 1:
                yield kind, name, default, said


@pytest.mark.parametrize(
    ("tag", "kind", "name"),
    [(t, k, n) for t, kinds in COLORS.items() for k, names in kinds.items() for n in names],
)
def test_colours_have_their_defaults_and_each_channel_matters(tag, kind, name):
    said, default = form_of(tag, kind), COLORS[tag][kind][name]

    def colored(r, g, b):
        return said(f'<rgb name="{name}" value="{r} {g} {b}"/>')

    assert colored(default, default, default)[0] == said()[0]
    base = colored(0.21, 0.43, 0.67)
    others = [colored(*c) for c in ((0.3, 0.43, 0.67), (0.21, 0.5, 0.67), (0.21, 0.43, 0.7))]
    assert len({base, *others}) == 4
    numbers = re.findall(r"\b0\.(?:21|43|67)\b", base[0])
    assert numbers in ([], ["0.21", "0.43", "0.67"])


@pytest.mark.parametrize("tag", ["bsdf", "texture", "shape", "integrator"])
def test_flags_have_their_defaults_and_matter(tag, asked):
    judged = 0
    for kind, name, _, said in each(asked, "flag", tag):
        default = FLAGS[name]
        same, other = (
            said(f'<boolean name="{name}" value="{str(value).lower()}"/>')
            for value in (default, not default)
        )
        assert same[0] == said()[0], f"{kind}: {name}"
        assert other != said() or name in WITHOUT, f"{kind}: {name}"
        judged += 1
    assert judged


@pytest.mark.parametrize("tag", ["emitter", "shape"])
def test_points_have_their_defaults_and_each_coordinate_matters(tag, asked):
    judged = 0
    for kind, name, _, said in each(asked, "triple", tag):
        default = POINTS[name]

        def placed(point, name=name, said=said):
            x, y, z = point
            return said(f'<vector name="{name}" x="{x}" y="{y}" z="{z}"/>')

        if default is not None:
            assert placed(default)[0] == said()[0], f"{kind}: {name}"
        base = (0.5, 0.3, 0.2)
        moved = [[b + 0.1 * (i == axis) for i, b in enumerate(base)] for axis in range(3)]
        assert len({placed(base), *map(placed, moved)}) == 4, f"{kind}: {name}"
        judged += 1
    assert judged


@pytest.mark.parametrize("tag", OBJECTS)
def test_words_that_mean_nothing_are_said(tag, asked):
    for kind, name, _, said in each(asked, "word", tag):
        assert said(f'<string name="{name}" value="nonsense"/>') != said(), f"{kind}: {name}"
