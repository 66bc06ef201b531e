"""Mutated scenes become a picture or a message: never another exception, a crash or a hang."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.fuzz.in_the_twin import Outcome, serve
from tests.scene.mutate import mutations

#: Processor time that one scene may take; the slowest takes less than a tenth of it.
MOST_SECONDS = 10.0
#: After this long on the clock a scene hangs. (Other work may slow the machine down.)
HANGS_AFTER = 120.0


def outcomes(cases, folder: Path) -> Iterator[Outcome]:
    """What became of each case, from a process that is replaced when it hangs or dies."""
    context = multiprocessing.get_context("spawn")
    process = None
    try:
        for case in cases:
            if process is None:
                ours, theirs = context.Pipe()
                process = context.Process(target=serve, args=(theirs, str(folder)), daemon=True)
                process.start()
                theirs.close()
            ours.send(case)
            try:
                if ours.poll(HANGS_AFTER):
                    yield ours.recv()
                    continue
                found = f"still running after {HANGS_AFTER:g} s"
            except EOFError:
                process.join()
                found = f"the process died with exit code {process.exitcode}"
            process.kill()
            process = None
            yield Outcome("failed", found, 0.0)
        if process is not None:
            ours.send(None)
            process.join()
            process = None
    finally:
        if process is not None:
            process.kill()


def check(seed: int, n: int, folder: Path) -> None:
    """Render `n` mutated scenes; all that went wrong is told at once."""
    cases = list(mutations(seed, n))
    results = list(outcomes(cases, folder))
    wrong = [
        f"case {i} of seed {seed}: {r.kind}, {r.seconds:.1f} s: {r.text[:300]}"
        for i, r in enumerate(results)
        if r.kind == "failed" or r.seconds > MOST_SECONDS
    ]
    assert not wrong, "\n".join(wrong)
    kinds = [r.kind for r in results]
    # Both ways must be walked, or the mutations are too weak or too strong.
    assert kinds.count("rendered") >= n // 10
    assert kinds.count("refused") >= n // 2
    # What is not finite is counted, but there is hardly any.
    assert sum(r.invalid > 0 for r in results) <= n // 100


def test_mutated_scenes_render_or_are_refused(tmp_path):
    check(seed=3, n=200, folder=tmp_path)


@pytest.mark.proofs
def test_two_thousand_mutated_scenes_render_or_are_refused(tmp_path):
    check(seed=4, n=2000, folder=tmp_path)
