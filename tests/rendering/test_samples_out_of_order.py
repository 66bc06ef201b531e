"""A render that was stopped may hold the end of a pass and not its beginning."""

import alight
from alight.options.resume import ResumeOptions
from alight.rendering import main_loop
from alight.rendering.checkpoints.resume import prepare_resume
from alight.rendering.executors.blocks import Threads
from alight.rendering.executors.cluster_executor import split
from tests.rendering.interrupted import assert_same, cancelled_after

SPP = 24
RENDER = {"size": (72, 40), "crop": (3, 2, 60, 37), "threads": 1}


class Backwards(Threads):
    """The second half of each tile's samples first, as workers of a cluster may answer."""

    def render(self, settings, blocks, add, cancel, report):
        for block in blocks:
            for half in reversed(split(block, 0.5)):
                if half.ranges[..., 1].any() and not cancel.is_set():
                    super().render(settings, [half], add, cancel, report)


def test_samples_that_came_out_of_order_leave_no_hole(tmp_path, monkeypatch):
    """A pixel that holds samples 12 to 23 alone has 12, and needs 24 to be whole."""
    path = tmp_path / "a.alight"
    with cancelled_after(1, monkeypatch) as cancel, monkeypatch.context() as patch:
        patch.setattr(main_loop, "executor_of", lambda options, device: Backwards())
        words = {**RENDER, "spp_per_pass": SPP, "checkpoint": path, "cancel": cancel}
        film = alight.render("cornell-box", spp=SPP, **words)
    assert film.sample_count.max() == SPP // 2
    assert {tuple(cell) for cell in film.cells.flat} == {(), ((SPP // 2, SPP),)}

    def warnings_of(spp):
        return prepare_resume(path, ResumeOptions(spp=spp)).warnings()

    assert warnings_of(SPP) == []
    promised = ResumeOptions(metric="pixel", confidence=0.99)
    assert prepare_resume(path, promised).warnings(str.upper) == [
        f"{name} does nothing without ERROR" for name in ("CONFIDENCE", "METRIC")
    ]
    end = f"beyond spp 23, which stay: {SPP} or more gives all pixels the same"
    assert [warning[-len(end) :] for warning in warnings_of(SPP - 1)] == [end]
    assert_same(alight.resume(path, spp=SPP), alight.render("cornell-box", spp=SPP, **RENDER))
