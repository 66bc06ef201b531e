"""Materials of any registered model, for what they are needed for."""

from __future__ import annotations

from typing import Any

from alight.bsdfs.dielectrics.interface import Interface
from alight.bsdfs.fibres.hair import Hair
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.nesting import find_transmissive, leaves, scatters_inside
from alight.core.fields import Interval
from alight.core.registry import Models as Registry
from alight.core.spec import Bsdf
from alight.lab.random_scenes.chance import Chance
from alight.lab.random_scenes.descriptions import any_texture, of_model
from alight.lab.random_scenes.pictures import normals
from alight.textures.bitmap import Bitmap

UNIT = Interval(0.0, 1.0)
_COLORS = ("reflectance", "base_color", "diffuse_reflectance")


def any_material(chance: Chance) -> Bsdf:
    """Any model for any shape, nested ones too."""
    # What scatters light inside needs a closed shape: `translucent`.
    models = [m for m in Registry("bsdfs").values() if not scatters_inside(m.EXAMPLES[0])]
    return _bent(chance, of_model(chance, chance.choose(models)))


def translucent(chance: Chance) -> Bsdf:
    """A model with an inside that scatters light, for closed shapes of about 1 m."""
    models = [m for m in Registry("bsdfs").values() if scatters_inside(m.EXAMPLES[0])]
    found = of_model(chance, chance.choose(models))
    radius, fields = chance.scaled(0.005, 0.5), dict(found)
    # Much shorter mean free paths would make walks of many thousand steps.
    sizes = {"radius": tuple(radius * chance.within(0.2, 1.0) for _ in range(3)), "scale": 1.0}
    return found.replaced(**{name: size for name, size in sizes.items() if name in fields})


def fibre(chance: Chance) -> Bsdf:
    """Hair, or any other material: for strands."""
    hair = Registry("bsdfs")[Hair.type_name()]
    return of_model(chance, hair) if chance.happens(0.5) else any_material(chance)


def solid(chance: Chance) -> Bsdf:
    """A material that light does not pass."""
    for _ in range(20):
        found = any_material(chance)
        if find_transmissive(found, {}) is None:
            return found
    return Diffuse()


def wall(chance: Chance) -> Bsdf:
    """Mostly matt paint; else any solid model whose colour can be chosen: walls are not black."""
    if chance.happens(0.8):
        texture = any_texture(chance, UNIT) if chance.happens(0.15) else None
        bright = texture is not None and max(texture.mean()) > 0.2
        return Diffuse(reflectance=texture if bright else chance.color(0.3, 0.85))
    for _ in range(20):
        base: Any = solid(chance)
        name = _color_field(base)
        if name:
            return base.replaced(**{name: chance.color(0.3, 0.85)})
    return Diffuse()


def clear(chance: Chance) -> Bsdf:
    """A boundary between two clear media."""
    bsdfs = Registry("bsdfs").values()
    models = [module for module in bsdfs if isinstance(module.EXAMPLES[0], Interface)]
    found = of_model(chance, chance.choose(models))
    ratio = found.int_ior / found.ext_ior
    # The same index on both sides would be nothing to be seen.
    is_seen = max(ratio, 1.0 / ratio) > 1.1 or chance.happens(0.1)
    if is_seen:
        return found
    plain = {"dispersion": 0.0} if "dispersion" in dict(found) else {}
    return found.replaced(int_ior=chance.within(1.3, 2.0), ext_ior=1.0, **plain)


def glossy(chance: Chance) -> Bsdf:
    """A solid material of a model that has a roughness or an exponent."""
    for _ in range(20):
        found = solid(chance)
        fields = {name for leaf in leaves(found) for name in type(leaf.bsdf).model_fields}
        if fields & {"alpha", "roughness", "exponent", "coat_alpha"}:
            return found
    return solid(chance)


def textured(chance: Chance) -> Bsdf:
    """A matt material, or any other solid one, with a texture for its first colour."""
    base: Any = Diffuse() if chance.happens(0.5) else solid(chance)
    texture, name = any_texture(chance, UNIT), _color_field(base)
    return base.replaced(**{name: texture}) if name and texture else base


def _color_field(spec: Any) -> str:
    """The field that holds most of a model's colour; empty where none does by itself."""
    return next((name for name in _COLORS if name in dict(spec)), "")


def _bent(chance: Chance, spec: Any) -> Any:
    """Normals that are a map where a model bends them by one: a colour bends them all alike."""
    is_map = getattr(spec, "bends_normals", False) and hasattr(spec, "follow_uv")
    if not is_map or chance.happens(0.3):
        return spec
    return spec.replaced(texture=Bitmap(pixels=normals(chance), color_space="linear"))
