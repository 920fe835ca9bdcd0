"""Whatever has happened to a log, it is read or refused, within a time and a memory."""

import pytest

from attack import ledger
from attack.logs import BYTES, attack


@pytest.mark.parametrize(("seed", "count"), [(0, 250), pytest.param(1, 30_000, marks=pytest.mark.verify)])
def test_a_damaged_log_is_read_or_refused_in_one_line(seed, count, measured):
    outcomes, bad, peak = attack(seed, count)
    ledger.note("logs", seed, outcomes)
    measured(f"{count} damaged logs: {dict(outcomes)}, at most {peak / 2**20:.0f} MiB")
    assert not bad, "\n".join(bad[:20])
    assert outcomes["read"] > 0.05 * count, outcomes
    assert outcomes["refused"] > 0.2 * count, outcomes
    assert peak < BYTES, peak
