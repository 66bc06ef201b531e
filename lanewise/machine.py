"""What decides the bits of compiled code: the processor, the packet width, and all sources."""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from lanewise.application import LANEWISE, Application, application, setting, variable


@cache
def lanes_of_machine() -> int:
    """Packet width: 16 with AVX-512, else 8; ``LANEWISE_LANES`` overrides.

    Asked once: what is compiled later has the same width.

    Raises
    ------
    ValueError
        If the setting is none of 1, 4, 8 and 16.
    """
    asked = setting("LANES")
    if asked is not None:
        if asked not in ("1", "4", "8", "16"):
            raise ValueError(f"{variable('LANES')} must be 1, 4, 8 or 16, got {asked!r}")
        return int(asked)
    import llvmlite.binding as llvm

    features = llvm.get_host_cpu_features()
    return 16 if features.get("avx512f") and features.get("avx512vl") else 8


def describe_machine() -> dict[str, str]:
    """Everything that decides the bits of a result: sources, compiler, processor, lanes."""
    return _describe(application())


@cache
def _describe(package: Application) -> dict[str, str]:
    return {
        f"sources of {package.name}": _digest_of_sources({LANEWISE, package}),
        **_describe_compiler(),
    }


@cache
def _describe_compiler() -> dict[str, str]:
    from importlib.metadata import version

    import llvmlite.binding as llvm

    return {
        "numba": version("numba"),
        "llvmlite": version("llvmlite"),
        "numpy": version("numpy"),
        "python": platform.python_version(),
        "processor": llvm.get_host_cpu_name(),
        "features of the processor": llvm.get_host_cpu_features().flatten(),
        "lanes": str(lanes_of_machine()),
        "NUMBA_CPU_NAME": os.environ.get("NUMBA_CPU_NAME", ""),
        "NUMBA_CPU_FEATURES": os.environ.get("NUMBA_CPU_FEATURES", ""),
    }


def differing(machine: Mapping[str, str], own: Mapping[str, str]) -> list[str]:
    """Say what another machine's description has otherwise than our own."""
    return [
        f"{name} is {machine.get(name)}, not {value}"
        for name, value in own.items()
        if machine.get(name) != value
    ]


def fingerprint() -> str:
    """Short name for everything that `describe_machine` says."""
    return _short(describe_machine().values())


def _short(words: Iterable[str]) -> str:
    return hashlib.sha256("|".join(words).encode()).hexdigest()[:20]


def _digest_of_sources(packages: set[Application]) -> str:
    h = hashlib.sha256()
    for package in sorted(packages):
        folder = Path(package.folder)
        for path in sorted(folder.rglob("*.py")):
            h.update(f"{package.name}/{path.relative_to(folder)}".encode())
            h.update(path.read_bytes())
    return h.hexdigest()[:20]


def cache_folder() -> Path:
    """Where compiled kernels are kept: a folder that changes with any source of the packages.

    ``LANEWISE_CACHE`` (``ALIGHT_CACHE``) moves it.
    """
    return _cache_root() / fingerprint()


@cache
def _compiler_name() -> str:
    words = (_digest_of_sources({LANEWISE}), *_describe_compiler().values())
    return f"functions-{_short(words)}"


def functions_folder() -> Path:
    """Where the functions of kernels are kept, which sources outside lanewise do not name."""
    return _cache_root() / _compiler_name()


def _cache_root() -> Path:
    base = setting("CACHE")
    if base is not None:
        return Path(base)
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / application().name
