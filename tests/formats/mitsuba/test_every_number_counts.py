"""Every number that a plugin is asked for has the default of its documentation, and matters.

What a reader asks for is noted while it reads a file that says nothing; then each number is said.
"""

import pytest

from alight.core.errors import SceneError
from alight.formats import dumps
from alight.formats.mitsuba import emitters, films, integrators, scene, sensors, shapes, textures
from alight.formats.mitsuba.properties import Properties
from tests.formats.mitsuba.reading import read

PICTURE = '<string name="filename" value="letters.png"/>'
METAL = '<bsdf type="roughconductor"/>'
LAYER = '<rgb name="sigma_a" value="0.1 0.2 0"/>'
BENT = '<texture name="normalmap" type="rawconstant"><vector name="value" value="0.5 0.4 0.9"/>'
#: What some plugins need.
CONTENT = {
    "bitmap": PICTURE,
    "blendbsdf": f'<float name="weight" value="0.5"/>{METAL}<bsdf type="diffuse"/>',
    "bumpmap": f'<texture type="checkerboard"/>{METAL}',
    "coating": LAYER + METAL,
    "envmap": PICTURE,
    "mask": METAL,
    "mesh_attribute": '<string name="name" value="vertex_color"/>',
    "mixturebsdf": f'<string name="weights" value="0.5 0.5"/>{METAL}{METAL}',
    "normalmap": f"{BENT}</texture>{METAL}",
    "projector": f'<texture name="irradiance" type="bitmap">{PICTURE}</texture>',
    "roughcoating": LAYER + METAL,
    "scale": f'<texture type="bitmap">{PICTURE}</texture>',
    "thinlens": '<float name="aperture_radius" value="0.1"/>',
    "twosided": METAL,
}
_OF_SENSORS = '<sensor type="perspective">%s</sensor>'
OBJECTS = {
    "bsdf": (scene.MATERIALS, '<bsdf id="it" type="{}">{}</bsdf>'),
    "texture": (
        textures.COVERED,
        '<bsdf id="it" type="diffuse"><texture name="reflectance" type="{}">{}</texture></bsdf>',
    ),
    "emitter": (emitters.NODES, '<emitter type="{}">{}</emitter>'),
    "shape": (shapes.COVERED, '<shape type="{}">{}</shape>'),
    "sensor": (sensors.COVERED, '<sensor type="{}">{}</sensor>'),
    "integrator": (integrators.COVERED, '<integrator type="{}">{}</integrator>'),
    "film": (films.FILMS, _OF_SENSORS % '<film type="{}">{}</film>'),
    "sampler": (films.SAMPLERS, _OF_SENSORS % '<sampler type="{}">{}</sampler>'),
    "rfilter": (
        ("box", "catmullrom", "gaussian", "mitchell", "tent"),
        _OF_SENSORS % '<film type="hdrfilm"><rfilter type="{}">{}</rfilter></film>',
    ),
}

_DEPTHS = {"max_depth": -1, "rr_depth": 5}
_FRAME = {"width": 768, "height": 576}
_CLOCK = {
    "year": 2010, "month": 7, "day": 10, "hour": 15.0, "minute": 0.0, "second": 0.0,
    "latitude": 35.6894, "longitude": 139.6917, "timezone": 9.0, "turbidity": 3.0, "scale": 1.0,
}  # fmt: skip
_UV = {"uscale": 1.0, "vscale": 1.0, "uoffset": 0.0, "voffset": 0.0}
#: As the documentation of Mitsuba 3 has them, and that of 0.6 for what only that has.
DEFAULTS = {
    "bdpt": _DEPTHS, "erpt": _DEPTHS, "mlt": _DEPTHS, "path": _DEPTHS, "photonmapper": _DEPTHS,
    "ppm": _DEPTHS, "prb": _DEPTHS, "prb_basic": _DEPTHS, "prb_projective": _DEPTHS,
    "prbvolpath": _DEPTHS, "pssmlt": _DEPTHS, "ptracer": _DEPTHS, "sppm": _DEPTHS,
    "volpath": _DEPTHS, "volpath_simple": _DEPTHS, "volpathmis": _DEPTHS, "vpl": _DEPTHS,
    "bitmap": _UV | {"gamma": 0.0}, "checkerboard": _UV,
    "bumpmap": {"scale": 1.0},
    "coating": {"thickness": 1.0},
    "gaussian": {"stddev": 0.5},
    "hair": {"longitudinal_roughness": 0.3, "azimuthal_roughness": 0.3, "scale_tilt": 2.0,
             "eumelanin": 1.3, "pheomelanin": 0.2},
    "hdrfilm": _FRAME, "ldrfilm": _FRAME,
    "mask": {"opacity": 0.5},
    "mesh_attribute": {"scale": 1.0},
    "mitchell": {"B": 1.0 / 3.0, "C": 1.0 / 3.0, "b": 1.0 / 3.0, "c": 1.0 / 3.0},
    "phong": {"exponent": 30.0},
    "pplastic": {"alpha": 0.1},
    "principled": {"roughness": 0.5, "specular": 0.5},
    "principledthin": {"roughness": 0.5, "eta": 1.5},
    "projector": {"fov": 45.0, "scale": 1.0},
    "roughcoating": {"alpha": 0.1, "thickness": 1.0},
    "roughconductor": {"alpha": 0.1}, "roughdielectric": {"alpha": 0.1},
    "roughdiffuse": {"alpha": 0.2}, "roughplastic": {"alpha": 0.1},
    "rawconstant": {"value": 0.0},
    "sky": _CLOCK, "sun": _CLOCK, "sunsky": _CLOCK | {"sun_scale": 1.0, "sky_scale": 1.0},
    "spot": {"cutoff_angle": 20.0},
    "tent": {"radius": 1.0},
    "thinlens": {"far_clip": 1e4, "focus_distance": 1e4},
    "ward": {"alpha": 0.1, "alpha_u": 0.1, "alpha_v": 0.1},
}  # fmt: skip
#: Of all samplers.
SAMPLES = 4
#: Defaults that the rest of the file decides, and numbers of samples that have no counterpart.
UNSAID = {"crop_offset_x", "crop_offset_y", "crop_width", "crop_height", "bsdf_samples",
          "emitter_samples", "shading_samples"}  # fmt: skip


def outcome(text, version):
    """What a file becomes, and what is said."""
    try:
        found = read(text, version)
    except SceneError as error:
        return (str(error),)
    return dumps(found), repr(found.warnings), repr(found.source.remarks)


@pytest.fixture
def asked(monkeypatch):
    """What plugins are asked for: (type, name) -> (default, whether it is a whole number)."""
    noted = {}

    def watch(method):
        ask = getattr(Properties, method)

        def note(self, name, default=None):
            noted[self.element.type, name] = default, method == "integer"
            return ask(self, name, default)

        monkeypatch.setattr(Properties, method, note)

    watch("number")
    watch("integer")
    return noted


def _with_capitals(name):
    """As version 0.6 spells it."""
    first, *others = name.split("_")
    return first + "".join(map(str.capitalize, others))


@pytest.mark.parametrize(
    ("version", "tag"),
    [("3.0.0", tag) for tag in OBJECTS] + [("0.5.0", t) for t in ("emitter", "texture", "rfilter")],
)
def test_numbers_have_their_defaults_and_matter(tag, version, asked):
    kinds, form = OBJECTS[tag]
    for kind in kinds:
        asked.clear()
        content = CONTENT.get(kind, "")
        silent = outcome(form.format(kind, content), version)
        names = {n: found for (t, n), found in asked.items() if t == kind}
        for name, (default, whole) in names.items():
            if f'name="{name}"' in content or "needs <" in silent[0]:
                continue
            given = name if version[0] == "3" else _with_capitals(name)

            def said(number, given=given, whole=whole, kind=kind, content=content):
                value = f'<{"integer" if whole else "float"} name="{given}" value="{number}"/>'
                return outcome(form.format(kind, value + content), version)

            if default is not None and name not in UNSAID:
                wanted = SAMPLES if tag == "sampler" else DEFAULTS.get(kind, {}).get(name)
                assert default == wanted, f"{kind}: {name}"
                assert said(default)[0] == silent[0], f"{kind}: {name} {default} is not as unsaid"
            other = (default or 0) + 1 if whole else 0.8 * (default or 0.0) + 0.03
            assert said(other) != silent, f"{kind}: {name} is without effect and remark"
