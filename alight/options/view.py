"""The options of ``alight view``: those of the picture, and where its page is served."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike

from alight.options import scene
from alight.options.kinds import File, Names, Switch, Text
from alight.options.quantities import Whole
from alight.options.render import (
    MOST_SAMPLES,
    LimitOptions,
    PromiseOptions,
    RenderOptions,
    ThreadOptions,
    check_end,
    layer_names,
)
from alight.options.scene import SizedOptions
from alight.options.table import PICTURE, SAMPLING, option, table


@table
class ViewOptions(PromiseOptions, LimitOptions, ThreadOptions, SizedOptions):
    """The options of ``alight view``."""

    host: str = option(
        Text("HOST"),
        "Address to serve at; any but this machine's own, 127.0.0.1, needs --token.",
        default="127.0.0.1",
    )  # fmt: skip
    port: int = option(Whole(0, 65535), "Port to serve at; 0 is any free one.", default=0)
    token: str | None = option(
        Text(), "Secret part of the page's address.", default=None, shown="random"
    )
    browser: bool = option(
        Switch(), "Open the page in the browser of this machine.",
        default=True, flag="--browser/--no-browser",
    )  # fmt: skip
    against: str | PathLike[str] | None = option(
        File(), "Film or picture to compare with.", default=None, panel=PICTURE
    )
    aovs: Sequence[str] | str = option(
        Names("layer", layer_names), "Layers, comma-separated, such as albedo,normal.",
        default=(), flag="--aov", panel=PICTURE,
    )  # fmt: skip
    spp: int | None = option(
        Whole(1, MOST_SAMPLES), "Samples per pixel.",
        default=None, shown="as the scene file says or 64", panel=SAMPLING,
    )  # fmt: skip
    replicates: int | None = option(
        Whole(1, 1024), "Independent scrambles for the error bars.",
        default=None, shown="as the scene says, 4", panel=SAMPLING,
    )  # fmt: skip
    camera: str | int | None = scene.camera()
    integrator: str | None = scene.integrator()
    sampler: str | None = scene.sampler()
    filter: str | None = scene.filter()
    max_depth: int | None = scene.max_depth()
    rr_depth: int | None = scene.rr_depth()

    def __post_init__(self) -> None:
        """Refuse contradictions, too."""
        super().__post_init__()
        if self.criterion == "pilot":
            check_end(self.error, self.spp, self.max_spp)

    @property
    def of_render(self) -> RenderOptions:
        """The part that ``alight render`` has too, for a scene in which its changes are already."""
        shared = self.options().keys() & RenderOptions.options().keys()
        return RenderOptions(**{name: getattr(self, name) for name in shared}).with_loaded_scene()
