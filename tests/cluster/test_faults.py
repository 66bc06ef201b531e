"""The campaign of faults: every film has the bits of one process, and no render hangs."""

import pytest

from tests.cluster.faults import FAULTS, run


@pytest.mark.proofs
@pytest.mark.timeout(3600)
def test_no_fault_changes_a_bit(tmp_path):
    told = run(tmp_path, 3 * len(FAULTS), seed=0)
    assert told["differing"] == []
    assert told["faults"] == dict.fromkeys(FAULTS, 3)
