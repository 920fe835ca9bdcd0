"""Whatever has happened to a file, it is taken, or refused in one line, within a time and a memory."""

import sys

import pytest

from attack.damaged import BYTES, KINDS, attack

COUNT = 5000


@pytest.mark.verify
@pytest.mark.skipif(sys.platform != "linux", reason="needs fork and limits of memory")
@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_file_ends_with_status_0_2_or_3_and_one_line(kind, measured):
    outcomes, bad, largest = attack(kind, 1, COUNT)
    measured(
        f"{COUNT} damaged files of kind {kind} by status: {dict(sorted(outcomes.items()))}, "
        f"at most {largest / 2**20:.0f} MiB"
    )
    assert not bad, "\n".join(bad[:20])
    assert outcomes[0] > KINDS[kind].still_valid * COUNT, outcomes
    assert outcomes[2] > 0.2 * COUNT, outcomes
    assert largest < BYTES
