"""Errors of many runs of which some ended early: a run that ended has none, and counts as missed."""

from collections.abc import Sequence
from math import ceil


def quantile_of_all(lasting: Sequence[float], runs: int, share: float) -> float | None:
    """Error that a share of all runs kept below, those that ended early among them.

    ``lasting``: largest error of each run that lasted, ascending; ``runs``: all of them; ``share``: above 0,
    at most 1.
    Returns none where too many ended early, or none was made.
    """
    needed = max(ceil(share * runs - 1e-9), 1)
    return lasting[needed - 1] if needed <= len(lasting) else None
