"""Media side by side: each lane is answered by the phase function of its own medium."""

import numpy as np

from alight.compiled.scene import compile_scene
from alight.core.vec import Vec3
from alight.formats import loads
from alight.laws.statistics import unit_vectors
from alight.media.sampling import evaluate_phase, sample_phase
from alight.scene import flatten
from lanewise.jit import instantiate

#: Ascending by what goes straight on.
PHASES = {
    "backwards": "{type: henyey_greenstein, g: -0.4}",
    "air": "rayleigh",
    "mist": "{type: henyey_greenstein, g: 0.3}",
    "fog": "{type: henyey_greenstein, g: 0.7}",
}
N = 2000


def scene_with(names):
    media = "".join(
        f"  {name}: {{type: homogeneous, sigma_t: 1, phase: {PHASES[name]}}}\n" for name in names
    )
    balls = "".join(
        f"  ball {i}: {{shape: {{type: sphere, center: [{3 * i}, 0, 0]}}, "
        f'bsdf: {{type: "null"}}, interior: {name}}}\n'
        for i, name in enumerate(names)
    )
    head = "alight: 1\ncamera: {type: pinhole}\nintegrator: volpath\nenvironment: constant\n"
    text = f"{head}media:\n{media}nodes:\n{balls}"
    return compile_scene(flatten(loads(text, "media.yaml")), structure="list")


def run(root, scene, *arguments):
    with np.errstate(all="ignore"):
        return instantiate(root, scene.program, compiled=False)(scene.tables, *arguments)


def test_lanes_in_different_media_have_the_phase_functions_of_their_own():
    d, wi = (Vec3(*unit_vectors(N, seed).astype(np.float32)) for seed in (1, 2))
    every, rng = np.ones(N, bool), np.random.default_rng(3)
    alone = [run(evaluate_phase, scene_with([n]), np.ones(N, np.uint32), d, wi, every)
             for n in PHASES]  # fmt: skip
    scene = scene_with(PHASES)
    number = rng.integers(1, len(PHASES) + 1, N).astype(np.uint32)
    # Which number has which phase function: by what goes straight on.
    first = np.arange(1, len(PHASES) + 1, dtype=np.uint32)
    north = Vec3(*(np.full(len(first), v, np.float32) for v in (0.0, 0.0, 1.0)))
    ahead = run(evaluate_phase, scene, first, north, north, np.ones(len(first), bool))
    name = np.argsort(np.argsort(ahead))
    found = run(evaluate_phase, scene, number, d, wi, every)
    np.testing.assert_allclose(found, np.choose(name[number - 1], alone), rtol=1e-6)
    u2 = tuple(rng.random((2, N), np.float32))
    w, density = run(sample_phase, scene, number, d, u2, every)
    again = run(evaluate_phase, scene, number, d, w, every)
    np.testing.assert_allclose(density, again, rtol=2e-3)
    # All four are drawn from: their mean cosines are in their order.
    cosine = d.x * w.x + d.y * w.y + d.z * w.z
    means = [cosine[name[number - 1] == k].mean() for k in range(len(PHASES))]
    np.testing.assert_allclose(means, [-0.4, 0.0, 0.3, 0.7], atol=4.0 / np.sqrt(N))
