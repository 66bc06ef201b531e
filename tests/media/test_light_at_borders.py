"""Light at the borders of media: dimmed by what is on the side that it comes from."""

import numpy as np
import pytest

from alight.integrators.volpath import VolPath
from tests.rendering.many_paths import compiled, samples_of

#: Extinctions of the media, which only absorb; to a camera in a grey one a path comes or does not.
MEDIA = {
    "none": (0, 0, 0),
    "haze": (0.2, 0.2, 0.2),
    "ink": (1.1, 0.5, 0.1),
    "wine": (0.1, 0.9, 1.3),
}
REFLECTED, PASSED = (0.6, 0.3, 0.2), (0.3, 0.4, 0.5)
#: The lamp, before or behind the sheet, and the bubble around it.
PLACE, BUBBLE = np.array([0.3, 0.4, 1.2]), 0.4
INTENSITY = 5.0
#: (medium of the camera, interior and exterior of the sheet, interior of the bubble or None)
CASES = {
    "no border": ("haze", None, None, None),
    "a body in the air": ("none", "ink", None, None),
    "a body in haze": ("haze", "ink", None, None),
    "a hollow in haze": ("haze", "none", None, None),
    "an interface": ("haze", "ink", "wine", None),
    "only an exterior": ("none", None, "wine", None),
    "a lamp in a bubble": ("haze", "ink", "wine", "wine"),
    "a bubble in haze": ("haze", None, None, "ink"),
}
HEAD = f"""
alight: 1
camera: {{type: orthographic, height: 0.01, transform: {{translate: [0, 0, 1]}}}}
film: {{size: [16, 16]}}
sampler: independent
bsdfs:
  nothing: {{type: "null"}}
  sheet: {{type: diffuse_transmission, reflectance: {list(REFLECTED)},
          transmittance: {list(PASSED)}}}
media:
"""
HEAD += "".join(
    f"  {name}: {{type: homogeneous, sigma_t: {list(sigma)}, albedo: 0}}\n"
    for name, sigma in MEDIA.items()
)


def scene_text(case, side, lamp):
    """The sheet in the plane z = 0, its outer side to the camera; the lamp on side +1 or -1."""
    camera, inner, outer, bubble = CASES[case]
    x, y, z = PLACE * [1, 1, side]
    border = "".join(
        f", {word}: {name}" for word, name in (("interior", inner), ("exterior", outer)) if name
    )
    text = f"medium: {camera}\n" if camera != "none" else ""
    text += (
        f"nodes:\n  sheet: {{shape: rectangle, bsdf: sheet, transform: {{scale: 50}}{border}}}\n"
    )
    text += f"  lamp: {{{lamp}, transform: {{translate: [{x}, {y}, {z}]}}}}\n"
    if bubble:
        # Behind a border the scene's own medium would follow.
        around = beside(case, side)
        text += f"  bubble: {{bsdf: nothing, interior: {bubble}, exterior: {around}, "
        text += f"shape: {{type: sphere, center: [{x}, {y}, {z}], radius: {BUBBLE}}}}}\n"
    return HEAD + text


def beside(case, side):
    """The medium on a side of the sheet."""
    camera, inner, outer, _ = CASES[case]
    if inner is None and outer is None:
        return camera
    return (outer or camera) if side > 0 else (inner or "none")


@pytest.mark.parametrize("side", [1, -1], ids=["before", "behind"])
@pytest.mark.parametrize("case", CASES)
def test_a_point_light_is_dimmed_by_the_media_on_its_side(case, side):
    text = scene_text(case, side, f"light: {{type: point, intensity: {INTENSITY}}}")
    found = samples_of(compiled(text, VolPath(max_depth=2)), spp=4)
    distance = np.linalg.norm(PLACE)
    there, bubble = MEDIA[beside(case, side)], CASES[case][3]
    within = min(BUBBLE, distance) if bubble else 0.0
    depth = np.multiply(there, distance - within)
    depth = depth + np.multiply(MEDIA[bubble or "none"], within)
    value = np.array(REFLECTED if side > 0 else PASSED) / np.pi
    expected = value * INTENSITY * PLACE[2] / distance**3 * np.exp(-depth)
    # What haze takes on the way to the camera, it takes of the number of paths.
    arrived = found.max(axis=-1) > 0.0
    np.testing.assert_allclose(found[arrived].mean(axis=0), expected, rtol=1e-3)
    np.testing.assert_allclose(
        found[arrived], np.broadcast_to(expected, found[arrived].shape), rtol=2e-2
    )
    share = np.exp(-MEDIA[CASES[case][0]][0] * 1.0)
    assert abs(arrived.mean() - share) < 4.5 * np.sqrt(share * (1 - share) / arrived.size) + 1e-9


@pytest.mark.parametrize("side", [1, -1], ids=["before", "behind"])
@pytest.mark.parametrize("case", CASES)
def test_all_ways_to_find_a_lamp_find_as_much_of_it(case, side):
    """What rays come upon has passed the media that shadow rays pass."""
    lamp = "shape: {type: sphere, radius: 0.35}, light: {type: area, radiance: 3}"
    text = scene_text(case, side, lamp)
    sums = {}
    for strategy, spp in (("mis", 16), ("emitter", 16), ("bsdf", 256)):
        # A lamp reflects, too: what is found is what the sheet sends, and that of the lamp itself.
        found = samples_of(compiled(text, VolPath(max_depth=2, light_sampling=strategy)), spp)
        values = found.reshape(-1, 3).astype(float)
        sums[strategy] = values.mean(axis=0), values.std(axis=0) / np.sqrt(len(values))
    for strategy in ("emitter", "bsdf"):
        off = np.abs(sums[strategy][0] - sums["mis"][0])
        noise = np.hypot(sums[strategy][1], sums["mis"][1])
        assert np.all(off < 4.5 * noise), (strategy, off / noise)
        assert np.all(noise < 0.04 * sums["mis"][0]), noise / sums["mis"][0]
