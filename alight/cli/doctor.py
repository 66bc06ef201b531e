"""``alight doctor``: what this machine supports, and how to get what is missing."""

from __future__ import annotations

import platform
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

import typer

from alight.core.extras import install_command, requirements

#: Processor features that decide speed, in the order of their age.
_FEATURES = ("sse4.2", "avx", "avx2", "fma", "avx512f", "avx512vl", "neon", "sve")


def doctor() -> None:
    """Check this machine: versions, processor, cache, optional packages."""
    healthy = True
    for name, value, good in [*_machine(), *_compiler(), *_packages()]:
        typer.echo(f"{'ok ' if good else 'BAD'} {name:<18}{value}")
        healthy &= good
    for line in _extras():
        typer.echo(line)
    if not healthy:
        raise typer.Exit(1)


Check = tuple[str, str, bool]


def _machine() -> Iterator[Check]:
    from alight import __version__
    from alight.rendering.resources import usable_processors

    version = sys.version_info
    yield "alight", __version__, True
    good = (3, 11) <= version[:2] <= (3, 13)
    hint = "" if good else "; alight is tested with Python 3.11 to 3.13"
    yield "python", f"{platform.python_version()} ({sys.executable}){hint}", good
    yield "system", f"{platform.system()} {platform.release()}, {platform.machine()}", True
    yield "threads", f"{usable_processors()} (--threads changes it)", True
    yield "gpu", _gpu(), True


def _gpu() -> str:
    from alight.core.errors import DeviceError
    from alight.gpu.driver import Gpu

    try:
        return f"{', '.join(Gpu().description.values())} (--device gpu renders on it)"
    except DeviceError as error:
        return f"none: {error}"


def _compiler() -> Iterator[Check]:
    try:
        import llvmlite.binding as llvm

        from lanewise.machine import cache_folder, lanes_of_machine
    except ImportError as error:
        yield "compiler", f"{error}; pip install numba", False
        return
    features = llvm.get_host_cpu_features()
    named = [name for name in _FEATURES if features.get(name)]
    yield "processor", f"{llvm.get_host_cpu_name()} ({', '.join(named) or 'no SIMD found'})", True
    yield "lanes", f"{lanes_of_machine()} paths in a packet", True
    yield _cache(cache_folder())


def _cache(folder: Path) -> Check:
    """Say where compiled kernels are kept and whether that works."""
    from alight.core.errors import OutputError
    from alight.outputs.atomic import check_folder

    existing = next(path for path in (folder, *folder.parents) if path.exists())
    try:
        check_folder(existing / "probe")
    except OutputError:
        text = f"{folder} cannot be written: every run compiles again; set ALIGHT_CACHE"
        return "kernel cache", text, False
    files = [path for path in folder.rglob("*") if path.is_file()]
    size = sum(path.stat().st_size for path in files) / 1e6
    state = f"{len(files)} files, {size:.1f} MB" if files else "empty, the first run compiles"
    return "kernel cache", f"{folder} ({state})", True


def _packages() -> Iterator[Check]:
    for name, extra in requirements():
        if not extra:
            version = _installed(name)
            yield name, version or f"missing; pip install {name}", version is not None


def _extras() -> Iterator[str]:
    required = requirements()
    for extra in sorted({extra for _, extra in required if extra}):
        missing = [name for name, of in required if of == extra and _installed(name) is None]
        if missing:
            mend = install_command(extra, *missing)
            yield f" -  extra {extra:<12}missing {', '.join(missing)}; {mend}"
        else:
            yield f"ok  extra {extra:<12}complete"
    if not required:
        yield " -  extras          unknown: alight runs from its source folder; pip install ."


def _installed(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
