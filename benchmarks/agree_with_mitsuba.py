"""Does alight make Mitsuba 3's picture of a Mitsuba file? A test over seeds and blocks of pixels.

    python benchmarks/agree_with_mitsuba.py [--pixels 4096] [--seeds 32] [--spp 64] FILE.xml ...

The files are opened as they are by both renderers. On both sides the same is then overridden, as by
``alight render FILE.xml --sampler independent --filter box --size WxH``: independent samples, the
box filter, and a small picture of the file's aspect. `alight.metrics.comparison` says what is
tested: rms(z) over blocks of 2x2 pixels, the largest abs(z) and the means of the channels.

A test that cannot fail proves nothing, so our side is rendered once more with 1 % of the light
taken away at every surface (``--darker``); that must be found. Exit code 1 if a scene disagrees or
the darker one goes unseen. Needs ``make peers`` and, for the variant llvm_ad_rgb, a libLLVM.
"""

import argparse
import dataclasses
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from harness import print_json, print_table

import alight
from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.matte.diffuse import Diffuse
from alight.metrics.comparison import Comparison, PictureStatistics, compare_pictures
from alight.scene import Node, Scene

BLACK = Diffuse(reflectance=0.0)
# Blocks with less relative noise than this hold one value (sky, a lamp, black) and its rounding.
STILL, ROUNDING = 1e-5, 1e-3
# So are blocks with less than this part of the mean of the picture: the far tail of a highlight
# (exp(-40) of it, say), where one renderer has 1e-19 and the other 0.
DARK = 1e-9


def small_size(size: tuple[int, int], pixels: int) -> tuple[int, int]:
    """Width and height of about `pixels` in all with the aspect of `size`, both even.

    Examples
    --------
    >>> small_size((1280, 720), 4096)
    (86, 48)
    """
    scale = math.sqrt(pixels / (size[0] * size[1]))
    width, height = (max(2, 2 * round(scale * length / 2)) for length in size)
    return width, height


def ours(path: Path, arguments: argparse.Namespace) -> Scene:
    """Load a file with the overrides of the command line."""
    names = dict(text.split("=", 1) for text in arguments.define)
    width, height = small_size(alight.load(path, definitions=names).film.size, arguments.pixels)
    changes = [f"film.size=[{width}, {height}]", "film.crop=null", "film.filter=box"]
    return alight.load(path, [*changes, "sampler.type=independent"], definitions=names)


def darker(scene: Scene, part: float) -> Scene:
    """Take a part of the light away at every surface, whatever it is made of."""

    def changed(node: Node) -> Node:
        children = {name: changed(child) for name, child in node.children.items()}
        bsdf = node.bsdf
        if node.shape is not None:
            bsdf = Blend(weight=part, bsdfs=(bsdf or Diffuse(), BLACK))
        return node.replaced(children=children, bsdf=bsdf)

    graphs = {"nodes": scene.nodes, "prototypes": scene.prototypes}
    darkened = {
        key: {name: changed(node) for name, node in graph.items()} for key, graph in graphs.items()
    }
    return scene.replaced(**darkened).from_source(scene.source)


def our_picture(scene: Scene, spp: int) -> Callable[[int], np.ndarray]:
    """Render one seed; samples that are no number are an error here."""

    def picture(seed: int) -> np.ndarray:
        film = alight.render(scene, spp=spp, spp_per_pass=spp, seed=seed)
        assert film.invalid == 0, f"{film.invalid} samples of seed {seed} are not finite"
        return film.image

    return picture


def their_picture(
    path: Path, size: tuple[int, int], arguments: argparse.Namespace
) -> Callable[[int], np.ndarray]:
    """Open the file with Mitsuba's own reader, override size, filter and sampler, render a seed."""
    import mitsuba

    resolver = mitsuba.file_resolver()
    resolver.prepend(str(path.parent.resolve()))
    config = mitsuba.parser.ParserConfig(arguments.variant)
    # Loading in parallel sometimes hangs (3.9.1).
    config.parallel = False
    names = dict(text.split("=", 1) for text in arguments.define)
    state = mitsuba.parser.parse_file(config, str(path), **names)
    mitsuba.parser.transform_all(config, state)
    for node in state.nodes:
        if node.type == mitsuba.ObjectType.Film:
            assert_filter(mitsuba, state, node)
            node.props["width"], node.props["height"] = size
            for name in ("crop_offset_x", "crop_offset_y", "crop_width", "crop_height"):
                if name in node.props:
                    del node.props[name]
        elif node.type == mitsuba.ObjectType.ReconstructionFilter:
            replace(mitsuba, node, "box")
        elif node.type == mitsuba.ObjectType.Sampler:
            replace(mitsuba, node, "independent")
    scene = mitsuba.parser.instantiate(config, state)
    film = scene.sensors()[0].film()
    assert tuple(film.size()) == size
    assert "BoxFilter" in str(film.rfilter())

    def picture(seed: int) -> np.ndarray:
        return np.array(mitsuba.render(scene, spp=arguments.spp, seed=seed), np.float64)[..., :3]

    return picture


def replace(mitsuba: Any, node: Any, plugin: str) -> None:
    """Replace a plug-in by another with default parameters."""
    node.props = mitsuba.Properties(plugin)


def assert_filter(mitsuba: Any, state: Any, film: Any) -> None:
    """A film without a filter would take Mitsuba's default, which is no box."""
    kinds = [node.type for node in state.nodes]
    assert mitsuba.ObjectType.ReconstructionFilter in kinds, film.props


def compare(a: PictureStatistics, b: PictureStatistics) -> tuple[Comparison, float]:
    """Compare two sides; also the largest difference of blocks without noise, relative."""
    still = np.ones(a.block_mean.shape, bool)
    floor = DARK * max(a.block_mean.mean(), b.block_mean.mean())
    for side in (a, b):
        noise = np.sqrt(side.block_variance)
        still &= (noise <= STILL * np.abs(side.block_mean)) | (noise + side.block_mean <= floor)
    brightest = np.maximum(np.abs(a.block_mean), np.abs(b.block_mean))
    differences = np.abs(a.block_mean - b.block_mean) / np.maximum(brightest, floor / ROUNDING)

    def noisy(side: PictureStatistics) -> PictureStatistics:
        return dataclasses.replace(
            side,
            block_mean=np.where(still, 0.0, side.block_mean),
            block_variance=np.where(still, 0.0, side.block_variance),
        )

    return compare_pictures(noisy(a), noisy(b), join=False), float(
        differences[still].max(initial=0.0)
    )


def measure(path: Path, arguments: argparse.Namespace) -> dict[str, Any]:
    """Compare both renderers on one file."""
    start = time.perf_counter()

    def statistics(picture: Callable[[int], np.ndarray], first: int = 0) -> PictureStatistics:
        seeds = range(first, first + arguments.seeds)
        return PictureStatistics.of(np.stack([picture(seed) for seed in seeds]))

    scene = ours(path, arguments)
    mine = statistics(our_picture(scene, arguments.spp))
    theirs = statistics(their_picture(path, scene.film.size, arguments))
    result, still = compare(mine, theirs)
    row: dict[str, Any] = {
        "scene": f"{path.parent.name}/{path.stem}",
        "size": "x".join(map(str, scene.film.size)),
        "spp": arguments.spp * arguments.seeds,
        "blocks": int(np.isfinite(result.z).sum()),
        "rms z": result.rms,
        "p(rms)": result.p_values["rms(z)"],
        "largest z": result.largest,
        "p(largest)": result.p_values["largest |z|"],
        "p(mean)": min(result.p_values[f"mean {name}"] for name in "RGB"),
        "ours / Mitsuba": " ".join(f"{r:.4f}" for r in mine.channel_mean / theirs.channel_mean),
        "still blocks": still,
        "agrees": result.passed and still <= ROUNDING,
    }
    if arguments.darker:
        # Other seeds than above: a test that is right by luck would be so twice.
        dark = statistics(our_picture(darker(scene, arguments.darker), arguments.spp), 10_000)
        row["darker found"] = not compare(dark, theirs)[0].passed
        row["darker / Mitsuba"] = float(dark.channel_mean.sum() / theirs.channel_mean.sum())
    if arguments.dump:
        result.dump(arguments.dump / f"{path.parent.name}-{path.stem}")
    row["seconds"] = round(time.perf_counter() - start)
    for reason in result.reasons:
        print(f"{row['scene']}: {reason}", file=sys.stderr)
    return row


def main() -> None:
    """Compare every file."""
    parser = argparse.ArgumentParser(description="alight's pictures of Mitsuba's files.")
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE.xml")
    parser.add_argument("--pixels", type=int, default=64 * 64, help="about so many in all")
    parser.add_argument("--seeds", type=int, default=32)
    parser.add_argument("--spp", type=int, default=64, help="of each seed")
    parser.add_argument("-D", "--define", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--darker", type=float, default=0.01, help="0 to leave this check out")
    parser.add_argument("--dump", type=Path, help="folder for both mean pictures and z")
    parser.add_argument("--threads", type=int, default=2, help="of Mitsuba")
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba")
    arguments = parser.parse_args()

    import drjit
    import mitsuba

    mitsuba.set_variant(arguments.variant)
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    drjit.set_thread_count(arguments.threads)
    rows = []
    for path in arguments.files:
        rows.append(measure(path, arguments))
        print_json(benchmark="agreement", **rows[-1])
    print_table(rows)
    sys.exit(0 if all(row["agrees"] and row.get("darker found", True) for row in rows) else 1)


if __name__ == "__main__":
    main()
