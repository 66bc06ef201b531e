"""Materials turned about the normal: brushed ones follow their tangent, others do not notice it."""

import numpy as np
import pytest

from alight.bsdfs.conductors.rough_conductor import RoughConductor
from alight.bsdfs.dielectrics.rough_dielectric import RoughDielectric
from alight.bsdfs.disney.principled import Principled
from alight.bsdfs.fibres.hair import Hair
from alight.bsdfs.nesting import leaves
from alight.laws import bsdfs as laws
from alight.textures.checkerboard import Checkerboard
from tests.sampling.materials import EXAMPLES, NAMES, Material, direction, random_numbers
from tests.sampling.statistics import unit_vectors

N = 4096
#: What each kind of brushed surface adds to lobes: all of them turn together, or not at all.
BRUSHED = {
    "metal": {"metallic": 1.0, "roughness": 0.3},
    "plastic": {"roughness": 0.4},
    "glass": {"transmission": 1.0, "roughness": 0.4},
    "sheet": {"transmission": 0.7, "thin": True, "roughness": 0.5},
    "layers": {"metallic": 0.4, "clearcoat": 0.7, "clearcoat_roughness": 0.3, "sheen_color": 0.4},
    "film": {"iridescence": 1.0, "metallic": 0.5, "transmission": 0.5},
}
#: Examples of all models; a tilted normal is a direction that a map has, as are scales of hair.
UNBENT = {
    name: spec
    for name, spec in zip(NAMES, EXAMPLES, strict=True)
    if all(leaf.normals is None for leaf in leaves(spec))
    and not (isinstance(spec, Hair) and spec.alpha)
}
ANGLES = (0.5, 2.2, -1.3)
each_kind = pytest.mark.parametrize("kind", BRUSHED)


def brushed(kind, angle):
    """A surface whose facets are rougher at this angle from the tangent."""
    fields = {"base_color": (0.9, 0.5, 0.2), "anisotropy": 0.8} | BRUSHED[kind]
    return Principled(**fields, anisotropy_rotation=angle)


def turned(w, angle):
    """Vectors (3, n) turned about the normal, from the tangent s towards t."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = w.astype(np.float64)
    return np.stack([c * x - s * y, s * x + c * y, z]).astype(np.float32)


def check_same(found, expected, tolerance=2e-3):
    """The same values; in narrow lobes roundings of directions are a few parts in a thousand."""
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=tolerance, atol=1e-5 * scale)


@each_kind
@pytest.mark.parametrize("angle", ANGLES)
def test_values_turn_with_the_brush(kind, angle):
    wo, wi = unit_vectors(N, 1), unit_vectors(N, 2)
    straight = Material(brushed(kind, 0.0)).evaluate(wo, wi)
    found = Material(brushed(kind, angle)).evaluate(turned(wo, angle), turned(wi, angle))
    for one, other in zip(found, straight, strict=True):
        check_same(one, other)


@each_kind
@pytest.mark.parametrize("angle", ANGLES)
def test_samples_turn_with_the_brush(kind, angle):
    wo, u = unit_vectors(N, 3), random_numbers(N, 4)
    straight, weight, pdf, flags = Material(brushed(kind, 0.0)).sample(wo, u)
    wi, *others = Material(brushed(kind, angle)).sample(turned(wo, angle), u)
    # A number beside the border of two lobes may choose the other one.
    same = others[2] == flags
    assert same.mean() > 0.999
    np.testing.assert_allclose(wi[:, same], turned(straight, angle)[:, same], atol=2e-4)
    check_same(others[1][same], pdf[same])
    check_same(others[0][:, same], weight[:, same])


@pytest.mark.parametrize(
    ("kind", "cosine"), [("metal", 0.7), ("layers", 0.7), ("glass", -0.5), ("sheet", -0.5)]
)
def test_samples_of_turned_facets_follow_their_density(kind, cosine):
    """With the angle as a number, and looked up."""
    angle = 0.9 if cosine > 0.0 else Checkerboard(color0=0.9, color1=0.9)
    laws.samples_follow_their_density(Material(brushed(kind, angle)), cosine)


def test_the_rougher_way_lies_at_the_angle_from_the_tangent():
    """Light spreads most there: the tangent turned towards its right-handed companion."""
    wo, u = direction(1.0), random_numbers(20_000, 5)
    for angle in ANGLES:
        wi, *_ = Material(brushed("metal", angle)).sample(wo, u)
        spread = np.cov(wi[:2].astype(np.float64))
        long_axis = np.linalg.eigh(spread)[1][:, 1]
        assert abs(long_axis @ [np.cos(angle), np.sin(angle)]) > 0.995


@pytest.mark.parametrize("model", [RoughConductor, RoughDielectric])
@pytest.mark.parametrize("distribution", ["ggx", "beckmann"])
def test_roughness_along_and_across_change_places_by_a_right_angle(model, distribution):
    wo, wi = unit_vectors(N, 6), unit_vectors(N, 7)
    right = 0.5 * np.pi
    spec = model(distribution=distribution, alpha_u=0.3, alpha_v=0.7)
    across = spec.replaced(alpha_u=0.7, alpha_v=0.3)
    found = Material(across).evaluate(turned(wo, right), turned(wi, right))
    for one, other in zip(found, Material(spec).evaluate(wo, wi), strict=True):
        check_same(one, other)


@pytest.mark.parametrize("spec", UNBENT.values(), ids=UNBENT)
def test_what_is_alike_on_all_sides_does_not_notice_a_turn(spec):
    """Of all models; those with a direction notice only what is not half a turn."""
    material = Material(spec)
    angle = np.pi if "anisotropic" in material.program.bsdfs else 1.1
    wo, wi = unit_vectors(N, 8), unit_vectors(N, 9)
    found = material.evaluate(turned(wo, angle), turned(wi, angle))
    for one, other in zip(found, material.evaluate(wo, wi), strict=True):
        check_same(one, other)
    if angle == np.pi:
        # Nor a mirror image in the plane of the brush.
        mirror = np.float32([[-1.0], [1.0], [1.0]])
        for one, other in zip(
            material.evaluate(mirror * wo, mirror * wi), material.evaluate(wo, wi), strict=True
        ):
            check_same(one, other)
