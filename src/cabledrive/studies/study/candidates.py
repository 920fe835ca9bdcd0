"""What each law of a study reached under the one acceptance test, of loads and of carriages alike."""

from collections.abc import Sequence
from dataclasses import dataclass

from cabledrive.studies.study.confidence import ENOUGH, ReachedError, misses_allowed, reached_error, share_low


@dataclass(frozen=True, slots=True, kw_only=True)
class LawScore:
    """One law on many plants.

    Attributes
    ----------
    controller : str
    setting : str
        In words.
    plant : {"lumped", "carriage", "cable"}
    runs, failed : int
        Runs made, and those that ended before their time.
    worst : float or None
        Largest error of the runs that lasted [rad] or [m]; None: there is none.
    reached : ReachedError or None
        None: no runs were made.
    share, share_low : float or None
        Of all runs inside the goal, and its lower limit with 95 % confidence; None without a goal or runs.
    holds : bool or None
        Whether `share_low` is enough; None without a goal, or where not all runs were made.
    reason : str
        Why runs were not made.
    """

    controller: str
    setting: str
    plant: str
    runs: int
    failed: int
    worst: float | None
    reached: ReachedError | None
    share: float | None
    share_low: float | None
    holds: bool | None
    reason: str


def score(
    controller: str,
    setting: str,
    plant: str,
    lasting: Sequence[float],
    runs: int,
    goal: float | None,
    reason: str = "",
) -> LawScore:
    """What many runs of a law say.

    ``plant``, {"lumped", "carriage", "cable"}; ``lasting``: largest error of each run that lasted, ascending
    [rad] or [m]; ``runs``: all of them; 0: none were made; ``goal``: largest error allowed [rad] or [m];
    ``reason``: why no runs were made.
    """
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
    """Whether a law has missed the goal so often that the rest of the runs cannot mend it.

    ``misses``: so far; ``runs``: that are planned; ``plant``, {"lumped", "carriage", "cable"}.
    """
    return misses > max(misses_allowed(runs, ENOUGH[plant]), 0)


def closest(scores: Sequence[LawScore]) -> LawScore | None:
    """The law that reached the smallest error; with a goal the largest share decides first.

    ``scores``: simplest law first.
    Returns none: no law has runs.
    """
    made = [one for one in scores if one.runs]
    if not made:
        return None

    def rank(one: LawScore) -> tuple[float, float]:
        error = one.reached.error if one.reached else None
        return -(one.share or 0.0), float("inf") if error is None else error

    return min(made, key=rank)
