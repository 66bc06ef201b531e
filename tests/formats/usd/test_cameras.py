"""Cameras of UsdGeom see what OpenUSD's own camera does."""

import numpy as np
import pytest

from alight.cameras.model import CAMERAS
from alight.scene.flatten import place_camera
from tests.formats.usd.stage import SQUARE, usd_loader

Usd = pytest.importorskip("pxr.Usd")
UsdGeom = pytest.importorskip("pxr.UsdGeom")


def both(tmp_path, unit, **values):
    """Our camera, half the width and height that it sees at 1 m, and OpenUSD's."""
    lines = [
        f'token {name} = "{value}"' if isinstance(value, str) else f"float {name} = {value}"
        for name, value in values.items()
    ]
    inner = "; ".join(lines)
    text = f'def Mesh "m" {{ {SQUARE} }}\ndef Camera "c" {{ {inner} }}'
    scene = usd_loader(tmp_path)(text, unit=unit)
    camera = place_camera(scene).camera
    extents = CAMERAS[camera.type_name()].half_extents(camera, *scene.film.size)
    stage = Usd.Stage.Open(str(tmp_path / "a.usda"))
    theirs = UsdGeom.Camera(stage.GetPrimAtPath("/c")).GetCamera(Usd.TimeCode.Default())
    return camera, np.array(extents), theirs


@pytest.mark.parametrize("unit", [1, 0.01])
@pytest.mark.parametrize("projection", ["perspective", "orthographic"])
@pytest.mark.parametrize(
    ("width", "height", "focal"), [(36, 24, 50), (20, 30, 35), (20.955, 15.2908, 120)]
)
def test_pictures_show_as_much(projection, width, height, focal, unit, tmp_path):
    _, ours, theirs = both(
        tmp_path, unit, projection=projection, horizontalAperture=width, verticalAperture=height,
        focalLength=focal,
    )  # fmt: skip
    # Of a parallel camera in units of the stage, which its place scales.
    window = theirs.frustum.window
    wanted = [0.5 * window.GetSize()[0], 0.5 * window.GetSize()[1]]
    np.testing.assert_allclose(ours, wanted, rtol=2e-3)


@pytest.mark.parametrize(("stop", "focal"), [(2.0, 50.0), (5.6, 100.0), (0.0, 50.0)])
def test_lenses_are_as_wide_as_the_f_number_says(stop, focal, tmp_path):
    """The diameter is the focal length, a tenth of a unit each, over the f-number."""
    camera, _, theirs = both(tmp_path, 1, fStop=stop, focalLength=focal, focusDistance=7.0)
    assert theirs.fStop == pytest.approx(stop)
    if not stop:
        assert camera.type_name() == "pinhole"
        return
    assert camera.aperture_radius == pytest.approx(0.5 * 0.1 * focal / stop)
    assert camera.focus_distance == pytest.approx(theirs.focusDistance)
