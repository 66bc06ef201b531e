"""Make the stored references with Mitsuba 3: ``python make_references.py [SCENE ...]``.

Each scene of `mitsuba_scenes` is rendered with many independent seeds (independent sampler, box
filter) and written to ``references/NAME.npz`` with these entries, named as in
`alight.metrics.comparison.PictureStatistics`:

    count             number of seeds
    block             2, pixels along the side of a block
    block_mean        (height/2, width/2) float32, mean luminance of each block over all seeds
    block_variance    the same shape, unbiased variance over seeds of one seed's block luminance
    channel_mean      (3,) float64, mean over the picture
    channel_variance  (3,) float64, unbiased variance over seeds of one seed's channel mean
    mean              (height, width, 3) float16, mean picture, only to be looked at
    spp               samples per pixel of each seed
    mitsuba           version

Needs ``pip install mitsuba trimesh`` and, for its llvm variant, a libLLVM that it accepts; the
scalar variant works without (``--variant scalar_rgb``), several times slower.
"""

import argparse
import time
from pathlib import Path
from typing import Any

import mitsuba_facets  # noqa: F401  (this and those below: their scenes enter themselves
import mitsuba_layers  # noqa: F401  (into `mitsuba_parts.SCENES`)
import mitsuba_lights  # noqa: F401
import mitsuba_media  # noqa: F401
import mitsuba_models
import mitsuba_parts
import mitsuba_scenes  # noqa: F401
import mitsuba_textures  # noqa: F401
import numpy as np

from alight.metrics.comparison import STORED_LUMINANCE

REFERENCES = Path(__file__).parent / "references"
BLOCK = 2


def block_luminance(image: np.ndarray) -> np.ndarray:
    """Mean luminance of 2x2 blocks; (height, width, 3) -> (height/2, width/2)."""
    luminance = np.asarray(image, np.float64) @ STORED_LUMINANCE
    height, width = luminance.shape
    return luminance.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK).mean((1, 3))


def measure(mi: Any, name: str, seeds: int, spp: int) -> dict[str, Any]:
    """Render one scene `seeds` times and reduce it to what the test needs."""
    scene = mi.load_dict(mitsuba_parts.SCENES[name](mi))
    images = []
    for seed in range(seeds):
        image = np.array(mi.render(scene, spp=spp, seed=seed), np.float64)[..., :3]
        if not np.isfinite(image).all():
            raise ValueError(f"{name}: seed {seed} has values that are not finite")
        images.append(image)
    stack = np.stack(images)
    blocks = np.stack([block_luminance(image) for image in images])
    channels = stack.mean((1, 2))
    return {
        "count": seeds,
        "block": BLOCK,
        "block_mean": blocks.mean(0).astype(np.float32),
        "block_variance": blocks.var(0, ddof=1).astype(np.float32),
        "channel_mean": channels.mean(0),
        "channel_variance": channels.var(0, ddof=1),
        "mean": stack.mean(0).astype(np.float16),
        "spp": spp,
        "mitsuba": mi.__version__,
    }


def write_meshes() -> None:
    """Write the two small meshes that the scenes of both renderers read."""
    import trimesh

    mitsuba_parts.MESHES.mkdir(exist_ok=True)
    icosahedron = trimesh.creation.icosahedron()
    icosahedron.export(mitsuba_parts.MESHES / "icosahedron.ply", vertex_normal=False)
    torus = trimesh.creation.torus(0.7, 0.3, major_sections=48, minor_sections=24)
    torus.export(mitsuba_parts.MESHES / "torus.ply", vertex_normal=True)


def main() -> None:
    """Make the references named on the command line, or all."""
    parser = argparse.ArgumentParser(description="Make reference pictures with Mitsuba 3.")
    parser.add_argument("scenes", nargs="*", help="default: all")
    parser.add_argument("--seeds", type=int, default=64)
    parser.add_argument("--spp", type=int, default=128, help="per seed")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--output", type=Path, default=REFERENCES)
    arguments = parser.parse_args()

    import drjit
    import mitsuba

    mitsuba.set_variant(arguments.variant)
    drjit.set_thread_count(arguments.threads)
    mitsuba_models.register(mitsuba)
    write_meshes()
    arguments.output.mkdir(exist_ok=True)
    for name in arguments.scenes or mitsuba_parts.SCENES:
        start = time.perf_counter()
        result = measure(mitsuba, name, arguments.seeds, arguments.spp)
        np.savez_compressed(arguments.output / f"{name}.npz", **result)
        error = np.sqrt(result["block_variance"] / arguments.seeds).mean()
        print(
            f"{name}: {time.perf_counter() - start:.1f} s, "
            f"channels {np.round(result['channel_mean'], 5)}, "
            f"standard error of a block {error / result['block_mean'].mean():.2%} of the mean",
            flush=True,
        )


if __name__ == "__main__":
    main()
