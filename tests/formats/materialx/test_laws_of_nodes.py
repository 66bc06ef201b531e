"""Laws of nodes: each is its formula, and of textures what its formula makes of their texels."""

import colorsys
import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pillow

from alight.core.fields import Model
from alight.formats.materialx import gltf_pbr, open_pbr, preview_surface, standard_surface
from alight.formats.materialx.baking import _bitmaps, _evaluated, _image, _key, _value
from alight.formats.materialx.document import Document
from alight.formats.materialx.evaluate import Evaluator
from alight.formats.materialx.pointwise import LUMA, POINTWISE, folded
from alight.formats.materialx.rules import RULES
from alight.formats.materialx.scene import DocumentHost
from alight.formats.materialx.values import Plain, Varying, is_positive, limited, parts_of, positive
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report
from alight.laws.textures import values_at
from alight.scene.build import Builder
from tests.formats.materialx.reading import TEXELS, document, link, node, picture, value

SHADERS = (standard_surface, open_pbr, gltf_pbr, preview_surface)

# ---------------------------------------------------------------- formulas


def _each(formula):
    """A formula of one channel for all of them."""

    def of_all(*inputs):
        width = max(map(len, inputs))
        wide = [x if len(x) == width else x * width for x in inputs]
        return [formula(*channel) for channel in zip(*wide, strict=True)]

    return of_all


def _grey(x, weights=LUMA):
    return sum(a * w for a, w in zip(x, weights, strict=True))


def _hsv_adjusted(x, amount):
    h, s, v = colorsys.rgb_to_hsv(*x)
    return colorsys.hsv_to_rgb((h + amount[0]) % 1.0, s * amount[1], v * amount[2])


def _corrected(x, hue, saturation, gamma, lift, gain, contrast, pivot, exposure):
    rgb = _hsv_adjusted(x, (hue[0], 1.0, 1.0))
    grey = _grey(rgb)
    rgb = [grey + saturation[0] * (c - grey) for c in rgb]
    rgb = [math.copysign(abs(c) ** (1.0 / gamma[0]), c) for c in rgb]
    rgb = [(c * (1.0 - lift[0]) + lift[0]) * gain[0] for c in rgb]
    return [((c - pivot[0]) * contrast[0] + pivot[0]) * 2.0 ** exposure[0] for c in rgb]


def _blended(formula):
    """A formula of foreground and background, shown with a share."""
    return _each(lambda fg, bg, share: share * formula(fg, bg) + (1.0 - share) * bg)


def _ranged(x, a, b, gamma, c, d, clamped):
    t = (x - a) / (b - a)
    found = c + (d - c) * math.copysign(abs(t) ** (1.0 / gamma), t)
    return min(max(found, c), d) if clamped else found


def _smooth(x, low, high):
    t = min(max((x - low) / (high - low), 0.0), 1.0)
    return 3.0 * t * t - 2.0 * t * t * t


#: Node -> its formula, written down again: of lists of channels.
FORMULAS = {
    "absval": _each(abs),
    "acos": _each(math.acos),
    "add": _each(lambda a, b: a + b),
    "asin": _each(math.asin),
    "atan2": _each(math.atan2),
    "burn": _blended(lambda fg, bg: 1.0 - (1.0 - bg) / fg),
    "ceil": _each(math.ceil),
    "clamp": _each(lambda x, low, high: min(max(x, low), high)),
    "colorcorrect": _corrected,
    "contrast": _each(lambda x, amount, pivot: pivot + amount * (x - pivot)),
    "cos": _each(math.cos),
    "difference": _blended(lambda fg, bg: abs(fg - bg)),
    "divide": _each(lambda a, b: a / b),
    "dodge": _blended(lambda fg, bg: bg / (1.0 - fg)),
    "dotproduct": lambda a, b: [sum(x * y for x, y in zip(a, b, strict=True))],
    "exp": _each(math.exp),
    "floor": _each(math.floor),
    "fract": _each(lambda x: x % 1.0),
    "hsvadjust": _hsv_adjusted,
    "hsvtorgb": lambda x: colorsys.hsv_to_rgb(*x),
    "ifequal": _each(lambda a, b, x, y: x if a == b else y),
    "ifgreater": _each(lambda a, b, x, y: x if a > b else y),
    "ifgreatereq": _each(lambda a, b, x, y: x if a >= b else y),
    "invert": _each(lambda amount, x: amount - x),
    "ln": _each(math.log),
    "luminance": lambda x, weights: [_grey(x, weights)] * 3,
    "magnitude": lambda x: [math.hypot(*x)],
    "max": _each(max),
    "min": _each(min),
    "minus": _blended(lambda fg, bg: bg - fg),
    "mix": _each(lambda fg, bg, share: share * fg + (1.0 - share) * bg),
    "modulo": _each(lambda a, b: a % b),
    "multiply": _each(lambda a, b: a * b),
    "normalize": lambda x: [c / math.hypot(*x) for c in x],
    "overlay": _blended(
        lambda fg, bg: 2.0 * fg * bg if bg < 0.5 else 1.0 - 2.0 * (1.0 - fg) * (1.0 - bg)
    ),
    "plus": _blended(lambda fg, bg: bg + fg),
    "power": _each(lambda a, b: a**b),
    "range": _each(_ranged),
    "remap": _each(lambda x, a, b, c, d: c + (x - a) / (b - a) * (d - c)),
    "rgbtohsv": lambda x: colorsys.rgb_to_hsv(*x),
    "round": _each(lambda x: math.floor(x + 0.5)),
    "safepower": _each(lambda a, b: math.copysign(abs(a) ** b, a)),
    "saturate": lambda x, a, w: [a[0] * c + (1.0 - a[0]) * _grey(x, w) for c in x],
    "screen": _blended(lambda fg, bg: fg + bg - fg * bg),
    "sign": _each(lambda x: float(x > 0.0) - float(x < 0.0)),
    "sin": _each(math.sin),
    "smoothstep": _each(_smooth),
    "sqrt": _each(math.sqrt),
    "subtract": _each(lambda a, b: a - b),
    "tan": _each(math.tan),
    # Up from 0 to 1/2 and down again, over one period.
    "trianglewave": _each(lambda x: min(abs(x) % 1.0, 1.0 - abs(x) % 1.0)),
}  # fmt: skip

#: Nodes of colours, whose other inputs are one number (but for weights and amounts of all three).
OF_COLORS = ("colorcorrect", "hsvadjust", "hsvtorgb", "luminance", "rgbtohsv", "saturate")
#: Nodes whose first input may be anything.
OF_ANYTHING = ("absval", "add", "atan2", "ceil", "clamp", "contrast", "exp", "floor", "fract",
               "modulo", "range", "remap", "round", "safepower", "sign", "sin", "smoothstep",
               "subtract", "trianglewave")  # fmt: skip


def _inputs(category, rng):
    """Numbers where the formula has no limits of its own: not 0, and ends of intervals in order."""
    arguments = POINTWISE[category][1]
    inputs = [rng.uniform(0.05, 0.95, 3) for _ in arguments]
    names = [name for name, _ in arguments]
    if category in OF_ANYTHING:
        inputs[0] = 4.0 * inputs[0] - 2.0
    for low, high in (("low", "high"), ("inlow", "inhigh")):
        if low in names:
            i, k = names.index(low), names.index(high)
            inputs[i], inputs[k] = np.sort([inputs[i], inputs[k] + 0.01], axis=0)
    for i, (name, default) in enumerate(arguments):
        if name in ("value1", "value2", "doclamp"):
            inputs[i] = np.full(3, float(rng.integers(0, 2)))
        if category in OF_COLORS and i > 0 and not isinstance(default, tuple):
            inputs[i] = inputs[i][:1]
    return [tuple(map(float, x)) for x in inputs]


def test_every_node_is_its_formula():
    assert set(FORMULAS) == set(POINTWISE)
    rng = np.random.default_rng(8)
    for category, (function, _) in POINTWISE.items():
        for _ in range(20):
            inputs = _inputs(category, rng)
            meant = list(FORMULAS[category](*map(list, inputs)))
            assert folded(function, inputs) == pytest.approx(meant, abs=1e-9), (category, inputs)


def test_tables_are_those_of_the_library():
    """As `test_library` reads them where its package is installed: names in order, defaults."""
    stored = json.loads(Path(__file__).with_name("library.json").read_text("utf-8"))
    nodes = {name: dict(arguments) for name, (_, arguments) in POINTWISE.items()}
    shaders = {module.__name__.rpartition(".")[2]: module.INPUTS for module in SHADERS}
    found = json.loads(json.dumps({"nodes": nodes, "shaders": shaders}))
    assert found == stored
    for name, inputs in found["nodes"].items():
        assert list(inputs) == list(stored["nodes"][name]), name


# ---------------------------------------------------------------- textures


class Network:
    """What the nodes of a document give, as numbers at each texel of its pictures."""

    def __init__(self, folder, *nodes):
        self.report = Report(False)
        reach = Reach(folder)
        text = document(link("base_color", "color3", "x"), *nodes)
        [material] = Document(text, "a.mtlx", folder, reach, self.report).materials()
        evaluator = Evaluator(DocumentHost(self.report, reach))
        self.value = evaluator.value(material.shader, "base_color", (0.0,) * 3)
        assert not self.report.issues
        self.reach = reach

    @property
    def is_exact(self):
        """Whether nothing was left out."""
        return not any("left out" in line for line in self.report.warnings)

    def _images(self, texture):
        return {_key(b): _image(b, self.reach.files) for b in _bitmaps(texture)}

    def rows(self):
        """The value, of (4, 3)."""
        value = self.value
        images = {} if isinstance(value, Plain) else self._images(value.texture)
        return np.broadcast_to(_value(value, images, 4), (4, 3))

    def shown(self, texture):
        """What a texture of the native format shows."""
        return np.broadcast_to(_evaluated(texture, self._images(texture)), (4, 3))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With two pictures of 2 x 2 texels."""
    found = tmp_path_factory.mktemp("pictures")
    for name, texels in (("a", TEXELS), ("b", TEXELS[::-1, ::-1])):
        Pillow.fromarray(np.ascontiguousarray(texels)).save(found / f"{name}.png")
    return found


def _numbers(x):
    return ", ".join(f"{c:g}" for c in x)


#: Inputs that are one number, which no picture gives.
OF_ONE = ("value1", "value2", "doclamp")


def _drawn(name, rng, *, is_plain):
    """Nodes and the input of that name: numbers, a picture, or one stretched and moved."""
    kinds = ["grey numbers", "numbers", "picture", "grey picture", "affine", "bright"]
    kind = rng.choice(kinds[:1] if name in OF_ONE else kinds[:2] if is_plain else kinds)
    if kind == "numbers":
        return [], value(name, "color3", _numbers(rng.uniform(0.0, 1.5, 3).round(3)))
    if kind == "grey numbers":
        return [], value(name, "float", round(float(rng.uniform(-0.5, 1.5)), 3))
    file = str(rng.choice(["a.png", "b.png"]))
    shown = picture(f"{name}p", "float" if kind == "grey picture" else "color3", file=file)
    if kind != "affine":
        return [shown], link(name, "color3" if kind == "picture" else "float", f"{name}p")
    factor, offset = rng.uniform(-1.5, 2.0, 3).round(3), rng.uniform(-0.5, 1.0, 3).round(3)
    below = f"{name}p"
    if kind == "bright":
        # A texture that exceeds 1, upside down.
        both = link("in1", "color3", below), link("in2", "color3", below)
        shown, below = shown + node("add", f"{name}s", "color3", *both), f"{name}s"
        factor, offset = -0.5 * np.abs(factor), 2.0 + offset
    times = node("multiply", f"{name}m", "color3", link("in1", "color3", below),
                 value("in2", "color3", _numbers(factor)))  # fmt: skip
    plus = node("add", f"{name}a", "color3", link("in1", "color3", f"{name}m"),
                value("in2", "color3", _numbers(offset)))  # fmt: skip
    return [shown, times, plus], link(name, "color3", f"{name}a")


@pytest.mark.parametrize("category", RULES)
def test_textures_show_what_the_node_makes_of_their_texels(category, folder):
    function, arguments = POINTWISE[category]
    rng = np.random.default_rng(len(category))
    exact = 0
    for turn in range(40):
        nodes, inputs, rows = [], [], []
        for place, (name, default) in enumerate(arguments):
            more, entry = [], ""
            # Every other time a texture among numbers.
            is_plain = turn % 2 == 0 and place != turn // 2 % len(arguments)
            if rng.random() < (0.5 if is_plain else 0.9):
                more, entry = _drawn(name, rng, is_plain=is_plain)
            nodes, inputs = [*nodes, *more], [*inputs, entry]
            passed = node("dot", "x", "color3", entry.replace(f'name="{name}"', 'name="in"', 1))
            numbers = np.broadcast_to(np.asarray(default, float), (4, 3))
            rows.append(Network(folder, *more, passed).rows() if entry else numbers)
        found = Network(folder, *nodes, node(category, "x", "color3", *inputs))
        if not found.is_exact:
            continue
        exact += 1
        with np.errstate(all="ignore"):
            meant = np.broadcast_to(function(*rows), (4, 3))
        # What is divided by 0 elsewhere in the picture must not matter here.
        ok = np.isfinite(meant) & (np.abs(meant) < 10.0)
        np.testing.assert_allclose(found.rows()[ok], meant[ok], atol=2e-3)
        # As a texture of the native format it is the same.
        if not isinstance(found.value, Plain) and is_positive(found.value):
            np.testing.assert_allclose(found.shown(positive(found.value))[ok], meant[ok], atol=2e-3)
            cut = found.shown(limited(found.value, 0.7))
            np.testing.assert_allclose(cut[ok], np.minimum(meant, 0.7)[ok], atol=2e-3)
    assert exact > 20


def test_a_texel_over_nothing_leaves_the_others_as_they_are(folder):
    over = value("in1", "color3", "-0.3, 0.3, -3"), link("in2", "color3", "p")
    found = Network(folder, picture(), node("divide", "x", "color3", *over)).rows()
    below = Network(folder, picture("x")).rows()
    ok = below > 0.0
    assert not ok.all()
    meant = np.broadcast_to([-0.3, 0.3, -3.0], (4, 3))[ok] / below[ok]
    np.testing.assert_allclose(found[ok], meant, atol=2e-3)


def test_all_parts_of_a_texture_are_counted():
    leaf = {"type": "constant", "color": [0.5] * 3}
    tree, count = leaf, 1
    for keys in (["texture"], ["a", "b"], ["a", "b", "weight"], ["weight", "texture"]):
        tree, count = {"type": "mix"} | dict.fromkeys(keys, tree), 1 + count * len(keys)
    assert parts_of(tree, 1000) == count
    assert parts_of(tree, 7) > 7


def test_no_weight_of_a_mixture_exceeds_1():
    """What falls becomes a mixture by the texture, which must then stay within [0, 1]."""
    for factor, most in itertools.product((-0.2, 0.2), (0.5, 1.0, 4.0)):
        value = Varying({"type": "constant"}, (factor,), (0.9,), most)
        assert is_positive(value) == (factor > 0.0 or most <= 1.0)
    assert not is_positive(Varying({"type": "constant"}, (-1.0,), (0.9,), 1.0))


# ---------------------------------------------------------------- patterns


def _four(u, v, bl, br, tl, tr):
    return (1 - v) * ((1 - u) * bl + u * br) + v * ((1 - u) * tl + u * tr)


#: Node -> names of its values, and which of them is shown where, in shares.
PATTERNS_AT = {
    "ramplr": (("valuel", "valuer"), lambda u, v, left, right: (1 - u) * left + u * right),
    "ramptb": (("valueb", "valuet"), lambda u, v, low, high: (1 - v) * low + v * high),
    "splitlr": (("valuel", "valuer"), lambda u, v, left, right: np.where(u < 0.3, left, right)),
    "splittb": (("valueb", "valuet"), lambda u, v, low, high: np.where(v < 0.3, low, high)),
    "ramp4": (("valuebl", "valuebr", "valuetl", "valuetr"), _four),
    "checkerboard": (
        ("color2", "color1"),
        lambda u, v, near, other: np.where((2 * u) // 1 % 2 == (4 * v) // 1 % 2, near, other),
    ),
}


@pytest.mark.parametrize("category", PATTERNS_AT)
def test_patterns_show_what_they_say_at_every_point(category, folder):
    names, shown = PATTERNS_AT[category]
    rng = np.random.default_rng(5)
    values = rng.uniform(0.1, 0.9, (len(names), 3)).round(3)
    inputs = [value(n, "color3", _numbers(x)) for n, x in zip(names, values, strict=True)]
    inputs += [value("center", "float", 0.3)] if category.startswith("split") else []
    tiles = value("uvtiling", "vector2", "2, 4")
    inputs += [tiles] if category == "checkerboard" else []
    found = Network(folder, node(category, "x", "color3", *inputs))
    texture = Builder().model(Model("texture", "textures"), positive(found.value), "")
    u, v = rng.uniform(0.0, 1.0, (2, 500))
    # Beside the edges.
    u, v = (x[(np.abs(u - 0.3) > 0.01) & (np.abs(v - 0.3) > 0.01)] for x in (u, v))
    meant = shown(u, v, *(x[:, None] for x in values))
    np.testing.assert_allclose(values_at(texture, u, v), meant, atol=2e-3)


def test_noise_is_the_native_one_about_its_pivot(folder):
    inputs = value("amplitude", "vector3", "0.2, 0.1, 0.3"), value("pivot", "float", 0.4)
    found = Network(folder, node("noise2d", "x", "color3", *inputs)).value
    build = Builder()
    u, v = np.random.default_rng(6).uniform(0.0, 9.0, (2, 500))
    native = {"type": "noise", "space": "uv", "octaves": 1, "scale": [1.0, 1.0, 1.0]}
    plain = values_at(build.model(Model("texture", "textures"), native, ""), u, v)
    shown = values_at(build.model(Model("texture", "textures"), positive(found), ""), u, v)
    meant = 0.4 + np.array([[0.2], [0.1], [0.3]]) * (2.0 * plain - 1.0)
    np.testing.assert_allclose(shown, meant, atol=1e-5)
