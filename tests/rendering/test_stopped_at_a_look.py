"""A render to an error may be stopped when all samples of a look are there, and more are needed."""

import pytest

import alight
from alight.core.errors import OutputError
from alight.rendering.checkpoints.checkpoint import Origin, check_nothing_is_lost, write_checkpoint
from alight.rendering.job import JobState
from alight.rendering.schedules.steering import Steered
from alight.rendering.schedules.stopping import Promise


@pytest.mark.parametrize("error", [1e-4, 10.0])
def test_it_is_not_over_before_its_promise_is_kept(tmp_path, error):
    scene, path = alight.load("cornell-box", ("film.size=[8, 8]",)), tmp_path / "a.alight"
    film, looking = alight.render(scene, spp=16), Steered(0, None, Promise(error))
    goal = looking.next([film])
    state = JobState([film], looking.name, looking.state(), goal, 1, 1, 1.0, None)
    write_checkpoint(path, state, Origin.of(scene, {}))
    told = ""
    try:
        check_nothing_is_lost(path)
    except OutputError as problem:
        told = str(problem)
    assert ("to go on: alight resume" in told) == (error < 1.0)
