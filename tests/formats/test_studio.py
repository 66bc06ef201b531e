"""The studio: light and a floor for what has neither light nor a camera of its own."""

import numpy as np
import pytest

from alight.formats import load
from alight.formats.gltf.container import open_document
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report
from alight.formats.scenes.made_up import without_floor
from alight.formats.scenes.surroundings import FLOOR_RADIUS, GAP, is_floor
from alight.scene.builtin.studio import EDGE, MIDDLE, ROWS, studio, studio_floor
from alight.scene.flatten import flatten
from tests.formats.gltf.maker import Maker

TRIANGLE = "v {0} 0 0\nv {1} 0 0\nv {0} {2} 0\nf 1 2 3\n"


@pytest.fixture
def model(tmp_path):
    """A function that writes a triangle of two sides of a length, off the origin."""

    def write(side):
        path = tmp_path / "a.obj"
        path.write_text(TRIANGLE.format(4.0 * side, 5.0 * side, side))
        return path

    return write


def floors(scene):
    return [node for node in scene.nodes.values() if is_floor(node.bsdf)]


# ---------------------------------------------------------------- light


def irradiance(radiance, normal):
    """Irradiance over pi by the midpoint rule, shape (3,)."""
    theta = (np.arange(ROWS) * (np.pi / (ROWS - 1)))[:, None]
    around = (np.arange(2 * ROWS) + 0.5) * (np.pi / ROWS)
    d = (
        np.sin(theta) * np.sin(around),
        np.cos(theta) + 0 * around,
        -np.sin(theta) * np.cos(around),
    )
    cosine = np.maximum(sum(a * b for a, b in zip(d, normal, strict=True)), 0.0)
    weights = cosine * np.sin(theta) * (np.pi / (ROWS - 1)) * (np.pi / ROWS) / np.pi
    return np.einsum("ij,ijk->k", weights, radiance.astype(np.float64))


def test_floor_and_backdrop_meet_without_a_line():
    radiance = studio()
    edge = studio_floor()[0, -1, 0] * irradiance(radiance, (0.0, 1.0, 0.0))
    below = radiance[ROWS // 2 :]
    np.testing.assert_allclose(below, np.broadcast_to(edge, below.shape), rtol=1e-4)
    # Right above the horizon too, but for the soft boxes, which do not reach down to it.
    np.testing.assert_allclose(radiance[ROWS // 2 - 1], below[0], rtol=1e-3)


def test_white_paper_facing_the_light_shows_nine_tenths():
    radiance = studio()
    angles = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    normals = [(np.sin(a) * s, np.sqrt(1 - s * s), np.cos(a) * s) for a in angles
               for s in (0.0, 0.4, 0.6, 0.8, 1.0)]  # fmt: skip
    assert max(irradiance(radiance, n).max() for n in normals) == pytest.approx(0.9, abs=0.03)


def test_the_floor_grows_darker_from_its_middle_and_is_even_at_its_edge():
    albedo = studio_floor()[0, :, 0]
    assert albedo[0] == pytest.approx(MIDDLE, abs=1e-4)
    assert (np.diff(albedo) <= 0.0).all()
    np.testing.assert_allclose(albedo[len(albedo) // 2 :], EDGE, atol=1e-3)
    # No band: neighbouring texels differ by less than half a step of 8 bits.
    assert np.abs(np.diff(albedo)).max() < 0.5 / 255.0


# ---------------------------------------------------------------- floor


@pytest.mark.parametrize("side", [1e-3, 1.0, 1e3])
def test_the_floor_fits_the_model(side, model):
    scene = load(model(side))
    [node] = floors(scene)
    radius = side * np.sqrt(0.5)
    place = node.transform.matrix
    np.testing.assert_allclose(place[:3, 3], [4.5 * side, -GAP * radius, 0.0], atol=1e-6 * side)
    np.testing.assert_allclose(place[:3, 2], [0.0, FLOOR_RADIUS * radius, 0.0], atol=1e-6 * side)
    assert flatten(scene).shapes[-1].name == "studio floor"


@pytest.mark.parametrize(
    ("change", "stands"),
    [
        ("environment.scale=2", True),
        ("camera.fov=20", True),
        ("environment.file=builtin:sky", False),
        ("environment=null", False),
        ("environment={type: constant}", False),
    ],
)
def test_the_floor_goes_with_the_studio(change, stands, model):
    assert bool(floors(load(model(1.0), [change]))) is stands


def test_without_its_floor_a_scene_still_says_what_it_said(model):
    scene = load(model(1.0))
    bare = without_floor(scene)
    assert not floors(bare)
    assert bare.warnings == scene.warnings
    assert without_floor(bare) is bare


def test_a_file_with_a_camera_is_a_place_and_needs_no_floor(tmp_path):
    m = Maker()
    m.node(mesh=m.square())
    m.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0}}]
    m.node(camera=0)
    (tmp_path / "a.glb").write_bytes(m.glb())
    scene = load(tmp_path / "a.glb")
    assert scene.environment is not None
    assert not floors(scene)


def test_the_floor_is_not_written_into_models(model, tmp_path):
    from typer.testing import CliRunner

    from alight.cli.main import app

    written = tmp_path / "b.glb"
    done = CliRunner().invoke(app, ["convert", str(model(1.0)), str(written)])
    assert done.exit_code == 0
    document = open_document(written.read_bytes(), "b.glb", Reach(), Report())
    assert len(document.list("meshes")) == 1
