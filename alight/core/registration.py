"""`register`: a user's own model, written in a script in the form of ours, joins its family.

A model is a module (or any namespace with the same attributes). Registering takes a *copy*: the
functions with the values that their globals have at that moment. What the script changes later has
no effect until it registers again, so machine code, caches and the Python twin always agree, and a
notebook may define one `evaluate` after the other. The copy carries a *version*, a digest of the
byte code and constants that its kernels are made from; programs, and with them the names of cached
machine code, contain the versions of the registered models that they use.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from types import CellType, FunctionType, ModuleType
from typing import Any, TypeVar

from alight.core.errors import AlightError, show_value
from alight.core.model_form import FORMS, MOST_EXAMPLES, problems_of
from alight.core.registry import FAMILIES, REGISTERED, VERSION, Models, members_of
from alight.core.spec import Spec
from lanewise.jit import Specialised, is_kernel
from lanewise.source_digest import digest_of

T = TypeVar("T")


class RegistrationError(AlightError, TypeError):
    """A model that is not in the form of ours, with all that is wrong with it."""


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
    problems = problems_of(source, family, name)
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


# ---------------------------------------------------------------- the copy


def _copy(name: str, source: Mapping[str, Any], family: str) -> ModuleType:
    """A module with the attributes of a model, its functions bound to today's globals."""
    names = tuple(dict.fromkeys((*FORMS[family].names, *members_of(family))))
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
