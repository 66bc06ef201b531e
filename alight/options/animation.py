"""The options of an animation: those of a render, and which pictures at which times."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from alight.core.errors import OptionError
from alight.options.kinds import Switch
from alight.options.quantities import Frames, Whole
from alight.options.render import RenderOptions
from alight.options.table import ANIMATION, option, table

#: Frames of a turntable, if nothing else is said.
ONE_TURN = 120


@table
class AnimationOptions(RenderOptions):
    """The options of `alight.animate`."""

    frames: tuple[int, int] | str | None = option(
        Frames(), "First frame, and the one after the last, such as 0:120.",
        default=None, shown=f"0:{ONE_TURN} for a turntable", panel=ANIMATION,
    )  # fmt: skip
    fps: int = option(
        Whole(1, 1000), "Frames per second: frame n shows the scene at n/FPS seconds.",
        default=24, panel=ANIMATION,
    )  # fmt: skip
    turntable: bool = option(
        Switch(), "Turn the camera once about the scene, over all frames.",
        default=False, panel=ANIMATION,
    )  # fmt: skip

    @property
    def has_frames(self) -> bool:
        """Whether an animation is asked for, not a single picture."""
        return self.frames is not None or self.turntable

    @property
    def numbers(self) -> range:
        """Of the frames.

        Raises
        ------
        OptionError
            If nothing says which, or an option is for a single picture.
        """
        for name in self.given("checkpoint", "part", "stats", "first_sample"):
            raise OptionError("is for a single picture", name)
        if self.frames is not None:
            return range(*self.frames)  # type: ignore[misc]
        if not self.turntable:
            text = "give {frames}, as 0:120, or {turntable}"
            raise OptionError(text, names=("frames", "turntable"))
        return range(ONE_TURN)

    @property
    def of_still(self) -> RenderOptions:
        """The options of a single picture.

        Raises
        ------
        OptionError
            If an option is for an animation.
        """
        from alight.outputs.moving import is_moving

        if self.given("fps"):
            text = "is for an animation: give {frames}, as 0:120, or {turntable}"
            raise OptionError(text, "fps", ("frames", "turntable"))
        paths: Any = self.output
        for path in paths:
            if is_moving(Path(path)):
                text = f"{path} holds an animation: give {{frames}}, as 0:120, or {{turntable}}"
                raise OptionError(text, "output", ("frames", "turntable"))
        return self.of_frame(self.output)

    def of_frame(self, output: Any) -> RenderOptions:
        """The options of the render of one frame."""
        own = set(AnimationOptions.options()) - set(RenderOptions.options())
        words = {n: getattr(self, n) for n in RenderOptions.options() if n not in own}
        return RenderOptions(**{**words, "output": output})
