"""Materials of Mitsuba's files have Mitsuba's values: `values.npz`, as `make_values.py` stores it.

One direction at a time, without noise; pictures of the same are in ``tests/images``.
"""

from pathlib import Path

import numpy as np
import pytest

from alight.bsdfs.adapters.bump_map import BumpMap
from alight.bsdfs.disney.principled import Principled
from alight.bsdfs.matte.diffuse import Diffuse
from alight.laws.materials import Material
from alight.textures.bitmap import Bitmap
from tests.formats.mitsuba import values
from tests.formats.mitsuba.reading import read_bsdf

WO, WI = values.directions()
ORANGE, GREEN = (0.9, 0.5, 0.1), (0.64, 0.81, 0.49)
#: alight's `principled` by the names of `values.SHARED`. Mitsuba tints glass by the root.
OWN = {
    "metal": Principled(base_color=ORANGE, metallic=1.0),
    "plastic": Principled(base_color=0.0),
    "glass": Principled(base_color=tuple(c**0.5 for c in GREEN), transmission=1.0),
}


@pytest.fixture(scope="module")
def stored() -> dict[str, np.ndarray]:
    """Mitsuba's side."""
    with np.load(Path(__file__).parent / "values.npz", allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def test_everything_is_stored(stored) -> None:
    bumps = {f"bump {place}" for place in values.PLACES}
    assert set(stored) == set(values.MATERIALS) | set(values.SHARED) | bumps
    assert all((table[1] > 0.0).sum() >= 30 for table in stored.values())


@pytest.mark.parametrize("name", values.MATERIALS)
def test_materials_of_files(name: str, stored) -> None:
    kind, content = values.MATERIALS[name]
    f_cos, pdf = Material(read_bsdf(content, f'type="{kind}"')).evaluate(WO, WI)
    np.testing.assert_allclose(f_cos, stored[name][:3], rtol=1e-4, atol=1e-6)
    # Mitsuba's opaque materials have a density from behind, and no value.
    scatters = stored[name][1] > 0.0
    np.testing.assert_allclose(pdf[scatters], stored[name][3, scatters], rtol=2e-4)


@pytest.mark.parametrize("roughness", values.ROUGHNESSES)
@pytest.mark.parametrize("name", OWN)
def test_parts_that_principled_shares_with_mitsubas(name: str, roughness: float, stored) -> None:
    """Metal, glass, and what plastic reflects; how they are sampled differs."""
    spec = OWN[name].replaced(roughness=roughness, compensation=False)
    f_cos, _ = Material(spec).evaluate(WO, WI)
    np.testing.assert_allclose(f_cos, stored[f"{name} {roughness}"][:3], rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("place", values.PLACES)
def test_bump_maps(place: tuple[float, float], stored) -> None:
    matte = Diffuse(reflectance=(0.7, 0.4, 0.2))
    picture = Bitmap(pixels=values.HEIGHTS, wrap="clamp")
    bsdf = BumpMap(texture=picture, scale=0.1, rims="folded", bsdf=matte)
    f_cos, _ = Material(bsdf, uv=(place[0], 1.0 - place[1])).evaluate(WO, WI)
    # Slopes are differences of float32 over 2^-13 here, good to 5e-5 after the factor 0.1.
    np.testing.assert_allclose(f_cos, stored[f"bump {place}"][:3], rtol=1e-4, atol=4e-5)
