"""`register`: a user's own model, written in a script in the form of ours, joins its family.

A model is a module (or any namespace with the same attributes). Registering takes a *copy*: the
functions with the values that their globals have at that moment. What the script changes later has
no effect until it registers again, so machine code, caches and the Python twin always agree, and a
notebook may define one `evaluate` after the other. The copy carries a *version*, a digest of the
byte code and constants that its kernels are made from; programs, and with them the names of cached
machine code, contain the versions of the registered models that they use.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from types import CellType, FunctionType, ModuleType
from typing import Any, TypeVar

from alight.core.errors import AlightError, nearest, show_value
from alight.core.registry import FAMILIES, REGISTERED, VERSION, Models, type_name_of
from alight.core.spec import Light, Spec
from lanewise.jit import Specialised, is_kernel
from lanewise.source_digest import digest_of

T = TypeVar("T")

#: Names that programs use for something else.
RESERVED = {
    "integrators": {"aov"},
    "bsdfs": {"anisotropic"},
    "shapes": {"instance", "triangles", "pairs"},
    "media": {"chromatic", "emissive"},
    "lights": {"textured"},
}

#: The most examples that a model has.
MOST_EXAMPLES = 6


class RegistrationError(AlightError, TypeError):
    """A model that is not in the form of ours, with all that is wrong with it."""


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
        more_kernels=("intersect", "surface", "derivatives", "sample", "pdf", "coordinates"),
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
        ("mean_color", "cone", "table", "texture", "map_of", "beside_the_map"),
        ("pdf", "emitted", "radiance"),
    ),
    "cameras": Form(("half_extents", "pack"), ("generate_ray",), ("PERSPECTIVE",)),
    "samplers": Form(values=("EXPECTED_RATE",)),
    "filters": Form(("pack",), ("sample",)),
    "phases": Form(("parameter", "mean_cosine"), ("density", "sample")),
    "media": Form(("pack", "density_at"), ("fly", "cross")),
    "integrators": Form(),
}

#: What a shape with a formula has, and what those have that can shine.
FORMULA, BOUNDED, SHINING = ("pack", "intersect", "surface"), ("area", "bounds"), ("sample", "pdf")


def register(model: T) -> T:
    """Make a user's own model known: by name in scenes, compiled into the renderer.

    Parameters
    ----------
    model : module, str, class or namespace
        In the form of the model files of alight (docs/extending.md). A str is the name of an
        imported module: ``alight.register(__name__)`` at the end of a script registers the script.
        A class or a ``types.SimpleNamespace`` with the same attributes serves scripts and notebooks
        that hold several models.

    Returns
    -------
    model
        As given, so that ``@alight.register`` can decorate a class.

    Raises
    ------
    RegistrationError
        With all that is missing or wrong.

    Notes
    -----
    A model registered earlier under the same name is replaced; one of ours cannot be. Scenes made
    before keep the description that they were made with.
    """
    source, place = _attributes(model)
    family, name = _name_of(source, place)
    problems = [*_common_problems(source, family, name), *_form_problems(source, family)]
    if problems:
        kind = type(source["EXAMPLES"][0]).kind
        raise RegistrationError(
            "\n  ".join([f'{place}: {kind} "{name}" cannot be registered', *problems])
        )
    REGISTERED[family][name] = _copy(name, source, family)
    return model


def unregister(family: str, name: str) -> None:
    """Forget a registered model.

    Raises
    ------
    RegistrationError
        If there is none.
    """
    if name not in REGISTERED.get(family, {}):
        raise RegistrationError(f'"{name}" is not a registered model of the {family}')
    del REGISTERED[family][name]


def registered_module(model: object) -> ModuleType:
    """Find the registered or built-in module that a module, namespace or name denotes.

    Raises
    ------
    RegistrationError
        If it is in no registry.
    """
    source, place = _attributes(model)
    family, name = _name_of(source, place)
    if name not in Models(family):
        raise RegistrationError(f"{place}: register {name} first: alight.register(...)")
    return Models(family)[name]


# ---------------------------------------------------------------- what is given


def _attributes(model: object) -> tuple[dict[str, Any], str]:
    """Attributes of a module or namespace, and what to call it in messages."""
    if isinstance(model, str):
        if model not in sys.modules:
            raise RegistrationError(
                f"no module {show_value(model)} is imported; give the module itself, or __name__"
            )
        model = sys.modules[model]
    if isinstance(model, Mapping):
        return dict(model), "model"
    if not hasattr(model, "__dict__") or isinstance(model, Spec):
        raise RegistrationError(
            f"a model is a module, a class or a namespace, got {show_value(model)}"
        )
    source = dict(vars(model))
    # A class may hold its functions as static methods.
    plain = {k: v.__func__ if isinstance(v, staticmethod) else v for k, v in source.items()}
    file = source.get("__file__")
    place = str(file) if file else getattr(model, "__name__", type(model).__name__)
    return plain, place


def _name_of(source: Mapping[str, Any], place: str) -> tuple[str, str]:
    """Family and type name, from the examples."""
    examples = source.get("EXAMPLES")
    if not isinstance(examples, tuple | list) or not examples:
        found = [
            name
            for name, value in source.items()
            if isinstance(value, type) and issubclass(value, Spec) and not _is_ours(value)
        ]
        such = found[-1] if found else "Description"
        raise RegistrationError(
            f"{place}: EXAMPLES is missing: a tuple of 1 to {MOST_EXAMPLES} descriptions at the "
            f"corners of the parameter space, as ({such}(),)"
        )
    classes = {type(example) for example in examples}
    spec = type(examples[0])
    if len(classes) != 1 or not issubclass(spec, Spec):
        names = ", ".join(sorted(c.__name__ for c in classes))
        raise RegistrationError(f"{place}: EXAMPLES must be of one description, got {names}")
    if spec.family not in FORMS:
        families = ", ".join(f for f in FAMILIES if f in FORMS)
        raise RegistrationError(
            f"{place}: {spec.__name__} is of the family {show_value(spec.family)}; "
            f"models of these can be registered: {families}"
        )
    return spec.family, spec.type_name()


# ---------------------------------------------------------------- is it in our form?


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


# ---------------------------------------------------------------- the copy


def _copy(name: str, source: Mapping[str, Any], family: str) -> ModuleType:
    """A module with the attributes of a model, its functions bound to today's globals."""
    form = FORMS[family]
    names = (*form.names, "make_kernels", "step")
    copier = _Copier([source[key] for key in names if key in source])
    module = ModuleType(name, source.get("__doc__"))
    for key, value in source.items():
        if not key.startswith("__"):
            setattr(module, key, copier.value(value))
    used = {key: getattr(module, key) for key in names if hasattr(module, key)}
    setattr(module, VERSION, digest_of(used))
    return module


class _Copier:
    """Copies kernels and functions of scripts, so that they keep the globals of this moment."""

    def __init__(self, roots: list[Any]) -> None:
        self.copies: dict[int, Any] = {}
        self.scopes: dict[int, dict[str, Any]] = {}
        for root in roots:
            if isinstance(root, FunctionType) and not _is_ours(root):
                self.scope(root.__globals__)

    def value(self, value: Any) -> Any:
        """Copy what is kernel text, or a function of the scripts themselves, and not ours."""
        if isinstance(value, Specialised):
            factory = self.value(value.factory)
            if factory is value.factory:
                return value
            return self.copies.setdefault(id(value), Specialised(factory))
        if not isinstance(value, FunctionType) or _is_ours(value):
            return value
        if not (is_kernel(value) or id(value.__globals__) in self.scopes):
            return value
        return self.copies[id(value)] if id(value) in self.copies else self.function(value)

    def function(self, value: FunctionType) -> FunctionType:
        """The same code over copies of the globals and the closure."""
        cells = tuple(CellType() for _ in value.__closure__ or ())
        scope = self.scope(value.__globals__)
        if id(value) in self.copies:
            return self.copies[id(value)]
        code, name = value.__code__, value.__name__
        copy = FunctionType(code, scope, name, value.__defaults__, cells or None)
        copy.__kwdefaults__ = value.__kwdefaults__
        copy.__qualname__, copy.__module__ = value.__qualname__, value.__module__
        copy.__doc__, copy.__annotations__ = value.__doc__, value.__annotations__
        copy.__dict__.update(value.__dict__)
        # Known before its closure is copied: kernels may name each other.
        self.copies[id(value)] = copy
        for cell, old in zip(cells, value.__closure__ or (), strict=True):
            cell.cell_contents = self.value(old.cell_contents)
        return copy

    def scope(self, names: dict[str, Any]) -> dict[str, Any]:
        """The globals of a script as they are now, its functions copied."""
        if id(names) not in self.scopes:
            scope = self.scopes[id(names)] = dict(names)
            for key, value in names.items():
                scope[key] = self.value(value)
        return self.scopes[id(names)]


def _is_ours(value: FunctionType | type) -> bool:
    return (value.__module__ or "").split(".")[0] in ("alight", "lanewise")
