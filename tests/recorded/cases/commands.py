"""Transcripts of commands that render nothing, and the words of all commands."""

from __future__ import annotations

from typing import Any

from typer.main import get_command

from alight.cli.main import app
from alight.cli.words import parse_pixel
from tests.recorded.making import command, in_folder, masked, outcome, rows

SCENE = """alight: 1
camera: {type: pinhole, fov: 40, transform: {look_at: {origin: [0, 1, 4], target: [0, 0, 0]}}}
film: {size: [8, 6]}
bsdfs: {grey: {type: diffuse, reflectance: 0.5}, unused: {type: mirror}}
nodes:
  ball: {shape: sphere, bsdf: grey}
  lamp: {light: {type: point, intensity: [3, 2, 1]}, transform: [{translate: [1, 3, 2]}]}
"""

LINES = (
    "",
    "--version",
    "rendr",
    "animate",
    "scene",
    "cluster",
    "info",
    "info cornell-bx",
    "info s.yaml",
    "info s.yaml --tree",
    "info s.yaml --set nodes.ball.shape.radius=2",
    "info s.yaml --set nodes.bal.shape.radius=2",
    "info s.yaml --set x",
    "info s.yaml --set film.size=[4,4] --size 9x7",
    "info none.yaml",
    "info .",
    "info bad.yaml",
    "info s.yaml --lenient",
    "info s.yaml --camera top",
    "info s.yaml -D a=b",
    "info s.yaml --root none",
    "info a.obj --variant x",
    "info s.yaml --plugin none.py",
    "info s.yaml --plugin broken.py",
    "info s.yaml --plugin empty.py",
    "scenes",
    "models",
    "models diffuse",
    "models bsdfs",
    "models difuse",
    "models sphere",
    "models path",
    "models area",
    "models homogeneous",
    "check --mutant",
    "check s.yaml --mutant nothing",
    "check none.yaml",
    "why none.yaml",
    "why s.yaml --size 3",
    "why s.yaml -o a.txt",
    "why s.yaml --spp 5",
    "plan s.yaml --error 0",
    "plan s.yaml --error x",
    "trace s.yaml",
    "trace s.yaml --pixel 3",
    "trace s.yaml --pixel 9,9",
    "trace s.yaml --pixel -1,2",
    "trace s.yaml --pixel 1,2 --sample -1",
    "guide s.yaml --pixel 30,2",
    "reference s.yaml -o a.png",
    "reference s.yaml",
    "reference s.yaml -o a.exr --error 2",
    "compare a.exr",
    "compare a.exr b.exr",
    "merge",
    "merge a.alight",
    "merge a.alight -o b.exr",
    "resume",
    "resume a.checkpoint",
    "resume s.yaml",
    "tonemap a.exr",
    "tonemap .",
    "convert s.yaml",
    "convert s.yaml out.yaml",
    "convert s.yaml out.obj",
    "convert s.yaml out.json",
    "render none.yaml",
    "render s.yaml --spp 0",
    "render s.yaml --spp x",
    "render s.yaml --spp",
    "render s.yaml --sppp 3",
    "render s.yaml --aov albedoo",
    "render s.yaml --error 5% --spp 3",
    "render s.yaml --cluster nowhere",
    "render s.yaml --cluster tls://a:1",
    "render s.yaml --seed -1",
    "render s.yaml --size 0x3",
    "render s.yaml --crop 0,0,99,99",
    "render s.yaml --exposure x",
    "render s.yaml --tone-map x",
    "render s.yaml --integrator x",
    "render s.yaml --sampler sobo",
    "render s.yaml --filter bx",
    "render s.yaml --threads 0",
    "render s.yaml --time 0",
    "render s.yaml --part 3/2",
    "render s.yaml --checkpoint none/a",
    "render s.yaml --background x",
    "render s.yaml --denoise --bits 12",
    "scene random",
    "scene random x.yaml --kind nothing",
    "cluster keys",
    "cluster status",
    "cluster status nowhere",
    "cluster status tcp://8.8.8.8:80",
    "view none.yaml",
    "view s.yaml --port 99999",
    "warm none.yaml",
    "doctor --nothing",
    "study none.yaml",
    "study -o",
)


def lines() -> dict[str, Any]:
    """What commands say, above all of what is wrong."""
    files = {
        "s.yaml": SCENE,
        "bad.yaml": SCENE.replace("sphere", "spere").replace("fov", "fow"),
        "a.obj": "v 0 0 0\n",
        "broken.py": "1 / 0\n",
        "empty.py": "",
        "a.exr": b"hello",
    }
    with in_folder(files):
        found = {}
        for line in LINES:
            answer = command(*line.split())
            # The frame around usage errors is the library's.
            usage = (
                "Usage:" in answer["warns"]
                or "╭" in answer["warns"]
                or not line
                or line in ("scene", "cluster")
            )
            found[line] = [answer["exit"], _told(answer["warns"]) if usage else {**answer}]
        return found


def _told(text: str) -> str:
    """The error within a frame, on one line."""
    kept = [line.strip("│╭╮╰╯─| ").strip() for line in text.splitlines()]
    words = " ".join(
        line for line in kept if line and not line.startswith(("Usage", "Try", "Error"))
    )
    return " ".join(masked(words).split())


def words() -> dict[str, Any]:
    """Every word of every command: names, defaults, panels. Help is that of the options."""
    found: dict[str, Any] = {}
    for name, one in _commands():
        found[name] = [
            " · ".join(
                [
                    "/".join([*p.opts, *p.secondary_opts]),
                    p.param_type_name,
                    str(p.required),
                    str(p.multiple if hasattr(p, "multiple") else ""),
                    str(p.default),
                    str(getattr(p, "metavar", "")),
                    str(getattr(p, "rich_help_panel", "")),
                ]
            )
            for p in one.params
        ] + [str(one.help)]
    return found


def _commands() -> list[tuple[str, Any]]:
    found: list[tuple[str, Any]] = []
    for name, one in get_command(app).commands.items():  # type: ignore[attr-defined]
        inside = getattr(one, "commands", None)
        found += [(f"{name} {n}", c) for n, c in inside.items()] if inside else [(name, one)]
    return found


def parts() -> dict[str, Any]:
    """Pixels, and widths of lists."""
    return {
        "pixels": rows(
            parse_pixel, ["1,2", " 3 , 4", "-1,-2", "1;2", "a,b", "1,2,3", "1234567890,1"]
        ),
        "narrow": [command(*line, columns=60) for line in (("scenes",), ("models", "principled"))],
        "wide": [command(*line, columns=200) for line in (("models", "diffuse"),)],
        "help": outcome(lambda: command("--help")["exit"]),
    }


CASES = {"lines": lines, "words": words, "parts": parts}
