"""What is shown, in which way, and to whom: events come in, the state of the page goes out."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from typing import Any

from alight.core.errors import AlightError
from alight.films import Film
from alight.films.denoising import check_denoiser
from alight.metrics import ErrorEstimate
from alight.options.render import RenderOptions
from alight.outputs.display import Display
from alight.scene import Scene
from alight.tone_curves.model import TONE_CURVES
from alight.view import protocol
from alight.view.command import Origin, command_of
from alight.view.contrast import label_of_way, ways
from alight.view.editor import Editor
from alight.view.inspection import path_through, why_noisy
from alight.view.layers import PICTURE, FilmLayers, Layers, names_with
from alight.view.live import LiveScene
from alight.view.look import Look
from alight.view.pose import FOCUS
from alight.view.protocol import RefusedError

#: Words that change what is shown, not what there is.
OF_THE_LOOK = (protocol.Show, protocol.Develop, protocol.Denoise, protocol.Contrast)

#: Name of a picture that was kept to compare with.
KEPT = "kept"


class Session:
    """One thing that is viewed, by any number of browsers that all see the same.

    Parameters
    ----------
    title : str
        Name of the scene or file.
    shown : Scene or Layers
    options : RenderOptions, optional
        Of a scene.
    against : Layers, optional
        What is compared with.
    rival : str
        Its name.

    Attributes
    ----------
    look : Look
    live : LiveScene or None
        None of a film or a picture.
    editor : Editor or None
        Of a live scene.
    against : Layers or None
    origin : Origin or None
        Of a live scene that was read: file and options, of which commands are made.
    changed : callable
        Called, from any thread, when there is something new to see; the painter sets it.
    """

    def __init__(
        self,
        title: str,
        shown: Scene | Layers,
        options: RenderOptions | None = None,
        against: Layers | None = None,
        *,
        rival: str = KEPT,
    ) -> None:
        self.title, self.look = title, Look()
        self.against, self.rival = against, rival
        self.origin: Origin | None = None
        self.changed: Callable[[], None] = lambda: None
        self.live: LiveScene | None = None
        self._still: Layers | None = None
        self.editor: Editor | None = None
        self._inspects = threading.Lock()
        if isinstance(shown, Scene):
            self.live = LiveScene(shown, options or RenderOptions(), lambda: self.changed())
            self.editor = Editor(shown, self.live)
        else:
            self._still = shown

    def close(self) -> None:
        """End the render."""
        if self.live:
            self.live.close()

    # ------------------------------------------------------------------------ what there is

    @property
    def layers(self) -> Layers | None:
        """What is to be seen now; None before the first samples."""
        return self.live.layers if self.live else self._still

    @property
    def names(self) -> tuple[str, ...]:
        """The layers to choose from: of a scene those of its film, before it has samples too."""
        if self.live:
            return names_with(self.live.movable.compiled.program.aovs)
        assert self._still is not None
        return self._still.names

    @property
    def film(self) -> Film | None:
        """The film whose layers are shown, if it is one."""
        layers = self.live.layers if self.live else self._still
        return layers.film if isinstance(layers, FilmLayers) else None

    @property
    def number(self) -> int:
        """Of the view."""
        return self.live.wish.number if self.live else 0

    @property
    def rests(self) -> bool:
        """Whether nothing is added to the picture at the moment."""
        return self.live is None or self.live.phase in ("done", "stopped")

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is suspicious of the scene, and what went wrong in its film."""
        of_scene = self.live.movable.compiled.warnings if self.live else ()
        return tuple(dict.fromkeys([*of_scene, *(self.film.warnings if self.film else ())]))

    def state(
        self,
        error: ErrorEstimate | None,
        scale: tuple[float, float] | None,
        **shown: Any,
    ) -> dict[str, Any]:
        """Describe everything around the picture, as plain JSON.

        Parameters
        ----------
        error : ErrorEstimate or None
            Of the film.
        scale : (float, float) or None
            Ends of the scale of the layer that is shown.
        **shown
            What the painter adds: plain JSON.
        """
        layers, film, live = self.layers, self.film, self.live
        found: dict[str, Any] = {
            "is": "state",
            "title": self.title,
            "kind": "scene" if live else "film" if film else "picture",
            "size": list(live.movable.window[2:] if live else layers.size if layers else (1, 1)),
            "problem": live.problem if live else "",
            "layers": list(self.names),
            "layer": self.look.layer if self.look.layer in self.names else PICTURE,
            "scale": None if scale is None else [_number(end) for end in scale],
            "exposure": self.look.display.exposure,
            "tone_map": self.look.display.tone_map,
            "white_balance": self.look.display.white_balance,
            "denoise": self.look.denoised,
            "can_denoise": film is not None and find_spec("pyoidn") is not None,
            "way": self.look.way,
            "ways": {way: label_of_way(way) for way in ways()},
            "tone_maps": list(TONE_CURVES),
            "against": self.against is not None,
            "rival": self.rival,
            "warnings": list(self.warnings),
        }
        if film:
            found |= {"spp": film.spp, "replicates": film.replicates, "seed": film.seed}
            found["biases"] = [bias.line for bias in film.biases]
        if film and error:
            of_all = error.relrmse
            found["error"] = [_number(n) for n in (of_all.value, of_all.low, of_all.high)]
            found["promised"] = error.promised
        if live and self.editor:
            found |= _of_render(live) | self.editor.state()
        return found | self.progress() | shown

    def progress(self) -> dict[str, Any]:
        """Which view is asked for, and how far it is, as plain JSON."""
        return {"number": self.number, "phase": self.live.phase if self.live else "done"}

    # ------------------------------------------------------------------------ what is asked for

    def apply(self, event: protocol.Event) -> dict[str, Any] | None:
        """Do what the browser asks; an answer is for the one that asked.

        Raises
        ------
        RefusedError
            For what makes no sense here.
        """
        if isinstance(event, protocol.AskPixel):
            return self._pixel(event)
        if isinstance(event, OF_THE_LOOK):
            self._change_look(event)
        elif isinstance(event, protocol.Keep):
            self.against, self.rival = self._kept(), KEPT
        elif isinstance(event, protocol.Drop):
            self.against = None
        elif self.live is None or self.editor is None:
            raise RefusedError(f"{event.word}: only scenes are rendered")
        elif isinstance(event, protocol.OF_THE_SCENE):
            answer = self.editor.apply(event)
            self.changed()
            return answer
        elif isinstance(event, protocol.SLOW):
            return self._inspected(self.live, self.editor, event)
        else:
            self._steer(self.live, event)
        self.changed()
        return None

    def _steer(self, live: LiveScene, event: protocol.Event) -> None:
        match event:
            case protocol.Pivot(x, y):
                live.aim(x, y)
            case protocol.Rest():
                live.rest()
            case protocol.More():
                live.more()
            case protocol.Stop():
                live.stop()
            case _:
                live.move(lambda pose: pose.moved(event, live.movable.size))

    def _change_look(self, event: protocol.Event) -> None:
        if isinstance(event, protocol.Develop):
            try:
                display = Display(event.exposure, event.tone_map, white_balance=event.white_balance)
            except AlightError as error:
                raise RefusedError(str(error)) from None
            self.look = replace(self.look, display=display)
        elif isinstance(event, protocol.Denoise):
            if event.on and self.film is None and self.live is None:
                raise RefusedError("denoise: this is no film")
            if event.on:
                check_denoiser()
            self.look = replace(self.look, denoised=event.on)
        elif isinstance(event, protocol.Contrast):
            if event.way not in ways():
                raise RefusedError(f"way must be one of {', '.join(ways())}")
            self.look = replace(self.look, way=event.way)
        elif not isinstance(event, protocol.Show):
            raise RefusedError(f"{event.word}: this changes nothing that is shown")
        elif event.layer in self.names:
            self.look = replace(self.look, layer=event.layer)
        else:
            raise RefusedError("layer: there is none of this name")

    def _inspected(self, live: LiveScene, editor: Editor, event: protocol.Event) -> dict[str, Any]:
        """Answer what takes long; a failure is part of the answer."""
        answer: dict[str, Any] = {"is": event.word}
        try:
            # One at a time: each takes what processors there are.
            with self._inspects:
                match event:
                    case protocol.AskTrace(x, y, sample):
                        return answer | path_through(live, x, y, sample)
                    case protocol.AskWhy(x, y, width, height):
                        return answer | why_noisy(live, x, y, width, height)
                    case protocol.Focus(x, y):
                        answer |= editor.focus(x, y)
                        self.changed()
                        return answer
                    case protocol.AskCommand():
                        return answer | command_of(self.origin, editor, live, self.look)
        except AlightError as error:
            return answer | {"why": str(error)}
        raise RefusedError(f"{event.word}: there is no answer")

    def _kept(self) -> Layers:
        if self.film:
            return FilmLayers(self.film.snapshot())
        if self.layers is None:
            raise RefusedError("keep: there is no picture yet")
        return self.layers

    def _pixel(self, event: protocol.AskPixel) -> dict[str, Any]:
        layers = self.layers
        if layers is None or (self.live and self.film is None):
            raise RefusedError("pixel: there are no samples yet")
        width, height = layers.size
        if event.x >= width or event.y >= height:
            raise RefusedError(f"pixel: the picture has {width} x {height}")
        values = layers.values(event.x, event.y)
        return {
            "is": "pixel", "x": event.x, "y": event.y,
            "values": {name: [_number(n) for n in value] for name, value in values.items()},
        }  # fmt: skip


def _of_render(live: LiveScene) -> dict[str, Any]:
    """How far the render is, and how it ended."""
    job, options = live.job, live.movable.options
    found: dict[str, Any] = {"asked": options.error, "lens": _lens(live)}
    if job is None:
        return found
    verdict = job.verdict
    return found | {
        "target": job.schedule.total_spp,
        "seconds": job.seconds,
        "rate": job.samples / job.seconds / 1e6 if job.seconds > 0.0 else 0.0,
        "word": verdict.word if verdict else "",
        "line": verdict.line if verdict else "",
    }


def _lens(live: LiveScene) -> dict[str, float]:
    """The numbers of the camera that the page shows."""
    fields = dict(live.pose.camera)
    return {name: fields[name] for name in ("fov", "height", FOCUS) if name in fields}


def _number(value: float) -> float | None:
    """Plain JSON knows no NaN and no infinity."""
    return float(value) if math.isfinite(value) else None
