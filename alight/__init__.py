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

from alight.core.version import VERSION as __version__
from lanewise.application import set_application

# Kernels heed ALIGHT_LANES, ALIGHT_CACHE and ALIGHT_PIPELINE.
set_application("alight", __path__[0])

#: Public name -> module that holds it. Imported at first use: `import alight` stays fast.
_PUBLIC = {
    "denoise": "alight.films.denoising",
    "merge": "alight.rendering",
    "render": "alight.rendering",
    "resume": "alight.rendering",
    "Progress": "alight.rendering",
    "Trace": "alight.rendering.trace",
    "trace": "alight.rendering.trace",
    "register": "alight.core.registration",
    "AlightError": "alight.core.errors",
    "FilmError": "alight.core.errors",
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
    from alight.core.errors import AlightError, FilmError, OptionError, OutputError, SceneError
    from alight.core.registration import register
    from alight.films import Film
    from alight.films.denoising import denoise
    from alight.formats import load, save
    from alight.laws import check_laws
    from alight.rendering import Progress, merge, render, resume
    from alight.rendering.trace import Trace, trace
    from alight.scene import Scene, SceneManager

__all__ = [
    "AlightError",
    "Film",
    "FilmError",
    "OptionError",
    "OutputError",
    "Progress",
    "Scene",
    "SceneError",
    "SceneManager",
    "Trace",
    "__version__",
    "check_laws",
    "denoise",
    "load",
    "merge",
    "register",
    "render",
    "resume",
    "save",
    "trace",
]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'alight' has no attribute {name!r}")
    value = getattr(import_module(_PUBLIC[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
