"""What is asked of a place of the picture: the path through a pixel, the noise of a region."""

import itertools

import numpy as np
import pytest

import alight
from alight.lab.why import shares_of
from alight.view import inspection, protocol
from alight.view.inspection import path_through
from alight.view.layers import FileLayers
from alight.view.opening import session_of
from alight.view.protocol import RefusedError
from alight.view.session import Session
from tests.view.looking import OPTIONS, cornell, settled
from tests.view.test_session import content, read_picture


@pytest.fixture
def session():
    found = cornell()
    yield found
    found.close()


def test_a_traced_path_is_that_of_the_sample_in_the_film(session):
    session.apply(protocol.Orbit(0.03, 0.01))
    settled(session)
    told = session.apply(protocol.AskTrace(9, 8, 2))
    found = alight.trace(session.live.scene, (9, 8), sample=2)
    assert told["value"] == list(found.value)
    assert [v["depth"] for v in told["vertices"]] == [v.depth for v in found.vertices]
    assert told["number"] == session.number


def test_lines_begin_in_the_pixel_and_go_on_where_they_have_ended(session):
    told = session.apply(protocol.AskTrace(9, 8, 0))
    path = [line["points"] for line in told["lines"] if line["kind"] == "path"]
    # All of a camera ray is one place of the picture.
    for x, y in path[0]:
        assert 9.0 <= x <= 10.0 and 8.0 <= y <= 9.0
    for one, following in itertools.pairwise(path):
        np.testing.assert_allclose(one[1], following[0], atol=0.01)
    assert {line["kind"] for line in told["lines"]} <= {"path", "light", "shadow"}
    assert np.isfinite([line["points"] for line in told["lines"]]).all()


def test_rays_to_lamps_end_there_and_are_shadows_where_something_is_between(session):
    """Of a few samples, of which some are lit and some are not."""
    kinds = set()
    for sample in range(4):
        told = path_through(session.live, 9, 8, sample)
        found = alight.trace(session.live.scene, (9, 8), sample=sample)
        lit = [one for one in found.vertices if one.light and one.light.visible is not None]
        lines = [line for line in told["lines"] if line["kind"] != "path"]
        for line, vertex in zip(lines, lit, strict=True):
            kinds.add(line["kind"])
            assert line["kind"] == ("light" if vertex.light.visible else "shadow")
            here = np.array(vertex.position)
            lamp = here + vertex.light.distance * np.array(vertex.light.wi)
            # All of the box is before the camera.
            expected = inspection._line(session.live, session.live.pose, "", here, lamp)
            np.testing.assert_allclose(line["points"], expected["points"], atol=0.01)
    assert kinds == {"light", "shadow"}


def test_a_cropped_picture_traces_its_own_pixels():
    session = session_of("cornell-box", OPTIONS.changed(crop=(3, 5, 13, 9)))
    try:
        told = path_through(session.live, 4, 2, 0)
        assert told["value"] == list(alight.trace(session.live.scene, (7, 7)).value)
        x, y = told["lines"][0]["points"][1]
        assert 4.0 <= x <= 5.0 and 2.0 <= y <= 3.0
    finally:
        session.close()


def test_what_cannot_be_traced_is_told():
    session = session_of("cornell-box", OPTIONS.changed(integrator="light"))
    try:
        assert "no path of light" in session.apply(protocol.AskTrace(1, 1, 0))["why"]
        assert "does not record" in session.apply(protocol.AskWhy(1, 1, 4, 4))["why"]
    finally:
        session.close()


def test_a_region_is_rendered_alone_and_its_film_is_that_of_a_crop(session, tmp_path):
    whole = settled(session)
    session.apply(protocol.Region(4, 2, 8, 6))
    session.apply(protocol.Region(1, 1, 6, 4))  # of the region before
    film = settled(session)
    same = alight.render("cornell-box", size=(24, 16), crop=(5, 3, 6, 4), spp=4, threads=1)
    assert content(film, tmp_path / "a.alight") == content(same, tmp_path / "b.alight")
    assert session.state(None, None)["size"] == [6, 4]
    session.apply(protocol.Whole())
    assert content(settled(session), tmp_path / "a.alight") == content(whole, tmp_path / "b.alight")
    assert session.apply(protocol.Region(20, 2, 8, 6))["is"] == "wrong"


def test_only_scenes_are_inspected():
    session = Session("a", FileLayers(read_picture()))
    for event in (protocol.AskTrace(0, 0, 0), protocol.AskWhy(0, 0, 2, 2), protocol.Whole()):
        with pytest.raises(RefusedError, match="only scenes"):
            session.apply(event)


def test_the_noise_of_regions_adds_up_to_that_of_the_picture():
    scene = alight.load("cornell-box")
    whole = shares_of(scene, size=24, spp=32)
    halves = [
        shares_of(scene, size=24, spp=32, region=(0.0, y, 1.0, 0.5)).relative_variance
        for y in (0.0, 0.5)
    ]
    height = whole.variance.shape[0]
    # Each is a mean over its own pixels.
    rows = np.array([height // 2, height - height // 2]) / height
    assert height % 2 == 0
    assert np.dot(halves, rows) == pytest.approx(whole.relative_variance, rel=1e-9)
    corner = shares_of(scene, size=24, spp=32, region=(0.99, 0.99, 0.0, 0.0))
    assert np.count_nonzero(corner.variance) <= 1
