r"""What a number of runs can claim: one-sided Clopper-Pearson, 95 %.

With k of n runs inside, the share of all plants inside is at least

.. math:: p_L = B^{-1}(0.05;\ k,\ n - k + 1)

with 95 % confidence, B the beta distribution; 0 where k = 0. C. J. Clopper and E. S. Pearson, Biometrika 26,
404-413, 1934. Only the plants that the runs were drawn from are meant.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from scipy.stats import beta

CONFIDENCE = 0.95
ENOUGH = {"lumped": 0.99, "carriage": 0.99, "cable": 0.95}
"""Share of the plants that must keep within the goal, by the kind of plant."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReachedError:
    """An error that a share of the plants keeps below.

    Attributes
    ----------
    error : float or None
        [rad] or [m]; None: too many runs ended early to name one.
    share : float
        Lower limit of the share that keeps below it; the share that is asked for, or what the number of runs
        can show where it is too small for that.
    confidence : float
    """

    error: float | None
    share: float
    confidence: float = CONFIDENCE


def share_low(inside: int, runs: int) -> float:
    """Lower limit of the share of plants inside, with `CONFIDENCE`."""
    if inside == 0:
        return 0.0
    return float(beta.ppf(1.0 - CONFIDENCE, inside, runs - inside + 1))


def misses_allowed(runs: int, share: float) -> int:
    """Most runs that may miss while `share_low` keeps a share.

    Returns -1: so few runs cannot show the share, even if none misses.
    """
    misses = -1
    while misses + 1 < runs and share_low(runs - misses - 1, runs) >= share:
        misses += 1
    return misses


def reached_error(lasting: Sequence[float], runs: int, share: float) -> ReachedError:
    """The smallest error below which runs show that a share of the plants stays.

    ``lasting``: largest error of each run that lasted, ascending; ``runs``: all of them, at least 1.
    Returns with too few runs for the share, the largest error and the share that so many runs can show.
    """
    misses = misses_allowed(runs, share)
    shown = share
    if misses < 0:
        misses, shown = 0, share_low(runs, runs)
    place = runs - misses - 1
    return ReachedError(error=lasting[place] if place < len(lasting) else None, share=shown)
