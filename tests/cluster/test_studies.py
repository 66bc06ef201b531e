"""Studies on a cluster: the numbers of one machine, and times that compare."""

import numpy as np
import pytest

from alight.core.errors import FilmError, OptionError
from alight.films.archive import pack_archive
from alight.lab.replicates import run_blocks
from alight.lab.replicates.spread import Ladder, read_replicate
from alight.lab.run import run_study
from alight.lab.study import ArmSpec, SceneSpec, Study
from alight.options.cluster import ClusterOptions
from tests.cluster import jobs
from tests.cluster.workers import two_workers

SCENE = SceneSpec("smooth-direct-light", options={"size": 32})
ARMS = (
    ArmSpec("independent", {"sampler": "independent"}),
    ArmSpec("sobol", {"sampler": "sobol"}),
    ArmSpec("adaptive", {"sampler": "sobol", "schedule": "adaptive"}),
)


def study(**changes):
    fixed = {"spp": (4, 16), "replicates": 4, "baseline": "independent", "equal_time": False}
    return Study("small", arms=ARMS, scenes=[SCENE], **{**fixed, **changes})


@pytest.fixture(scope="module")
def client():
    with two_workers() as client:
        yield client


def errors_of(result):
    """Everything but times."""
    return {
        arm.name: [(point.spp, point.mse.value, point.relmse.value) for point in arm.samples]
        for arm in result.scenes[0].arms
    }


def test_a_study_on_a_cluster_finds_the_same_numbers(client, tmp_path):
    own = run_study(study(), tmp_path / "own")
    here = []
    theirs = run_study(study(), tmp_path / "theirs", cluster=ClusterOptions(cluster=client),
                       progress=lambda told: here.append(told.text))  # fmt: skip
    assert errors_of(theirs) == errors_of(own)
    for first, second in zip(own.scenes[0].arms, theirs.scenes[0].arms, strict=True):
        assert (first.bias.p_value, first.invalid) == (second.bias.p_value, second.invalid)
    assert theirs.scenes[0].notes == own.scenes[0].notes
    assert sum("replicate" in text for text in here) == 4 * len(ARMS)
    assert theirs.seconds["render"] > 0.0


def test_times_of_another_processor_are_refused_or_marked(client, tmp_path):
    one, options = min(client.nthreads()), ClusterOptions(cluster=client)
    client.run(jobs.become_another_processor, workers=[one])
    try:
        told = refusal_of(run_study, study(equal_time=True), tmp_path / "a", cluster=options)
        assert "others are Slow 3000: take those away, or say equal_time: false" in told
        # Dask may give one of two workers nothing; of so many replicates it does not.
        found = run_study(study(replicates=8), tmp_path / "b", cluster=options)
    finally:
        client.run(jobs.become_this_processor)
    assert any("different processors" in note and "Slow 3000" in note
               for note in found.scenes[0].notes)  # fmt: skip
    # The store knows it, when the same study goes on without the cluster.
    assert run_study(study(replicates=8), tmp_path / "b").scenes[0].notes == found.scenes[0].notes


def test_times_of_another_processor_in_the_store_are_refused_or_marked(monkeypatch, tmp_path):
    own = run_blocks.processor()
    for equal_time in (False, True):
        folder = tmp_path / str(equal_time)
        fixed = {"equal_time": equal_time, "replicates": 4}
        monkeypatch.setattr(run_blocks, "processor", lambda: "Slow 3000")
        run_study(study(**fixed), folder)
        monkeypatch.setattr(run_blocks, "processor", lambda: own)
        more = study(**{**fixed, "replicates": 5})
        if equal_time:
            assert "were timed on Slow 3000: write to another" in refusal_of(
                run_study, more, folder
            )
        else:
            notes = run_study(more, folder).scenes[0].notes
            assert f"times are those of different processors: {own}, Slow 3000" in notes
            # Whoever only looks at what is there is told so, too.
            assert run_study(more, folder).scenes[0].notes == notes


def test_only_pictures_are_spread(client, tmp_path):
    integrals = study(kind="integrals")
    with pytest.raises(OptionError, match="studies of pictures, this one is of integrals"):
        run_study(integrals, tmp_path, cluster=ClusterOptions(cluster=client))


# ---------------------------------------------------------------------------- answers

TASK, SIZE = Ladder(0, 7, (2, 5)), (4, 3)


def answer(**changes):
    told = [{"spp": spp, "seconds": 0.5, "invalid": 0} for spp in TASK.ladder]
    content = {"task": TASK.digest, "rungs": told, "processor": "one"}
    arrays = {str(n): np.full((3, 4, 3), n, np.float32) for n in range(2)}
    for name, value in changes.items():
        (arrays if name.isdigit() else content)[name] = value
    return b"".join(pack_archive(content, arrays))


def test_an_answer_is_its_pictures():
    rungs, name = read_replicate(TASK, SIZE, answer())
    assert [(rung.spp, rung.seconds, rung.invalid) for rung in rungs] == [(2, 0.5, 0), (5, 0.5, 0)]
    assert [rung.picture.max() for rung in rungs] == [0.0, 1.0]
    assert name == "one"


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (None, "no bytes"),
        (answer() + bytes(10**6), "too long"),
        (answer(task="0"), "another replicate"),
        (answer(rungs=[]), "other steps"),
        (answer(**{"1": np.zeros((4, 4, 3), np.float32)}), "picture of shape"),
        (answer(**{"1": np.zeros((3, 4, 3))}), "picture of shape"),
        (answer(**{"1": np.full((3, 4, 3), np.nan, np.float32)}), "numbers that no replicate"),
        (answer(rungs=[{"spp": n, "seconds": -1.0, "invalid": 0} for n in (2, 5)]), "numbers that"),
        (answer(rungs=[{"spp": n} for n in (2, 5)]), "cannot be read: KeyError"),
        (answer()[:-1] + b"!", "checksum"),
    ],
)
def test_a_malformed_answer_is_refused(data, message):
    assert message in refusal_of(read_replicate, TASK, SIZE, data)


def refusal_of(function, *words, **options):
    try:
        function(*words, **options)
    except (FilmError, OptionError) as error:
        return str(error)
    return "none"
