"""alight: a physically based Monte Carlo path tracer that knows its own error.

Examples
--------
>>> import alight
>>> film = alight.render("cornell-box", spp=16)  # doctest: +SKIP
>>> film.save("cornell.png")  # doctest: +SKIP

Every mistake that a user can fix is an `AlightError`, with its place and remedy:

>>> try:
...     alight.load("cornell-bx")
... except alight.AlightError as error:
...     print(str(error).splitlines()[1].split("  ")[1])
no such scene file; did you mean "cornell-box"?
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from alight.core.errors import KernelError
from alight.core.version import VERSION as __version__
from lanewise.application import set_application

# Kernels heed ALIGHT_LANES, ALIGHT_CACHE and ALIGHT_PIPELINE.
set_application(
    "alight", __path__[0], error=KernelError, mathematics=("alight.core.maths",)
)  # fmt: skip

#: Public name -> module that holds it. Imported at first use: `import alight` stays fast.
_PUBLIC = {
    "animate": "alight.rendering.animation",
    "changed": "alight.formats.loading",
    "check": "alight.laws.scene",
    "compare": "alight.lab.compare",
    "denoise": "alight.films.denoising",
    "guide": "alight.lab.guide",
    "info": "alight.lab.info",
    "merge": "alight.rendering",
    "plan": "alight.rendering.plan",
    "render": "alight.rendering",
    "resume": "alight.rendering",
    "study": "alight.lab.report.outcome",
    "why": "alight.lab.why",
    "RenderOptions": "alight.options.render",
    "Progress": "alight.rendering",
    "Trace": "alight.rendering.tracing.traced_path",
    "trace": "alight.rendering.tracing.trace",
    "view": "alight.view",
    "register": "alight.core.registration",
    "AlightError": "alight.core.errors",
    "DeviceError": "alight.core.errors",
    "FilmError": "alight.core.errors",
    "KernelError": "alight.core.errors",
    "OptionError": "alight.core.errors",
    "OutputError": "alight.core.errors",
    "SceneError": "alight.core.errors",
    "check_laws": "alight.laws",
    "Film": "alight.films",
    "load": "alight.formats",
    "save": "alight.formats",
    "Scene": "alight.scene",
    "SceneManager": "alight.scene",
}

if TYPE_CHECKING:
    from alight.core.errors import (
        AlightError,
        DeviceError,
        FilmError,
        OptionError,
        OutputError,
        SceneError,
    )
    from alight.core.registration import register
    from alight.films import Film
    from alight.films.denoising import denoise
    from alight.formats import load, save
    from alight.formats.loading import changed
    from alight.lab.compare import compare
    from alight.lab.guide import guide
    from alight.lab.info import info
    from alight.lab.report.outcome import study
    from alight.lab.why import why
    from alight.laws import check_laws
    from alight.laws.scene import check
    from alight.options.render import RenderOptions
    from alight.rendering import Progress, merge, render, resume
    from alight.rendering.animation import animate
    from alight.rendering.plan import plan
    from alight.rendering.tracing.trace import trace
    from alight.rendering.tracing.traced_path import Trace
    from alight.scene import Scene, SceneManager

    view: Any

__all__ = [
    "AlightError",
    "DeviceError",
    "Film",
    "FilmError",
    "KernelError",
    "OptionError",
    "OutputError",
    "Progress",
    "RenderOptions",
    "Scene",
    "SceneError",
    "SceneManager",
    "Trace",
    "__version__",
    "animate",
    "changed",
    "check",
    "check_laws",
    "compare",
    "denoise",
    "guide",
    "info",
    "load",
    "merge",
    "plan",
    "register",
    "render",
    "resume",
    "save",
    "study",
    "trace",
    "view",
    "why",
]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'alight' has no attribute {name!r}")
    module = import_module(_PUBLIC[name])
    # `alight.view` is a package that is called.
    value = module if module.__name__ == f"alight.{name}" else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
