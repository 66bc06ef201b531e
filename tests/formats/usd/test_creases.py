"""Creases of OpenUSD: chains of edges, with one sharpness each, or one an edge."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("pxr")

from alight.formats.usd.subdivision import _creases

#: Sharper edges than this stay sharp at every level.
SHARPEST = 10.0


def creases(lengths, indices, sharpness):
    """What is read of a mesh that says this."""
    mesh = SimpleNamespace(
        GetCreaseLengthsAttr=lambda: lengths,
        GetCreaseIndicesAttr=lambda: indices,
        GetCreaseSharpnessesAttr=lambda: sharpness,
    )
    return _creases(SimpleNamespace(value=lambda attribute, plain: attribute), mesh)


@pytest.mark.parametrize("by_edge", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_each_edge_has_its_own_sharpness_or_that_of_its_chain(seed, by_edge):
    rng = np.random.default_rng(seed)
    chains = [rng.permutation(30)[:n].tolist() for n in (2, 4, 3, 5)]
    edges = [pair for chain in chains for pair in itertools.pairwise(chain)]
    of_chains = rng.uniform(0.0, 12.0, len(chains))
    of_edges = [s for s, chain in zip(of_chains, chains, strict=True) for _ in chain[1:]]
    said = of_chains
    if by_edge:
        said = of_edges = rng.uniform(0.0, 12.0, len(edges))
    found, sharpness = creases([*map(len, chains)], [*itertools.chain(*chains)], list(said))
    assert found.tolist() == [list(map(int, edge)) for edge in edges]
    np.testing.assert_allclose(sharpness, np.minimum(of_edges, SHARPEST))


def test_what_is_not_said_is_sharp():
    found, sharpness = creases([3, 2], [0, 1, 2, 4, 5], [3.0])
    assert found.tolist() == [[0, 1], [1, 2], [4, 5]]
    assert sharpness.tolist() == [3.0, 3.0, SHARPEST]
    found, sharpness = creases([], [], [])
    assert found.shape == (0, 2) and not len(sharpness)
