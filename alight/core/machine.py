"""What decides the bits of compiled code: the processor, the packet width, and all sources."""

from __future__ import annotations

import hashlib
import os
import platform
from functools import lru_cache
from pathlib import Path


def lanes_of_machine() -> int:
    """Packet width: 16 with AVX-512, else 8; the environment variable ALIGHT_LANES overrides."""
    asked = os.environ.get("ALIGHT_LANES")
    if asked is not None:
        if asked not in ("1", "4", "8", "16"):
            raise ValueError(f"ALIGHT_LANES must be 1, 4, 8 or 16, got {asked!r}")
        return int(asked)
    import llvmlite.binding as llvm

    features = llvm.get_host_cpu_features()
    return 16 if features.get("avx512f") and features.get("avx512vl") else 8


@lru_cache(maxsize=1)
def describe_machine() -> dict[str, str]:
    """Everything that decides the bits of a picture: sources, compiler, processor, lanes."""
    from importlib.metadata import version

    import llvmlite.binding as llvm

    return {
        "sources of alight": _digest_of_sources(),
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


@lru_cache(maxsize=1)
def fingerprint() -> str:
    """Short name for everything that `describe_machine` says."""
    return hashlib.sha256("|".join(describe_machine().values()).encode()).hexdigest()[:20]


def _digest_of_sources() -> str:
    h = hashlib.sha256()
    package = Path(__file__).resolve().parent.parent
    for path in sorted(package.rglob("*.py")):
        h.update(str(path.relative_to(package)).encode())
        h.update(path.read_bytes())
    return h.hexdigest()[:20]


def cache_folder() -> Path:
    """Where compiled kernels are kept: a folder that changes with any source of the package."""
    base = os.environ.get("ALIGHT_CACHE")
    if base is not None:
        return Path(base) / fingerprint()
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / "alight" / fingerprint()
