"""Mutated scenes load or are refused in words; nothing crashes, hangs or takes the memory."""

import importlib.util
import time
from pathlib import Path

import pytest

from alight.core.errors import SceneError
from alight.formats import dumps, loads
from alight.scene import flatten

_SPEC = importlib.util.spec_from_file_location("mutate", Path(__file__).with_name("mutate.py"))
mutate = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(mutate)


def outcomes(seed, n, folder):
    """Load `n` mutated scenes; count those that load and those that are refused."""
    loaded = refused = 0
    slowest = 0.0
    for case in mutate.mutations(seed, n):
        (folder / case.mesh_name).write_bytes(case.mesh)
        start = time.perf_counter()
        try:
            scene = loads(case.text, "scene.yaml", folder)
            flatten(scene)
            assert loads(dumps(scene), "again.yaml", folder) == scene
            loaded += 1
        except SceneError as error:
            assert all(issue.message and issue.place for issue in error.issues)
            refused += 1
        slowest = max(slowest, time.perf_counter() - start)
    return loaded, refused, slowest


def test_mutated_scenes_load_or_are_refused(tmp_path):
    loaded, refused, slowest = outcomes(seed=1, n=200, folder=tmp_path)
    assert loaded + refused == 200
    # Both ways must be walked, or the mutations are too weak or too strong.
    assert loaded >= 20
    assert refused >= 100
    assert slowest < 5.0


@pytest.mark.proofs
def test_two_thousand_mutated_scenes_load_or_are_refused(tmp_path):
    loaded, refused, slowest = outcomes(seed=2, n=2000, folder=tmp_path)
    assert loaded + refused == 2000
    assert slowest < 5.0


def test_the_same_seed_gives_the_same_cases():
    assert list(mutate.mutations(7, 20)) == list(mutate.mutations(7, 20))
    assert list(mutate.mutations(7, 20)) != list(mutate.mutations(8, 20))
