"""A render to an error may be stopped when all samples of a look are there, and more are needed."""

import pytest

import alight
from alight.core.errors import OptionError, OutputError
from alight.rendering.checkpoints.checkpoint import Origin, check_nothing_is_lost, write_checkpoint
from alight.rendering.job import JobState
from alight.rendering.schedules.steering import Steered
from alight.rendering.schedules.stopping import Promise
from lanewise.machine import describe_machine
from tests.rendering.interrupted import assert_same


@pytest.mark.parametrize("error", [1e-4, 10.0])
def test_it_is_not_over_before_its_promise_is_kept(tmp_path, error):
    scene, path = alight.load("cornell-box", ("film.size=[8, 8]",)), tmp_path / "a.alight"
    film, looking = alight.render(scene, spp=16), Steered(0, None, Promise(error))
    goal = looking.next([film])
    state = JobState([film], looking.name, looking.state(), goal, 1, 1, 1.0, None)
    write_checkpoint(path, state, Origin.of(scene, {}, describe_machine()))
    told = ""
    try:
        check_nothing_is_lost(path)
    except OutputError as problem:
        told = str(problem)
    assert ("to go on: alight resume" in told) == (error < 1.0)


def test_a_limit_alone_is_that_of_the_promise_made_first(tmp_path):
    small = alight.load("cornell-box", ("film.size=[8, 8]",))
    path, words = tmp_path / "a.alight", {"error": 1e-4}
    first = alight.render(small, checkpoint=path, max_spp=16, **words)
    assert first.spp == 16
    further = alight.resume(path, max_spp=40)
    assert further.stats["verdict"]["word"] == "not met"
    assert_same(further, alight.render(small, max_spp=40, **words))


def test_a_limit_alone_needs_a_promise(tmp_path):
    small, path = alight.load("cornell-box", ("film.size=[8, 8]",)), tmp_path / "a.alight"
    alight.render(small, checkpoint=path, spp=4)
    with pytest.raises(OptionError, match="max_spp limits error, which the checkpoint was not"):
        alight.resume(path, max_spp=40)
    with pytest.raises(OptionError, match="give one of the two"):
        alight.resume(path, max_spp=40, spp=20)
