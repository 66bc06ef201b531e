"""`check_laws` finds what is wrong with a user's model, and its statistics are SciPy's."""

import re
import types
from typing import Literal

import pytest
from scipy import stats

import alight
from alight.core.registration import RegistrationError, unregister
from alight.integrators import path
from alight.laws import bodies, emission, integrators, lights, media, statistics
from alight.lights import directional, point, spot
from alight.media import homogeneous
from alight.shapes import sphere
from lanewise.jit import kernel
from tests.docs.pages import ROOT, blocks
from tests.extension.models import LAMBERT, module_of


def broken_laws(text):
    """Names of the laws that a script's model breaks."""
    module = alight.register(module_of(text))
    try:
        report = alight.check_laws(module, compiled=False)
    finally:
        unregister("bsdfs", "lambert")
    assert report.ok == (not report.failures) == bool(report)
    return {result.law for result in report.failures}


def test_a_right_model_breaks_no_law():
    assert broken_laws(LAMBERT) == set()


VALUE = "params.reflectance * pdf, pdf"
MISTAKES = {
    "warp": ("square_to_cosine_hemisphere", "square_to_uniform_hemisphere", "Samples follow"),
    "gain": ("INV_PI * wi.z", "0.35 * wi.z", "Samples follow"),
    "weight": (
        "pdf > 0.0, params.reflectance",
        "pdf > 0.0, params.reflectance * 0.99",
        "weight of",
    ),
    "energy": (VALUE, "params.reflectance * pdf * 1.01, pdf", "No more light"),
    "back": ("(wo.z > 0.0) & (wi.z > 0.0)", "wi.z > 0.0", "black from behind"),
    "lossless": ("return spec.reflectance == (1.0, 1.0, 1.0)", "return True", "all light is"),
    "reciprocal": (VALUE, "params.reflectance * pdf * wo.z, pdf", r"f\(wo, wi\)"),
}


@pytest.mark.parametrize(("old", "new", "law"), MISTAKES.values(), ids=MISTAKES)
def test_mistakes_break_the_law_that_they_offend(old, new, law):
    assert old in LAMBERT
    assert any(re.search(law, name) for name in broken_laws(LAMBERT.replace(old, new)))


def test_unregistered_models_are_refused():
    with pytest.raises(RegistrationError, match="register lambert first"):
        alight.check_laws(module_of(LAMBERT))


@pytest.mark.parametrize("light", [point, directional, spot], ids=lambda m: m.__name__)
def test_our_lights_obey(light):
    report = alight.check_laws(light, compiled=light is spot)
    assert report, str(report)


DOCUMENTED = {
    "minnaert": "bsdfs",
    "downlight": "lights",
    "kronecker": "samplers",
    "exponential": "tone_curves",
    "log_error": "metrics",
}


@pytest.mark.parametrize("name", DOCUMENTED)
def test_models_of_the_page_obey(name):
    page = ROOT / "docs" / "extending.md"
    [text] = [text for text in blocks(page, "python") if f'type: Literal["{name}"]' in text]
    module = alight.register(module_of(text, name))
    try:
        report = alight.check_laws(module, compiled=False)
    finally:
        unregister(DOCUMENTED[name], name)
    assert report, str(report)


def test_a_light_with_wrong_power_is_found():
    text = (ROOT / "alight" / "lights" / "point.py").read_text()
    text = text.replace('"point"', '"users_point"').replace("4.0 * PI", "2.0 * PI")
    module = alight.register(module_of(text, "users_point"))
    try:
        report = alight.check_laws(module, compiled=False)
    finally:
        unregister("lights", "users_point")
    assert {"power" in result.law for result in report.failures} == {True}
    assert "declared power" in str(report)


@pytest.fixture
def register_point():
    """Registers the point light anew, with other kernels and the same description."""
    members = {name: value for name, value in vars(point).items() if name[:2] != "__"}
    spec = type("OurPoint", (point.Point,), {
        "__annotations__": {"type": Literal["our_point"]}, "type": "our_point",
        "__module__": __name__,
    })  # fmt: skip
    members = {**members, "Point": spec, "EXAMPLES": (spec(),)}
    yield lambda **kernels: alight.register(types.SimpleNamespace(**{**members, **kernels}))
    unregister("lights", "our_point")


@kernel
def bright_sample(scene, index, p, u, u2):
    found = our_sample(scene, index, p, u, u2)
    return found._replace(radiance=found.radiance * 1.5)


@kernel
def bright_emit(scene, index, u2, v2):
    found = our_emit(scene, index, u2, v2)
    return found._replace(flux=found.flux * 1.5)


our_sample, our_emit = point.sample, point.emit


@pytest.mark.parametrize(
    "wrong", [{"sample": bright_sample}, {"emit": bright_emit}], ids=["sample", "emit"]
)
def test_laws_look_at_the_kernels_that_were_registered_last(register_point, wrong):
    for kernels in ({}, wrong, {}):
        report = alight.check_laws(register_point(**kernels), compiled=False)
        assert report.ok == (not kernels), str(report)


REMEMBERED = {
    "rays": (emission.emitted_by, point.EXAMPLES[:1]),
    "light": (lights.scene_of, point.EXAMPLES[:1]),
    "room": (integrators.room, path.EXAMPLES[:1]),
    "medium": (media.ball_of, homogeneous.EXAMPLES[:1]),
    "furnace": (media.furnace_of, homogeneous.EXAMPLES[:1]),
    "body": (bodies.body_of, (sphere.EXAMPLES[0], next(iter(bodies.PLACEMENTS)))),
}


@pytest.mark.parametrize(("function", "given"), REMEMBERED.values(), ids=REMEMBERED)
def test_what_laws_remember_is_of_the_registered_models(register_point, function, given):
    first = function(*given)
    assert function(*given) is first
    register_point()
    assert function(*given) is not first


@pytest.mark.parametrize(("x", "dof"), [(0.5, 1), (3.0, 10), (400.0, 300), (9.0, 200), (900, 300)])
def test_chi_square_tail_is_that_of_scipy(x, dof):
    assert statistics.chi_square_tail(x, dof) == pytest.approx(stats.chi2.sf(x, dof), rel=1e-8)


@pytest.mark.parametrize(("count", "mean"), [(1, 0.01), (5, 2.0), (20, 9.5), (0, 3.0)])
def test_poisson_tail_is_that_of_scipy(count, mean):
    expected = stats.poisson.sf(count - 1, mean)
    assert statistics.poisson_tail(count, mean) == pytest.approx(expected, rel=1e-8)
    assert stats.norm.isf(statistics.SIGNIFICANCE / 2) == pytest.approx(statistics.LARGEST_Z)
