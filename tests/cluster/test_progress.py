"""A hang is told from a machine that is busy with other things."""

import subprocess
import sys
import time

import pytest

from tests.cluster.progress import Hang, Watch


@pytest.fixture
def process(request):
    """A process that does what the test's mark says."""
    with subprocess.Popen([sys.executable, "-Sc", request.param]) as made:
        yield made
        made.kill()


SLEEPS, SPINS = "import time; time.sleep(60)", "while True: pass"


@pytest.mark.parametrize("process", [SLEEPS], indirect=True)
def test_who_waits_without_a_result_hangs(process):
    watch = Watch(lambda: 0.0, lambda: [process.pid], idle=0.5)
    with pytest.raises(Hang, match="idle"):
        watch.until(lambda: False)
    assert watch.longest > 0.5


@pytest.mark.parametrize("process", [SPINS], indirect=True)
def test_who_wants_a_processor_is_not_idle(process):
    watch = Watch(lambda: 0.0, lambda: [process.pid], idle=0.5)
    end = time.monotonic() + 1.5
    watch.until(lambda: time.monotonic() > end)
    assert watch.longest < 0.5


@pytest.mark.parametrize("process", [SPINS], indirect=True)
def test_who_runs_in_circles_hangs(process):
    with pytest.raises(Hang):
        Watch(lambda: 0.0, lambda: [process.pid], spent=0.3).until(lambda: False)


@pytest.mark.parametrize("process", [SLEEPS], indirect=True)
def test_who_gives_results_may_wait(process):
    end = time.monotonic() + 1.5
    Watch(time.monotonic, lambda: [process.pid], idle=0.5).until(lambda: time.monotonic() > end)
