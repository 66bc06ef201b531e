"""What decides the bits of compiled code: the processor, the packet width, and all sources."""

from __future__ import annotations

import hashlib
import os
import platform
import sys
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from lanewise.application import LANEWISE, Application, application, setting, variable

#: What code is compiled for: this machine's processor, or any x86-64 processor since 2013 or so.
NATIVE, PORTABLE = TARGETS = "native", "portable"

#: The third target: PTX, which the driver of an NVIDIA GPU makes machine code of. A process that
#: has chosen it makes kernels for others (`lanewise.ptx`) and runs none.
PTX = "ptx"

#: LLVM's name of the latter, the third level of the x86-64 ABI, and what it has beyond the first.
#: None of its instructions gives other bits on a processor of another vendor but those that
#: estimate reciprocals and their square roots, which LLVM is kept from using.
PORTABLE_CPU = "x86-64-v3"
_PORTABLE_FEATURES = (
    "cx16", "sahf", "popcnt", "sse3", "ssse3", "sse4.1", "sse4.2", "avx", "avx2", "bmi", "bmi2",
    "f16c", "fma", "lzcnt", "movbe", "xsave",
)  # fmt: skip
_PORTABLE_LANES = 8

_target = NATIVE


def target() -> str:
    """What this process compiles for: one of `TARGETS`, or `PTX`."""
    return _target


def choose_target(name: str) -> None:
    """Compile for this target from now on.

    Raises
    ------
    ValueError
        If this process has compiled for another one, or this machine cannot run its code.
    """
    global _target
    if name == _target:
        return
    if name == PORTABLE and not _has_portable_features():
        raise ValueError(f"{PORTABLE} is code for {PORTABLE_CPU}, which this processor is not")
    if "lanewise.lane_types" in sys.modules:
        raise ValueError(f"this process has compiled for {_target}: {name} needs one of its own")
    _target = name


def features_of_target() -> dict[str, bool]:
    """What the processor that code is compiled for has, by LLVM's names."""
    if _target == PORTABLE:
        return dict.fromkeys(_PORTABLE_FEATURES, True)
    return _features() if _target == NATIVE else {}


@cache
def _features() -> dict[str, bool]:
    import llvmlite.binding as llvm

    return dict(llvm.get_host_cpu_features())


def _has_portable_features() -> bool:
    return all(_features().get(name) for name in _PORTABLE_FEATURES)


def lanes_of_machine() -> int:
    """Packet width: 16 with AVX-512, else 8; ``LANEWISE_LANES`` overrides if the target is native.

    A thread of a GPU is one lane.

    Asked once: what is compiled later has the same width.

    Raises
    ------
    ValueError
        If the setting is none of 1, 4, 8 and 16.
    """
    if _target == PTX:
        return 1
    return _PORTABLE_LANES if _target == PORTABLE else _native_lanes()


@cache
def _native_lanes() -> int:
    asked = setting("LANES")
    if asked is not None:
        if asked not in ("1", "4", "8", "16"):
            raise ValueError(f"{variable('LANES')} must be 1, 4, 8 or 16, got {asked!r}")
        return int(asked)
    return 16 if _features().get("avx512f") and _features().get("avx512vl") else 8


def describe_machine(of: str | None = None) -> dict[str, str]:
    """Everything that decides the bits of a result: sources, compiler, processor, lanes.

    Parameters
    ----------
    of : str, optional
        Of code for this target; by default for that of this process.
    """
    return dict(_describe(application(), of or _target))


@cache
def _describe(package: Application, target: str) -> dict[str, str]:
    return {
        f"sources of {package.name}": _digest_of_sources({LANEWISE, package}),
        **_describe_compiler(target),
    }


@cache
def _describe_compiler(target: str) -> dict[str, str]:
    from importlib.metadata import version

    import llvmlite.binding as llvm

    common = {
        "numba": version("numba"),
        "llvmlite": version("llvmlite"),
        "numpy": version("numpy"),
        "python": platform.python_version(),
        "platform": llvm.get_process_triple(),
        "target": target,
    }
    if target == PTX:
        return common
    if target == PORTABLE:
        other = "" if _has_portable_features() else f"{llvm.get_host_cpu_name()}, which is not "
        return common | {"processor": f"{other}{PORTABLE_CPU}"}
    return common | {
        "processor": llvm.get_host_cpu_name(),
        "features of the processor": llvm.get_host_cpu_features().flatten(),
        "lanes": str(_native_lanes()),
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


def fingerprint(of: str | None = None) -> str:
    """Short name for everything that `describe_machine` says."""
    return fingerprint_of(describe_machine(of))


def fingerprint_of(machine: Mapping[str, str]) -> str:
    """Short name for a description of a machine."""
    return _short(machine.values())


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


def cache_folder(of: str | None = None) -> Path:
    """Where compiled kernels are kept: a folder that changes with any source of the packages.

    ``LANEWISE_CACHE`` (``ALIGHT_CACHE``) moves it.

    Parameters
    ----------
    of : str, optional
        Kernels for this target; by default for that of this process.
    """
    return _cache_root() / fingerprint(of)


@cache
def _compiler_name(target: str) -> str:
    words = (_digest_of_sources({LANEWISE}), *_describe_compiler(target).values())
    return f"functions-{_short(words)}"


def functions_folder() -> Path:
    """Where the functions of kernels are kept, which sources outside lanewise do not name."""
    return _cache_root() / _compiler_name(_target)


def _cache_root() -> Path:
    base = setting("CACHE")
    if base is not None:
        return Path(base)
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / application().name


@cache
def processor() -> str:
    """The processor's name: times of two machines compare only if it is the same."""
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
