"""Every number that is asked for has the default of pbrt's documentation, and matters.

What a reader asks for is noted while it reads a file that says nothing; then each number is said.
"""

import pytest

from alight.core.errors import SceneError
from alight.formats.pbrt import lights, shapes, world
from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.textures import Source
from alight.scene import content_hash
from tests.formats.pbrt.reading import read

PICTURE = '"string filename" "letters.png"'
#: What some of them need.
CONTENT = {
    "imagemap": PICTURE,
    "projection": PICTURE,
    "Material mix": '"string materials" ["a" "b"]',
    "dots": '"float outside" 0.5',
    "trianglemesh": '"point3 P" [0 0 0 1 0 0 0 1 0] "integer indices" [0 1 2]',
}
BALL = '\nShape "sphere"'
DIRECTIVES = {
    "LightSource": (lights.COVERED, 'LightSource "{}" {}'),
    "Material": (
        world.MATERIALS,
        'MakeNamedMaterial "a" "string type" "diffuse"\n'
        'MakeNamedMaterial "b" "string type" "conductor"\nMaterial "{}" {}' + BALL,
    ),
    "Shape": (shapes.COVERED, 'Shape "{}" {}'),
    "Texture": (
        world.TEXTURES,
        'Texture "t" "spectrum" "{}" {}\nMaterial "diffuse" "texture reflectance" "t"' + BALL,
    ),
}
#: Defaults by name, and those of some types that have others; of pbrt 4, and of 3 for what only
#: that has. None: it has no such parameter.
DEFAULTS = {
    "alpha": 2.0, "amount": 0.5, "anisotropic": 0.0, "beta_m": 0.3, "beta_n": 0.3,
    "clearcoat": 0.0, "clearcoatgloss": 1.0, "coneangle": 30.0, "conedelta": 5.0,
    "conedeltaangle": 5.0, "conductor.roughness": 0.0, "dimension": 2, "eta": 1.5, "g": 0.0,
    "height": 1.0,
    "innerradius": 0.0, "interface.eta": 1.5, "interface.roughness": 0.0, "maxdepth": 10,
    "metallic": 0.0, "octaves": 8, "phimax": 360.0, "radius": 1.0, "roughness": 0.0, "scale": 1.0,
    "sheen": 0.0, "sigma": 0.0, "spectrans": 0.0, "thickness": 0.01, "udelta": 0.0, "uscale": 1.0,
    "variation": 0.2, "vdelta": 0.0, "vscale": 1.0, "zmax": 1.0, "zmin": -1.0,
    "disk": {"height": 0.0}, "disney": {"roughness": 0.5}, "fbm": {"roughness": 0.5},
    "hair": {"eta": 1.55}, "kdsubsurface": {"eta": 1.33}, "marble": {"roughness": 0.5},
    "metal": {"roughness": 0.01}, "paraboloid": {"zmin": 0.0}, "plastic": {"roughness": 0.1},
    "substrate": {"roughness": 0.1}, "subsurface": {"eta": 1.33}, "uber": {"roughness": 0.1},
    "projection": {"fov": 90.0}, "windy": {"octaves": None, "roughness": None},
    "wrinkled": {"roughness": 0.5},
}  # fmt: skip
#: What has no effect by itself: a flat height, powers below 0, which stand for none, and what is
#: said to become something plainer.
WITHOUT = {"bumpmap", "illuminance", "power"}
PLAINER = {("dots", axis + name) for axis in "uv" for name in ("scale", "delta")}
PLAINER |= {("marble", "variation")}


def outcome(text, **options):
    """What a file becomes, and what is said."""
    try:
        found = read(text, **options)
    except SceneError as error:
        return (str(error),)
    return content_hash(found), repr(found.warnings), repr(found.source.remarks)


@pytest.fixture
def asked(monkeypatch):
    """What directives are asked for: (type, name) -> (default, whether it is a whole number)."""
    noted = {}

    def watch(owner, method, directive_of):
        ask = getattr(owner, method)

        def note(self, name, default):
            directive = directive_of(self)
            noted[directive.name, directive.type, name] = default, method == "integer"
            return ask(self, name, default)

        monkeypatch.setattr(owner, method, note)

    for method in ("number", "integer"):
        watch(Parameters, method, lambda self: self.directive)
    watch(Source, "number", lambda self: self.p.directive)
    return noted


@pytest.fixture
def textured(monkeypatch):
    """Names of what a material is asked for that may be a texture."""
    noted, ask = set(), Source.number

    def note(self, name, default):
        if self.p.directive.name == "Material":
            noted.add(name)
        return ask(self, name, default)

    monkeypatch.setattr(Source, "number", note)
    return noted


def test_a_texture_that_is_the_same_everywhere_is_its_number(textured):
    constant = 'Texture "t" "float" "constant" "float value" 0.3\n'
    kinds, form = DIRECTIVES["Material"]
    judged = 0
    for kind in kinds:
        textured.clear()
        content = CONTENT.get(f"Material {kind}", "")
        outcome(form.format(kind, content))
        for name in sorted(textured):
            number, texture = (
                outcome(constant + form.format(kind, f"{word} {content}"))
                for word in (f'"float {name}" 0.3', f'"texture {name}" "t"')
            )
            # What the number alone leaves unused is said.
            assert texture[0] == number[0], (kind, name)
            judged += 1
    assert judged > 20


@pytest.mark.parametrize("directive", DIRECTIVES)
def test_numbers_have_their_defaults_and_matter(directive, asked):
    kinds, form = DIRECTIVES[directive]
    judged = 0
    for kind in kinds:
        asked.clear()
        content = CONTENT.get(f"{directive} {kind}", CONTENT.get(kind, ""))
        silent = outcome(form.format(kind, content))
        if len(silent) == 1:
            continue
        names = {n: found for (d, t, n), found in asked.items() if (d, t) == (directive, kind)}
        for name, (default, whole) in names.items():
            if name in WITHOUT or (kind, name) in PLAINER:
                continue

            def said(number, name=name, whole=whole, kind=kind, content=content):
                word = "integer" if whole else "float"
                return outcome(form.format(kind, f'"{word} {name}" {number} {content}'))

            if default is not None:
                own = DEFAULTS.get(kind, {})
                assert default == own.get(name, DEFAULTS.get(name)), f"{kind}: {name}"
                assert said(default)[0] == silent[0], f"{kind}: {name} {default} is not as unsaid"
            other = (default or 0) + 1 if whole else 0.8 * (default or 0.0) + 0.03
            assert said(other) != silent, f"{kind}: {name} is without effect and remark"
            judged += 1
    assert judged > 3
