"""What the readers of shaders have in common."""

from __future__ import annotations

import math
from typing import Any

from alight.core.errors import quote
from alight.formats.materials.surfaces import LARGEST_IOR, Surface, abbe_number
from alight.formats.materials.textures import FLAT_NORMAL, normal_color, normals
from alight.formats.materialx.evaluate import Evaluator
from alight.formats.materialx.nodes import Node
from alight.formats.materialx.values import Plain, Value, Varying, affine, number, part, spread
from alight.formats.reading.report import did_you_mean

Data = dict[str, Any]
#: Index of the coat of `principled`.
COAT_IOR = 1.5
WHITE = number(1.0)
BLACK = number(0.0)


class Shading:
    """The inputs of one surface shader.

    Parameters
    ----------
    node : Node
    evaluator : Evaluator
    """

    def __init__(self, node: Node, evaluator: Evaluator) -> None:
        self.node, self.evaluator = node, evaluator
        self.asked: set[str] = set()

    @property
    def sets(self) -> tuple[str, ...]:
        """Sets of coordinates that its textures use."""
        return tuple(self.evaluator.sets)

    @property
    def meters(self) -> float:
        """Length of the unit of the file."""
        return self.evaluator.host.meters

    def say(self, text: str) -> None:
        """Remark on what is not quite what the shader says."""
        self.evaluator.say(self.node, text)

    def value(self, name: str, default: float | tuple[float, ...]) -> Value:
        """Value of an input."""
        self.asked.add(name)
        return self.evaluator.value(self.node, name, default)

    def constant(self, name: str, default: float, low: float = 0.0, high: float = 1e30) -> float:
        """An input that `principled` has as a number only."""
        found = self.value(name, default)
        if isinstance(found, Varying):
            self.say(f"{name} varies, which is left out: {default:g} is taken")
            return default
        limited = min(max(found.numbers[0], low), high)
        if limited != found.numbers[0]:
            self.say(f"{name} {found.numbers[0]:g} became {limited:g}")
        return limited

    def flag(self, name: str) -> bool:
        """A truth value."""
        found = self.value(name, 0.0)
        return isinstance(found, Plain) and found.numbers[0] != 0.0

    def ior(self, name: str, default: float = 1.5) -> float:
        """An index of refraction."""
        index = self.constant(name, default, 0.2, LARGEST_IOR)
        if index < 1.0:
            # Indices below 1 are seen from inside the denser side.
            self.say(f"{name} {index:g} became {1.0 / index:g}")
            return min(1.0 / index, LARGEST_IOR)
        return index

    def product(self, *values: Value) -> Value:
        """Of values: 0 where one of them is 0 everywhere, whatever varies."""
        if any(is_zero(value) for value in values):
            return Plain((0.0,) * max(value.width for value in values))
        total = values[0]
        for value in values[1:]:
            if isinstance(value, Plain) and set(value.numbers) == {1.0}:
                total = spread(total, max(total.width, value.width))
                continue
            total = self.evaluator.apply(self.node, "multiply", total, value)
        return total

    def mixed(self, low: Value, high: Value, share: Value) -> Value:
        """Low where the share is 0, high where it is 1."""
        if is_zero(share):
            return low
        return self.evaluator.mixed(self.node, low, high, share)

    def color(self, name: str, value: Value, high: float = 1.0) -> Any:
        """A colour or a texture of the native format."""
        value = spread(value, 3)
        return self.evaluator.described(self.node, name, value, high)

    def number(self, name: str, value: Value) -> Any:
        """A number or a texture in [0, 1]."""
        return self.evaluator.described(self.node, name, part(value, 0))

    def thickness(self, nanometres: Value) -> Any:
        """Thickness of a film, at most 0.1 mm."""
        return self.evaluator.described(self.node, "thickness of the film", nanometres, 1e5)

    def grey(self, name: str, color: Value) -> Value:
        """The luminance of a colour."""
        if color.width == 1:
            return color
        return part(self.evaluator.apply(self.node, "luminance", color), 0)

    def left_out(self, why: str, **neutral: float | tuple[float, ...]) -> None:
        """Tell of inputs that change the picture, unless they have a neutral value."""
        for name, default in neutral.items():
            if name not in self.node.inputs:
                self.asked.add(name)
                continue
            found = self.value(name, default)
            wanted = default if isinstance(default, tuple) else (default,)
            if isinstance(found, Varying) or any(n not in wanted for n in found.numbers):
                self.say(f"{name} is left out: {why}")

    def emission(self, name: str, color: Value, weight: Value) -> Any:
        """Radiance, or None where nothing shines."""
        if is_zero(color) or is_zero(weight):
            return None
        return self.color(name, self.product(color, weight), math.inf)

    def brush(self, roughness: Value, anisotropy: Value, *, open_pbr: bool) -> Data:
        """Roughness and anisotropy of `principled` for two roughnesses of MaterialX.

        Of numbers both alphas come out exactly: ours are alpha along one direction and
        alpha + (1 - alpha) a^2 along the other.
        """
        if is_zero(anisotropy):
            return {"roughness": self.number("roughness", roughness)}
        if isinstance(roughness, Varying) or isinstance(anisotropy, Varying):
            self.say("anisotropy with textures: its strength is taken as the root of ours")
            return {
                "roughness": self.number("roughness", roughness),
                "anisotropy": self.number("anisotropy", anisotropy),
            }
        alpha = min(max(roughness.numbers[0], 0.0), 1.0) ** 2
        strength = min(max(anisotropy.numbers[0], 0.0), 1.0)
        if open_pbr:
            along = alpha * math.sqrt(2.0 / (1.0 + (1.0 - strength) ** 2))
            along, across = min(along, 1.0), (1.0 - strength) * along
        else:
            aspect = math.sqrt(1.0 - min(strength, 0.98))
            along, across = min(alpha / aspect, 1.0), alpha * aspect
        root = math.sqrt(max(along - across, 0.0) / (1.0 - across)) if across < 1.0 else 0.0
        return {"roughness": math.sqrt(across), "anisotropy": min(root, 1.0)}

    def coat(self, weight: Value, roughness: Value, index: float) -> Data:
        """A clear coat; one of another index is as strong straight on."""
        if is_zero(weight):
            return {}
        wanted, ours = (((n - 1.0) / (n + 1.0)) ** 2 for n in (index, COAT_IOR))
        if abs(index - COAT_IOR) > 1e-6:
            factor = wanted / ours
            largest = weight.numbers[0] if isinstance(weight, Plain) else weight.ends[0][1]
            factor = min(factor, 1.0 / max(largest, 1e-6))
            said = "it is as strong straight on" if factor == wanted / ours else "it is weaker"
            self.say(f"the coat of index {index:g} became one of {COAT_IOR:g}: {said}")
            weight = affine(weight, (factor,), (0.0,))
        return {
            "clearcoat": self.number("coat", weight),
            "clearcoat_roughness": self.number("coat roughness", roughness),
        }

    def glass(
        self, core: Data, transmission: Value, color: Value, depth: float, thin: bool
    ) -> None:
        """Let light through, tinted at each crossing, or inside with a depth."""
        if is_zero(transmission):
            return
        core["transmission"] = self.number("transmission", transmission)
        if thin:
            core["thin"] = True
        tint = color
        if depth > 0.0 and not thin:
            core["attenuation_distance"] = depth
            core["attenuation_color"] = self._plain_color(color)
            tint = WHITE
        if is_one(transmission) and core.get("metallic", 0.0) == 0.0:
            core["base_color"] = self.color("transmission color", tint)
            return
        base = core["base_color"]
        if self.color("transmission color", tint) != base:
            self.say("what is let through has the base colour: the material has one for both")

    def dispersion(self, core: Data, number: float) -> None:
        """Abbe's number of glass that is no sheet; 0 for none."""
        if number > 0.0 and core.get("transmission", 0.0) != 0.0 and not core.get("thin", False):
            found = core["dispersion"] = abbe_number(number, core["ior"])
            if found != number:
                self.say(f"the Abbe number {number:g} became {found:g}")

    def _plain_color(self, color: Value) -> list[float]:
        if isinstance(color, Varying):
            self.say("a transmission colour with a depth must not vary: white is taken")
            return [1.0] * 3
        return self.color("transmission color", color)

    def finished(
        self,
        core: Data,
        bent: Data | None,
        opacity: Any = 1.0,
        emission: Any = None,
        inside: Data | None = None,
    ) -> Surface:
        """The surface of all that has been read."""
        return Surface(core, bent, opacity, emission, sets=self.sets, inside=inside)

    # ---------------------------------------------------------------- normals

    def normals(self, name: str, *, is_tangent: bool = False) -> Data | None:
        """What bends the normals: the wrapper of the native format, without what it wraps.

        Parameters
        ----------
        is_tangent : bool
            Whether the input is the normal in the tangent's frame, as that of UsdPreviewSurface.
        """
        self.asked.add(name)
        entry = self.node.inputs.get(name)
        if entry is None:
            return None
        if entry.source is None:
            plain = entry.value
            if not is_tangent or not isinstance(plain, tuple) or plain == (0.0, 0.0, 1.0):
                return None
            return {"type": "normal_map", "texture": normal_color(plain)}
        source, passed = entry.source, [entry.source]
        while source.category == "dot" and source.inputs.get("in") is not None:
            inner = source.inputs["in"].source
            if inner is None:
                return None
            if inner in passed:
                self.evaluator.host.report.problem(inner.place, inner.name, "contains itself")
                return None
            source = inner
            passed.append(source)
        if source.category == "normalmap":
            return self._normal_map(source)
        if source.category == "bump":
            return self._bump_map(source, "height")
        if source.category in ("normal", "geompropvalue"):
            return None
        if is_tangent:
            return self._bent(source, self.evaluator.output(source, entry.output), 1.0)
        self.say(f"{name} comes from a {quote(source.category)}, which is left out")
        return None

    def coat_normals(self, name: str, below: Data | None) -> Data:
        """Normals of a coat: those of its input, or of the surface itself.

        Parameters
        ----------
        below : dict or None
            What bends the normals of what lies below it.
        """
        own = self.normals(name)
        if own == below:
            return {}
        if own is None:
            return {"clearcoat_normal": FLAT_NORMAL}
        if own["type"] != "normal_map":
            self.say(f"{name} comes from heights: the coat has the normals of what is below it")
            return {}
        scale = own.get("scale", 1.0)
        return {"clearcoat_normal": own["texture"], "clearcoat_normal_scale": scale}

    def _normal_map(self, node: Node) -> Data | None:
        entry = node.inputs.get("in")
        below = None if entry is None else entry.source
        if below is not None and below.category == "heighttonormal":
            return self._bump_map(below, "in")
        found = self.evaluator.value(node, "in", (0.5, 0.5, 1.0))
        scale = self.evaluator.value(node, "scale", (1.0,))
        if isinstance(scale, Varying):
            self.say("the scale of a normal map varies: 1 is taken")
            scale = WHITE
        if len(set(scale.numbers)) > 1:
            self.say("a normal map has one scale: the first one is taken")
        if node.plain("space", "tangent") == "object":
            self.say("normals in the space of the object are left out")
            return None
        double = affine(found, (2.0,) * 3, (-1.0,) * 3)
        return self._bent(node, double, scale.numbers[0])

    def _bent(self, node: Node, normal: Value, scale: float) -> Data | None:
        if isinstance(normal, Plain):
            if normal.numbers[:3] == (0.0, 0.0, 1.0):
                return None
            return {"type": "normal_map", "texture": normal_color(normal.numbers[:3])}
        if normal.width < 3:
            self.evaluator.say(node, "its normals lack a third part: they are left out")
            return None
        if normal.most > 1.0:
            self.evaluator.say(node, "its normals have no bounds: they are left out")
            return None
        if scale < 0.0:
            # Ours has no sign: both slopes turn round.
            normal, scale = affine(normal, (-1.0, -1.0, 1.0), (0.0,) * 3), -scale
            assert isinstance(normal, Varying)
        texture = normals(normal.texture, normal.factor, normal.offset)
        data: Data = {"type": "normal_map", "texture": texture}
        return data if scale == 1.0 else data | {"scale": scale}

    def _bump_map(self, node: Node, name: str) -> Data | None:
        height = self.evaluator.value(node, name, (0.0,))
        if isinstance(height, Plain):
            return None
        scale = self.evaluator.constant(node, self.evaluator.value(node, "scale", (1.0,)), 1)[0]
        self.evaluator.say(node, "heights are taken as lengths in the unit of the coordinates")
        described = self.evaluator.described(node, name, part(height, 0), math.inf)
        return {"type": "bump_map", "texture": described, "scale": scale}

    def say_what_is_unknown(self) -> None:
        """Tell of inputs that the shader does not have."""
        for name in self.node.inputs:
            if name not in self.asked:
                hint = did_you_mean(name, self.asked)
                self.say(f"unknown input {quote(name)} is left out{hint}")


def is_zero(value: Value) -> bool:
    """Whether a value is 0 everywhere."""
    return isinstance(value, Plain) and not any(value.numbers)


def is_one(value: Value) -> bool:
    """Whether a value is 1 everywhere."""
    return isinstance(value, Plain) and set(value.numbers) == {1.0}
