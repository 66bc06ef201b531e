"""A live view of scenes, films and pictures in the browser: ``alight view``.

::

    protocol     what the browser asks for, checked          -> an event
    session      what is shown, and to whom                  <- events
    live         the render loop: restarts with the camera   -> a film that grows
    painter      a layer of it, developed for a display      -> frames
    server       the page, its address and who may open it

Data flows one way: events change the session, the render loop follows the session, the painter
follows the film, and the browser draws what it is sent.

Called, as ``alight.view(scene)``, the package renders in the background of a notebook
(`alight.view.notebook.view`).
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from alight.view.notebook import LiveFilm


class _Called(ModuleType):
    """A package that is a function, too: both have the name that fits."""

    def __call__(self, scene: Any, *options: Any, **words: Any) -> LiveFilm:
        from alight.view.notebook import view

        return view(scene, *options, **words)


sys.modules[__name__].__class__ = _Called
