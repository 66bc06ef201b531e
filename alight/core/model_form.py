"""Is a user's model in the form of ours? What a file must hold, and all that is wrong with one."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType
from typing import Any

from alight.core.errors import nearest, show_value
from alight.core.registry import REGISTERED, type_name_of, user_number
from alight.core.spec import Light
from lanewise.jit import is_kernel
from lanewise.kernel_text import mistakes_in

#: Names that programs use for something else.
RESERVED = {
    "integrators": {"contributions"},
    "bsdfs": {"anisotropic"},
    "shapes": {"instance", "triangles", "pairs"},
    "media": {"chromatic", "emissive"},
    "lights": {"textured"},
}

#: The most examples that a model has.
MOST_EXAMPLES = 6


@dataclass(frozen=True)
class Form:
    """What a model of a family must have, and what it may have besides.

    Functions must take as many arguments as those of our own models do.

    Attributes
    ----------
    functions, kernels : tuple of str
    values : tuple of str
    more_functions, more_kernels : tuple of str
        They have a default, or only some models of the family need them.
    """

    functions: tuple[str, ...] = ()
    kernels: tuple[str, ...] = ()
    values: tuple[str, ...] = ()
    more_functions: tuple[str, ...] = ()
    more_kernels: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """All of them."""
        return (
            *self.functions, *self.kernels, *self.values, *self.more_functions, *self.more_kernels
        )  # fmt: skip


FORMS = {
    "shapes": Form(
        more_functions=("pack", "area", "bounds", "facing"),
        more_kernels=(
            "intersect",
            "surface",
            "derivatives",
            "sample",
            "pdf",
            "coordinates",
            "sample_area",
            "square",
        ),
    ),
    "bsdfs": Form(
        ("is_lossless", "is_reciprocal", "pack"),
        ("load", "evaluate", "sample", "albedo"),
        ("SLOTS",),
        more_functions=("features",),
    ),
    "textures": Form(("pack",), ("evaluate",), ("SLOTS",)),
    "lights": Form(
        ("place", "power"),
        ("sample",),
        ("DELTA",),
        (
            "mean_color",
            "cone",
            "table",
            "texture",
            "map_of",
            "beside_the_map",
            "disk_of",
            "window",
            "share_all_around",
            "emission_table",
        ),
        (
            "pdf",
            "emitted",
            "radiance",
            "emit",
            "emit_pdf",
            "left_out",
            "window_point",
            "window_pdf",
        ),
    ),
    "cameras": Form(
        ("half_extents", "pack"),
        ("generate_ray",),
        ("PERSPECTIVE",),
        more_kernels=("connect", "connect_far"),
    ),
    "samplers": Form(values=("EXPECTED_RATE",)),
    "filters": Form(("pack", "value"), ("sample",), more_kernels=("profile", "reach")),
    "phases": Form(("parameter", "mean_cosine"), ("density", "sample")),
    "media": Form(("pack", "density_at"), ("fly", "cross")),
    "integrators": Form(),
    "tone_curves": Form(("apply",), more_functions=("invert",)),
    "metrics": Form(
        ("evaluate",),
        values=("LABEL",),
        more_functions=("weight", "error_map", "label", "shown", "missing"),
    ),
}

#: What a shape with a formula has, and what those have that can shine.
FORMULA, BOUNDED, SHINING = ("pack", "intersect", "surface"), ("area", "bounds"), ("sample", "pdf")


def problems_of(source: Mapping[str, Any], family: str, name: str) -> list[str]:
    """All that is missing or wrong with a model, in words."""
    return [*_common_problems(source, family, name), *_form_problems(source, family)]


def _common_problems(source: Mapping[str, Any], family: str, name: str) -> list[str]:
    problems = []
    spec = type(source["EXAMPLES"][0])
    if "type" not in spec.model_fields:
        problems.append(f'{spec.__name__} needs a field: type: Literal["my_name"] = "my_name"')
    elif not re.fullmatch(r"[a-z][a-z0-9_]{0,59}", name):
        problems.append(f"the name must be of the form my_name, got {show_value(name)}")
    if len(source["EXAMPLES"]) > MOST_EXAMPLES:
        count = len(source["EXAMPLES"])
        problems.append(f"EXAMPLES must be 1 to {MOST_EXAMPLES} descriptions, got {count}")
    own = {type_name_of(module) for module in import_module(f"alight.{family}").MODELS}
    if name in own | RESERVED.get(family, set()):
        problems.append(f"{name} is a name of alight's own: choose another one")
    for other in REGISTERED[family]:
        if other != name and user_number(other) == user_number(name):
            text = f"{name} has the number of {other}, which is registered too"
            problems.append(f"{text} ({user_number(name)}): choose another name for one of them")
    return problems


def _form_problems(source: Mapping[str, Any], family: str) -> list[str]:
    form, problems = FORMS[family], []
    for name in (*form.values, *form.functions, *form.kernels, *_needed(source, family)):
        problems += [] if name in source else [_missing(name, source, _guide(source, name))]
    for name in (*form.functions, *form.kernels, *form.more_functions, *form.more_kernels):
        function = source.get(name)
        if function is None:
            continue
        if name in form.kernels + form.more_kernels and not is_kernel(function):
            problems.append(f"{name} must be a function marked with @kernel (lanewise.jit)")
        elif not callable(function):
            problems.append(f"{name} must be a function, got {show_value(function)}")
        else:
            problems += _arguments(name, function, _guide(source, name))
            if is_kernel(function):
                problems += mistakes_in(function)
    return problems + _SPECIAL.get(family, _no_more)(source)


def _needed(source: Mapping[str, Any], family: str) -> tuple[str, ...]:
    """What this model must have beyond the form of its family."""
    example = source["EXAMPLES"][0]
    if family == "shapes" and not example.parts():
        return FORMULA + (BOUNDED + SHINING if example.finite else ())
    if family == "lights" and example.placement != "node":
        return ("pdf", "emitted") if example.placement == "shape" else ("pdf",)
    return ()


def _guide(source: Mapping[str, Any], name: str) -> ModuleType:
    """The first of our own models that has a member of that name, and stands in the same place."""
    spec = type(source["EXAMPLES"][0])
    own = import_module(f"alight.{spec.family}").MODELS
    having = [model for model in own if name in vars(model)]
    if issubclass(spec, Light):
        place = spec.placement
        having = [m for m in having if m.EXAMPLES[0].placement == place] or having
    return having[0]


def _missing(name: str, source: Mapping[str, Any], guide: ModuleType) -> str:
    example = getattr(guide, name)
    shown = f"{name}{inspect.signature(example)}" if callable(example) else name
    near = nearest(name, [key for key in source if not key.startswith("__")])
    hint = f"; is it {near}?" if near else ""
    file = guide.__name__.replace(".", "/")
    return f"{shown.split(' ->')[0]} is missing{hint}  (see {file}.py)"


def _arguments(name: str, function: Callable, guide: ModuleType) -> list[str]:
    """Complain about a function that cannot be called like the guide's."""
    wanted = list(inspect.signature(getattr(guide, name)).parameters)
    given = inspect.signature(function)
    try:
        given.bind(*wanted)
    except TypeError:
        names = ", ".join(given.parameters)
        return [f"{name} must take ({', '.join(wanted)}), takes ({names})"]
    return []


def _no_more(source: Mapping[str, Any]) -> list[str]:
    return []


def _slot_problems(source: Mapping[str, Any]) -> list[str]:
    slots = source.get("SLOTS")
    good = isinstance(slots, Mapping) and all(
        isinstance(key, str) and isinstance(value, int) and value > 0
        for key, value in slots.items()
    )
    if slots is None or good:
        return []
    return [f"SLOTS must map names to how many numbers each has, got {show_value(slots)}"]


def _light_problems(source: Mapping[str, Any]) -> list[str]:
    placement, delta = type(source["EXAMPLES"][0]).placement, source.get("DELTA")
    if delta is (placement == "node"):
        return []
    hit = "cannot hit" if placement == "node" else "hit"
    place, wanted = show_value(placement), placement == "node"
    return [f"rays {hit} a light of placement {place}: DELTA must be {wanted}, got {delta}"]


def _rate_problems(source: Mapping[str, Any]) -> list[str]:
    problems = []
    rate = source.get("EXPECTED_RATE")
    if rate is not None and not (isinstance(rate, tuple | list) and len(rate) == 2):
        problems.append(
            f"EXPECTED_RATE must be two slopes, for 1-D and 2-D, got {show_value(rate)}"
        )
    make = source.get("make_kernels")
    if not callable(make):
        return [*problems, "make_kernels(...) is missing: it returns the kernels (get_1d, get_2d)"]
    wanted = [name for name in type(source["EXAMPLES"][0]).model_fields if name != "type"]
    given = inspect.signature(make)
    try:
        given.bind(*wanted)
    except TypeError:
        fields, takes = ", ".join(wanted), ", ".join(given.parameters)
        text = f"make_kernels must take the description's fields ({fields}), takes ({takes})"
        return [*problems, text]
    try:
        kernels = make(*(getattr(source["EXAMPLES"][0], name) for name in wanted))
    except Exception as error:
        return [*problems, f"make_kernels fails for the first example: {error}"]
    pair = isinstance(kernels, tuple) and len(kernels) == 2 and all(map(is_kernel, kernels))
    return problems if pair else [*problems, "make_kernels must return two kernels: get_1d, get_2d"]


def _step_problems(source: Mapping[str, Any]) -> list[str]:
    step = source.get("step")
    if not callable(step):
        return ["step(program) is missing: it returns the kernel (see alight/integrators/path.py)"]
    try:
        inspect.signature(step).bind("program")
    except TypeError:
        takes = ", ".join(inspect.signature(step).parameters)
        return [f"step must take (program), takes ({takes})"]
    return []


_SPECIAL: dict[str, Callable[[Mapping[str, Any]], list[str]]] = {
    "bsdfs": _slot_problems,
    "textures": _slot_problems,
    "lights": _light_problems,
    "samplers": _rate_problems,
    "integrators": _step_problems,
}
