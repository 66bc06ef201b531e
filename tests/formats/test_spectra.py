"""Spectra of files become three numbers: what is lost is said."""

import numpy as np
import pytest

from alight.core.spectra import reflectance_weights
from alight.formats.materials.colors import losses
from tests.formats.mitsuba.reading import read as read_mitsuba
from tests.formats.pbrt.reading import read as read_pbrt

WAVES = np.linspace(360.0, 830.0, 48)
EVEN = (WAVES, np.full(48, 0.7))
#: A dye that reflects from 600 nm on; and green laser light.
STEEP = (WAVES, 0.9 / (1.0 + np.exp((600.0 - WAVES) / 15.0)))
LINE = (np.array([515.0, 520.0, 525.0]), np.array([0.0, 1.0, 0.0]))


@pytest.mark.parametrize("role", ["reflectance", "index", "light"])
def test_even_spectra_lose_nothing(role):
    assert losses(EVEN, role) == []


@pytest.mark.parametrize("role", ["reflectance", "index", "light"])
def test_colours_outside_of_srgb_are_told(role):
    [text] = [line for line in losses(LINE, role) if "lies outside" in line]
    # By another quadrature, where reflectances add up to white.
    fine = np.arange(360.0, 830.5, 1.0)
    line = np.interp(fine, *LINE, left=0.0, right=0.0)
    rgb = reflectance_weights(fine) @ line
    share = float(text.partition("and ")[2].split()[0])
    assert share == pytest.approx(-rgb.min() / rgb.max(), rel=0.15)


def test_the_error_of_a_second_reflection_is_told_of_surfaces_alone():
    [text] = [line for line in losses(STEEP, "reflectance") if "twice" in line]
    fine = np.arange(360.0, 830.5, 1.0)
    weights, once = reflectance_weights(fine), np.interp(fine, *STEEP)
    three, spectral = np.clip(weights @ once, 0.0, 1.0) ** 2, weights @ once**2
    wanted = np.abs(three - np.maximum(spectral, 0.0)).max() / spectral.max()
    assert wanted > 0.02
    assert float(text.partition("up to ")[2].split()[0]) == pytest.approx(wanted, rel=0.2)
    assert not any("twice" in line for line in losses(STEEP, "index"))


@pytest.mark.parametrize(("spectrum", "told"), [(EVEN, False), (STEEP, True), (LINE, True)])
def test_both_programs_files_say_so(spectrum, told, tmp_path):
    pairs = [f"{w:g} {v:g}" for w, v in zip(*spectrum, strict=True)]
    text = f'Material "diffuse" "spectrum reflectance" [{" ".join(pairs)}] Shape "sphere"'
    of_pbrt = read_pbrt(text)
    words = ", ".join(pair.replace(" ", ":") for pair in pairs)
    bsdf = f'<bsdf type="diffuse"><spectrum name="reflectance" value="{words}"/></bsdf>'
    of_mitsuba = read_mitsuba(f'<shape type="sphere">{bsdf}</shape>')
    for scene in (of_pbrt, of_mitsuba):
        said = [line for line in scene.source.remarks.warnings if "became linear sRGB" in line]
        assert len(said) == told
