"""Mutated scenes become a picture or a message: never another exception, a crash or a hang."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from tests.formats.mutate import Mutation, mutations
from tests.fuzz.extremes import extremes
from tests.fuzz.feature_files import features
from tests.fuzz.feature_files import write_files as write_features
from tests.fuzz.in_the_twin import Outcome, serve
from tests.fuzz.materialx_files import copy_picture, materialx_files
from tests.fuzz.mesh_files import meshes
from tests.fuzz.mitsuba_files import copy_files, mitsuba_files
from tests.fuzz.model_files import copy_models, models
from tests.fuzz.pbrt_files import pbrt_files, write_files
from tests.fuzz.pictures import pictures
from tests.fuzz.usd_files import copy_pictures, usd_files
from tests.portion import portion

#: Processor time that one scene may take; the slowest takes less than a tenth of it.
MOST_SECONDS = 10.0
#: After this long on the clock a scene hangs. (Other work may slow the machine down.)
HANGS_AFTER = 120.0

#: Cases that share a process with those of other tests.
FEW = 200


class Renderer:
    """A process that renders for all tests here, and is replaced when it hangs or dies."""

    process = None

    def outcome(self, case: Mutation, folder: Path) -> Outcome:
        """What became of a case."""
        if self.process is None:
            context = multiprocessing.get_context("spawn")
            self.ours, theirs = context.Pipe()
            self.process = context.Process(target=serve, args=(theirs,), daemon=True)
            self.process.start()
            theirs.close()
        self.ours.send((case, folder))
        try:
            if self.ours.poll(HANGS_AFTER):
                return self.ours.recv()
            found = f"still running after {HANGS_AFTER:g} s"
        except EOFError:
            self.process.join()
            found = f"the process died with exit code {self.process.exitcode}"
        self.kill()
        return Outcome("failed", found, 0.0)

    def kill(self) -> None:
        """End the process, if there is one."""
        if self.process is not None:
            self.process.kill()
            self.process.join()
            self.process = None


@pytest.fixture(scope="module")
def renderer() -> Iterator[Renderer]:
    """Started by the first case: all tests share the seconds that imports take."""
    renderer = Renderer()
    yield renderer
    renderer.kill()


def check(renderer: Renderer, cases: Iterable[Mutation], folder: Path) -> list[Outcome]:
    """Render mutated scenes; all that went wrong is told at once."""
    cases = list(cases)
    if len(cases) > FEW:
        # What so many leave in memory is theirs alone.
        renderer.kill()
    results = [renderer.outcome(case, folder) for case in cases]
    if len(cases) > FEW:
        renderer.kill()
    wrong = [
        f"case {i}: {r.kind}, {r.seconds:.1f} s: {r.text[:300]}"
        for i, r in enumerate(results)
        if r.kind == "failed" or r.seconds > MOST_SECONDS
    ]
    assert not wrong, "\n".join(wrong)
    assert len(results) == len(cases)
    # Both ways must be walked, or the mutations are too weak or too strong.
    kinds = [r.kind for r in results]
    assert min(kinds.count("rendered"), kinds.count("refused")) >= len(cases) // 10
    # What is not finite is counted, but there is hardly any.
    assert sum(r.invalid > 0 for r in results) <= len(cases) // 50
    return results


def test_mutated_scenes_render_or_are_refused(renderer, tmp_path):
    check(renderer, mutations(seed=3, n=100), tmp_path)


def test_scenes_with_extreme_numbers_render_or_are_refused(renderer, tmp_path):
    check(renderer, extremes(seed=3, n=40), tmp_path)


def test_scenes_with_mutated_pictures_render_or_are_refused(renderer, tmp_path):
    check(renderer, pictures(seed=3, n=100), tmp_path)


def test_scenes_with_mutated_meshes_render_or_are_refused(renderer, tmp_path):
    check(renderer, meshes(seed=3, n=100), tmp_path)


def test_mutated_lights_motions_and_media_render_or_are_refused(renderer, tmp_path):
    write_features(tmp_path)
    check(renderer, features(seed=3, n=50), tmp_path)


def test_mutated_files_of_mitsuba_render_or_are_refused(renderer, tmp_path):
    copy_files(tmp_path)
    check(renderer, mitsuba_files(seed=3, n=100), tmp_path)


def test_mutated_gltf_and_obj_files_render_or_are_refused(renderer, tmp_path):
    copy_models(tmp_path)
    check(renderer, models(seed=3, n=50), tmp_path)


@pytest.mark.proofs
def test_three_thousand_mutated_gltf_and_obj_files_render_or_are_refused(renderer, tmp_path):
    copy_models(tmp_path)
    check(renderer, portion(models(seed=4, n=3000)), tmp_path)


def test_mutated_files_of_pbrt_render_or_are_refused(renderer, tmp_path):
    write_files(tmp_path)
    check(renderer, pbrt_files(seed=3, n=60), tmp_path)


def test_mutated_files_of_openusd_render_or_are_refused(renderer, tmp_path):
    pytest.importorskip("pxr")
    copy_pictures(tmp_path)
    check(renderer, usd_files(seed=3, n=60), tmp_path)


def test_mutated_documents_of_materialx_render_or_are_refused(renderer, tmp_path):
    copy_picture(tmp_path)
    check(renderer, materialx_files(seed=3, n=40), tmp_path)


@pytest.mark.proofs
def test_six_hundred_mutated_documents_of_materialx_render_or_are_refused(renderer, tmp_path):
    copy_picture(tmp_path)
    check(renderer, portion(materialx_files(seed=4, n=600)), tmp_path)


@pytest.mark.proofs
def test_three_hundred_mutated_files_of_openusd_render_or_are_refused(renderer, tmp_path):
    pytest.importorskip("pxr")
    copy_pictures(tmp_path)
    check(renderer, portion(usd_files(seed=4, n=300)), tmp_path)


@pytest.mark.proofs
def test_two_thousand_mutated_scenes_render_or_are_refused(renderer, tmp_path):
    check(renderer, portion(mutations(seed=4, n=2000)), tmp_path)


@pytest.mark.proofs
def test_two_thousand_scenes_with_extreme_numbers_render_or_are_refused(renderer, tmp_path):
    check(renderer, portion(extremes(seed=4, n=2000)), tmp_path)


@pytest.mark.proofs
def test_two_thousand_scenes_with_mutated_pictures_render_or_are_refused(renderer, tmp_path):
    check(renderer, portion(pictures(seed=4, n=2000)), tmp_path)


@pytest.mark.proofs
def test_two_thousand_scenes_with_mutated_meshes_render_or_are_refused(renderer, tmp_path):
    check(renderer, portion(meshes(seed=4, n=2000)), tmp_path)


@pytest.mark.proofs
def test_one_thousand_mutated_lights_motions_and_media_render_or_are_refused(renderer, tmp_path):
    write_features(tmp_path)
    check(renderer, portion(features(seed=4, n=1000)), tmp_path)


@pytest.mark.proofs
def test_two_thousand_mutated_files_of_mitsuba_render_or_are_refused(renderer, tmp_path):
    copy_files(tmp_path)
    check(renderer, portion(mitsuba_files(seed=4, n=2000)), tmp_path)


@pytest.mark.proofs
def test_six_hundred_mutated_files_of_pbrt_render_or_are_refused(renderer, tmp_path):
    write_files(tmp_path)
    check(renderer, portion(pbrt_files(seed=4, n=600)), tmp_path)
