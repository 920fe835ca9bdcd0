r"""What each law of a study reached under the one acceptance test, and what a number of runs can claim.

With k of n runs inside, the share of all plants inside is at least

.. math:: p_L = B^{-1}(0.05;\ k,\ n - k + 1)

with 95 % confidence, B the beta distribution; 0 where k = 0. C. J. Clopper and E. S. Pearson, Biometrika 26,
404-413, 1934. Only the plants that the runs were drawn from are meant.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

from scipy.stats import beta

CONFIDENCE = 0.95
ENOUGH = {"lumped": 0.99, "carriage": 0.99, "cable": 0.95}
"""Share of the plants that must keep within the goal, by the kind of plant."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReachedError:
    """An error that a share of the plants keeps below."""

    error: float | None  # [rad] or [m]; None: too many runs ended early to name one
    # lower limit of the share that keeps below it; the share that is asked for, or what the number of runs
    # can show where it is too small for that
    share: float
    confidence: float = CONFIDENCE


def share_low(inside: int, runs: int) -> float:
    """Lower limit of the share of plants inside, with `CONFIDENCE`."""
    if inside == 0:
        return 0.0
    return float(beta.ppf(1.0 - CONFIDENCE, inside, runs - inside + 1))


def misses_allowed(runs: int, share: float) -> int:
    """Most runs that may miss while `share_low` keeps a share; -1: so few runs cannot show it."""
    misses = -1
    while misses + 1 < runs and share_low(runs - misses - 1, runs) >= share:
        misses += 1
    return misses


def reached_error(lasting: Sequence[float], runs: int, share: float) -> ReachedError:
    """Error below which runs show that a share of plants stays, or the share that so many runs can show."""
    misses = misses_allowed(runs, share)
    shown = share
    if misses < 0:
        misses, shown = 0, share_low(runs, runs)
    place = runs - misses - 1
    return ReachedError(error=lasting[place] if place < len(lasting) else None, share=shown)


@dataclass(frozen=True, slots=True, kw_only=True)
class LawScore:
    """One law on many plants."""

    controller: str
    setting: str  # in words
    plant: str  # {"lumped", "carriage", "cable"}
    # runs, failed: runs made, and those that ended before their time
    runs: int
    failed: int
    worst: float | None  # largest error of the runs that lasted [rad] or [m]; None: there is none
    reached: ReachedError | None  # None: no runs were made
    # share, share_low: of all runs inside the goal, and its lower limit with 95 % confidence; None without a
    # goal or runs
    share: float | None
    share_low: float | None
    holds: bool | None  # whether `share_low` is enough; None without a goal, or where not all runs were made
    reason: str  # why runs were not made


def score(
    controller: str,
    setting: str,
    plant: str,
    lasting: Sequence[float],
    runs: int,
    goal: float | None,
    reason: str = "",
) -> LawScore:
    """What many runs of a law say; ``lasting``: their errors, ascending; ``goal``: [rad] or [m]."""
    share = low = None
    if goal is not None and runs:
        inside = sum(error <= goal for error in lasting)
        share, low = inside / runs, share_low(inside, runs)
    return LawScore(
        controller=controller,
        setting=setting,
        plant=plant,
        runs=runs,
        failed=runs - len(lasting),
        worst=lasting[-1] if lasting else None,
        reached=reached_error(lasting, runs, ENOUGH[plant]) if runs else None,
        share=share,
        share_low=low,
        holds=None if low is None else low >= ENOUGH[plant],
        reason=reason,
    )


def lost(misses: int, runs: int, plant: str) -> bool:
    """Whether a law has missed the goal so often that the rest of the runs cannot mend it."""
    return misses > max(misses_allowed(runs, ENOUGH[plant]), 0)


def closest(scores: Sequence[LawScore]) -> LawScore | None:
    """The law with the smallest error, with a goal the largest share first; None: no law has runs."""
    made = [one for one in scores if one.runs]
    if not made:
        return None

    def rank(one: LawScore) -> tuple[float, float]:
        error = one.reached.error if one.reached else None
        return -(one.share or 0.0), float("inf") if error is None else error

    return min(made, key=rank)


def quantile_of_all(lasting: Sequence[float], runs: int, share: float) -> float | None:
    """Error that a share of all runs kept below; None where too many ended early, or none was made."""
    needed = max(ceil(share * runs - 1e-9), 1)
    return lasting[needed - 1] if needed <= len(lasting) else None
