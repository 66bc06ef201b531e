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

#: Processor time that one scene may take; the slowest takes less than a tenth of it.
MOST_SECONDS = 10.0
#: After this long on the clock a scene hangs. (Other work may slow the machine down.)
HANGS_AFTER = 120.0


def outcomes(cases: list[Mutation], folder: Path) -> Iterator[Outcome]:
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


def check(cases: Iterable[Mutation], folder: Path) -> list[Outcome]:
    """Render mutated scenes; all that went wrong is told at once."""
    cases = list(cases)
    results = list(outcomes(cases, folder))
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


def test_mutated_scenes_render_or_are_refused(tmp_path):
    check(mutations(seed=3, n=100), tmp_path)


def test_scenes_with_extreme_numbers_render_or_are_refused(tmp_path):
    check(extremes(seed=3, n=100), tmp_path)


def test_scenes_with_mutated_pictures_render_or_are_refused(tmp_path):
    check(pictures(seed=3, n=100), tmp_path)


def test_scenes_with_mutated_meshes_render_or_are_refused(tmp_path):
    check(meshes(seed=3, n=100), tmp_path)


def test_mutated_lights_motions_and_media_render_or_are_refused(tmp_path):
    write_features(tmp_path)
    check(features(seed=3, n=50), tmp_path)


def test_mutated_files_of_mitsuba_render_or_are_refused(tmp_path):
    copy_files(tmp_path)
    check(mitsuba_files(seed=3, n=100), tmp_path)


def test_mutated_gltf_and_obj_files_render_or_are_refused(tmp_path):
    copy_models(tmp_path)
    check(models(seed=3, n=50), tmp_path)


@pytest.mark.proofs
def test_three_thousand_mutated_gltf_and_obj_files_render_or_are_refused(tmp_path):
    copy_models(tmp_path)
    check(models(seed=4, n=3000), tmp_path)


def test_mutated_files_of_pbrt_render_or_are_refused(tmp_path):
    write_files(tmp_path)
    check(pbrt_files(seed=3, n=60), tmp_path)


def test_mutated_files_of_openusd_render_or_are_refused(tmp_path):
    pytest.importorskip("pxr")
    copy_pictures(tmp_path)
    check(usd_files(seed=3, n=60), tmp_path)


def test_mutated_documents_of_materialx_render_or_are_refused(tmp_path):
    copy_picture(tmp_path)
    check(materialx_files(seed=3, n=40), tmp_path)


@pytest.mark.proofs
def test_six_hundred_mutated_documents_of_materialx_render_or_are_refused(tmp_path):
    copy_picture(tmp_path)
    check(materialx_files(seed=4, n=600), tmp_path)


@pytest.mark.proofs
def test_three_hundred_mutated_files_of_openusd_render_or_are_refused(tmp_path):
    pytest.importorskip("pxr")
    copy_pictures(tmp_path)
    check(usd_files(seed=4, n=300), tmp_path)


@pytest.mark.proofs
def test_two_thousand_mutated_scenes_render_or_are_refused(tmp_path):
    check(mutations(seed=4, n=2000), tmp_path)


@pytest.mark.proofs
def test_two_thousand_scenes_with_extreme_numbers_render_or_are_refused(tmp_path):
    check(extremes(seed=4, n=2000), tmp_path)


@pytest.mark.proofs
def test_two_thousand_scenes_with_mutated_pictures_render_or_are_refused(tmp_path):
    check(pictures(seed=4, n=2000), tmp_path)


@pytest.mark.proofs
def test_two_thousand_scenes_with_mutated_meshes_render_or_are_refused(tmp_path):
    check(meshes(seed=4, n=2000), tmp_path)


@pytest.mark.proofs
def test_one_thousand_mutated_lights_motions_and_media_render_or_are_refused(tmp_path):
    write_features(tmp_path)
    check(features(seed=4, n=1000), tmp_path)


@pytest.mark.proofs
def test_two_thousand_mutated_files_of_mitsuba_render_or_are_refused(tmp_path):
    copy_files(tmp_path)
    check(mitsuba_files(seed=4, n=2000), tmp_path)


@pytest.mark.proofs
def test_six_hundred_mutated_files_of_pbrt_render_or_are_refused(tmp_path):
    write_files(tmp_path)
    check(pbrt_files(seed=4, n=600), tmp_path)
