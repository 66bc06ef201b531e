"""The models of every family, by the name that scene files use.

A family is a package with one file per model and a tuple ``MODELS`` of those modules; models that a
user has registered (`alight.core.registration`) follow after them. Families are imported by name at
the first use: integrators live above the scene in the order of imports (they run on the compiled
scene), yet a scene file names them.

Every lookup reads the registries afresh, so that a model can be registered at any time.
"""

from __future__ import annotations

import sys
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from functools import lru_cache
from importlib import import_module
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

if TYPE_CHECKING:
    from types import ModuleType

    from alight.core.spec import Spec

S = TypeVar("S", bound="Spec")
R = TypeVar("R", bound="Record")

#: A function marked with `lanewise.jit.kernel`, or with `specialised`.
Kernel = Callable[..., Any]

#: Of what scenes are made.
FAMILIES_OF_SCENES = (
    "shapes",
    "bsdfs",
    "textures",
    "lights",
    "cameras",
    "samplers",
    "filters",
    "phases",
    "media",
    "integrators",
)

FAMILIES = (*FAMILIES_OF_SCENES, "tone_curves", "metrics")

#: What users have registered: family -> type name -> module; changed by `registration` only.
REGISTERED: dict[str, dict[str, ModuleType]] = {family: {} for family in FAMILIES}

#: Attribute of a registered module: a digest of all that its kernels are made from.
VERSION = "__alight_version__"


def modules(family: str) -> tuple[ModuleType, ...]:
    """List the model modules of a family: its registry tuple, then what users registered."""
    name = f"alight.{family}"
    # Asked for each node of a scene: most of the time of an import is to find it done.
    package = sys.modules.get(name) or import_module(name)
    return (*package.MODELS, *REGISTERED[family].values())


def type_name_of(module: ModuleType) -> str:
    """Give the name of a model in scene files."""
    return type(module.EXAMPLES[0]).type_name()


def specs(family: str) -> dict[str, type[Spec]]:
    """Map type names to description classes, for one family.

    Examples
    --------
    >>> "checkerboard" in specs("textures")
    True
    """
    return _specs(modules(family))


def default_of(base: type[S]) -> S:
    """Give what a family has where nothing is named: the ``DEFAULT`` of its registry."""
    return import_module(f"alight.{base.family}").DEFAULT


def specs_of(base: type[S]) -> dict[str, type[S]]:
    """Map type names to description classes, for the family of a base class."""
    return cast("dict[str, type[S]]", specs(base.family))


@lru_cache(maxsize=64)
def _specs(models: tuple[ModuleType, ...]) -> dict[str, type[Spec]]:
    return {type_name_of(module): type(module.EXAMPLES[0]) for module in models}


@lru_cache(maxsize=64)
def _by_name(models: tuple[ModuleType, ...]) -> dict[str, ModuleType]:
    return {type_name_of(module): module for module in models}


@lru_cache(maxsize=64)
def _numbers(family: str, models: tuple[ModuleType, ...]) -> dict[str, int]:
    own = len(models) - len(REGISTERED[family])
    names = map(type_name_of, models)
    return {
        name: number if number < own else user_number(name) for number, name in enumerate(names)
    }


def user_number(name: str) -> int:
    """Number of a user's model: machine code that knows it outlives what else is registered."""
    return (1 << 16) + zlib.crc32(name.encode()) % (1 << 16)


class Models(Mapping[str, "ModuleType"]):
    """The modules of a family by type name, in the order of the registry; a live view."""

    def __init__(self, family: str) -> None:
        self.family = family

    def __getitem__(self, name: str) -> ModuleType:
        return _by_name(modules(self.family))[name]

    def __iter__(self) -> Iterator[str]:
        return iter(_by_name(modules(self.family)))

    def __len__(self) -> int:
        return len(modules(self.family))


class Numbers(Mapping[str, int]):
    """The numbers of a family's models in tables and kernels, by name; a live view."""

    def __init__(self, family: str) -> None:
        self.family = family

    def __getitem__(self, name: str) -> int:
        return _numbers(self.family, modules(self.family))[name]

    def __iter__(self) -> Iterator[str]:
        return iter(_numbers(self.family, modules(self.family)))

    def __len__(self) -> int:
        return len(modules(self.family))


@dataclass(frozen=True, eq=False, kw_only=True)
class Record:
    """What others take from a model's file; each family says what that is by a class of this kind.

    Fields are called as in the file. What has a default may be left out there.

    Attributes
    ----------
    name : str
        In scene files.
    number : int
        In tables and kernels.
    EXAMPLES : tuple of Spec
    """

    name: str
    number: int
    EXAMPLES: tuple[Any, ...] = ()

    @property
    def spec(self) -> type[Any]:
        """Class of the descriptions."""
        return type(self.EXAMPLES[0])


#: Family -> what others take from a model's file.
_RECORDS: dict[str, type[Record]] = {}


def members_of(family: str) -> tuple[str, ...]:
    """Name what others take from a model's file."""
    import_module(f"alight.{family}.model")
    return tuple(f.name for f in fields(_RECORDS[family]) if f not in fields(Record))


class Records(Mapping[str, R], Generic[R]):
    """The records of a family by type name, in the order of the registry; a live view."""

    def __init__(self, family: str, record: type[R]) -> None:
        self.family, self.record = family, record
        _RECORDS[family] = record

    def __getitem__(self, name: str) -> R:
        models = modules(self.family)
        number = _numbers(self.family, models)[name]
        return record_of(_by_name(models)[name], self.record, name, number)

    def __iter__(self) -> Iterator[str]:
        return iter(_by_name(modules(self.family)))

    def __len__(self) -> int:
        return len(modules(self.family))


def record_of(module: ModuleType, record: type[R], name: str, number: int = -1) -> R:
    """What a module says of the fields of a record; those in no registry have no number."""
    return cast("R", _record_of(module, record, name, number))


@lru_cache(maxsize=1024)
def _record_of(module: ModuleType, record: type[Record], name: str, number: int) -> Record:
    given = {f.name: vars(module)[f.name] for f in fields(record) if f.name in vars(module)}
    return record(**{**given, "name": name, "number": number})


def versions(specs: Iterable[Spec]) -> tuple[tuple[str, str, str], ...]:
    """Which registered models descriptions use, nested ones too: (family, name, version), sorted.

    Machine code and pictures made with them depend on the user's source by these.
    """
    found: set[tuple[str, str, str]] = set()
    if any(REGISTERED.values()):
        for spec in specs:
            _collect(spec, found)
    return tuple(sorted(found))


def registered_versions(family: str) -> tuple[tuple[str, str], ...]:
    """All registered models of a family: (name, version), sorted."""
    return tuple(sorted((n, getattr(m, VERSION)) for n, m in REGISTERED[family].items()))


def _collect(value: Any, found: set[tuple[str, str, str]]) -> None:
    if isinstance(value, tuple | list):
        for item in value:
            _collect(item, found)
        return
    family = getattr(type(value), "family", None)
    if family not in REGISTERED:
        return
    name = type(value).type_name()
    if name in REGISTERED[family]:
        found.add((family, name, getattr(REGISTERED[family][name], VERSION)))
    for _, field in value:
        _collect(field, found)
