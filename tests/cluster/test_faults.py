"""The campaign of faults, each kind once: every film has the bits of one process, and none hangs.

``python -m tests.cluster.faults`` runs any number of them.
"""

import pytest

from tests.cluster.faults import run
from tests.portion import portion


@pytest.mark.proofs
@pytest.mark.timeout(1200)
def test_no_fault_changes_a_bit(tmp_path):
    told = run(tmp_path, lambda kinds: portion(range(kinds)), seed=0)
    assert told["differing"] == []
    assert set(told["faults"].values()) == {1}
