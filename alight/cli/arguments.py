"""The arguments of ``alight render``: names and help texts."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

_IMAGE = "Picture"
_SAMPLING = "Sampling"
_SCENE = "Instead of what the scene file says"

SceneName = Annotated[str, typer.Argument(help="Scene file, or a name that `alight scenes` lists.")]
Output = Annotated[
    list[Path] | None,
    typer.Option(
        "-o",
        "--output",
        help="File to write; the suffix chooses the format. Repeatable.",
        show_default="SCENE.png",
        rich_help_panel=_IMAGE,
    ),
]
Layers = Annotated[
    str | None,
    typer.Option(
        metavar="NAMES",
        help="Extra layers (EXR), comma-separated, such as albedo,normal or direct,indirect.",
        rich_help_panel=_IMAGE,
    ),
]
Exposure = Annotated[
    str,
    typer.Option(
        metavar="STOPS", help="Stops, or auto, for display formats.", rich_help_panel=_IMAGE
    ),
]
WhiteBalance = Annotated[
    str,
    typer.Option(
        metavar="LIGHT",
        help="Light to show as white: none, auto, a temperature such as 3200K, or a colour R,G,B.",
        rich_help_panel=_IMAGE,
    ),
]
ToneMap = Annotated[
    str, typer.Option(help="none, reinhard, aces, hable or agx.", rich_help_panel=_IMAGE)
]
Bits = Annotated[int, typer.Option(help="8, or 16 (PNG).", rich_help_panel=_IMAGE)]
Denoise = Annotated[
    bool,
    typer.Option(
        "--denoise",
        help="Denoise the picture; EXR keeps the noisy one too. Needs the extra denoise.",
        rich_help_panel=_IMAGE,
    ),
]
Stats = Annotated[
    Path | None, typer.Option(help="JSON file for times and errors.", rich_help_panel=_IMAGE)
]

Spp = Annotated[
    int | None,
    typer.Option(
        help="Samples per pixel.",
        min=1,
        show_default="64 without --time",
        rich_help_panel=_SAMPLING,
    ),
]
TimeLimit = Annotated[
    float | None,
    typer.Option(
        "--time", help="Start no pass after this many seconds.", rich_help_panel=_SAMPLING
    ),
]
Seed = Annotated[int, typer.Option(help="Seed of the random numbers.", rich_help_panel=_SAMPLING)]
FirstSample = Annotated[
    int,
    typer.Option(help="Index of the first sample, to extend a film.", rich_help_panel=_SAMPLING),
]
Replicates = Annotated[
    int | None,
    typer.Option(help="Independent scrambles for the error bars.", rich_help_panel=_SAMPLING),
]
Threads = Annotated[
    int | None, typer.Option(help="Threads; by default all processors.", rich_help_panel=_SAMPLING)
]
SppPerPass = Annotated[
    int | None,
    typer.Option(help="Samples per pixel between progress reports.", rich_help_panel=_SAMPLING),
]

Checkpoint = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Save the state there: alight resume FILE continues after a stop or a crash.",
        rich_help_panel=_SAMPLING,
    ),
]
Every = Annotated[
    str,
    typer.Option(
        metavar="TIME",
        help="Time between checkpoints, such as 60s, 5m or 1h.",
        rich_help_panel=_SAMPLING,
    ),
]

Size = Annotated[str | None, typer.Option(metavar="WxH", help="Pixels.", rich_help_panel=_SCENE)]
Crop = Annotated[
    str | None,
    typer.Option(metavar="X,Y,W,H", help="Part to render, in pixels.", rich_help_panel=_SCENE),
]
CameraName = Annotated[
    str | None,
    typer.Option(
        "--camera",
        metavar="NAME|NUMBER",
        help="Camera node of the scene: its path, its name, or its number, from 0.",
        rich_help_panel=_SCENE,
    ),
]
IntegratorName = Annotated[
    str | None, typer.Option(help="Algorithm, such as path or direct.", rich_help_panel=_SCENE)
]
SamplerName = Annotated[
    str | None,
    typer.Option(help="Source of random numbers, such as sobol.", rich_help_panel=_SCENE),
]
FilterName = Annotated[
    str | None, typer.Option("--filter", help="Pixel filter, such as box.", rich_help_panel=_SCENE)
]
MaxDepth = Annotated[
    int | None, typer.Option(help="Longest path, in edges.", rich_help_panel=_SCENE)
]
RrDepth = Annotated[
    int | None, typer.Option(help="Depth at which Russian roulette starts.", rich_help_panel=_SCENE)
]
Assignments = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="PATH=VALUE",
        help="Set any key of the scene file. Repeatable.",
        rich_help_panel=_SCENE,
    ),
]

Plugins = Annotated[
    list[Path] | None,
    typer.Option(
        "--plugin",
        metavar="FILE.py",
        help="Script that registers models for the scene (alight.register). Repeatable.",
        rich_help_panel=_SCENE,
    ),
]

Root = Annotated[
    Path | None,
    typer.Option(
        "--root",
        metavar="FOLDER",
        help="Folder whose files the scene may read; must contain it.",
        show_default="the scene's own folder",
        rich_help_panel=_SCENE,
    ),
]

_FOREIGN = "Scene files of other programs"

Definitions = Annotated[
    list[str] | None,
    typer.Option(
        "-D",
        metavar="NAME=VALUE",
        help="Set $NAME in an .xml file. Repeatable.",
        rich_help_panel=_FOREIGN,
    ),
]
Lenient = Annotated[
    bool,
    typer.Option(
        "--lenient",
        help="Replace unsupported parts (.xml, .pbrt), and list them.",
        rich_help_panel=_FOREIGN,
    ),
]

Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Only warnings and errors.")]
