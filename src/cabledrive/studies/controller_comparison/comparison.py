"""What a comparison of controllers found: one row a law, in the order of their rank."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cabledrive.parameters.terminal import ResultCard
from cabledrive.rig.ranking.margins import Margins
from cabledrive.rig.ranking.scores import Scores, rank
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study.confidence import share_low


@dataclass(frozen=True, slots=True, kw_only=True)
class TuningRecord:
    """How a law was tuned.

    Attributes
    ----------
    name : str
    bandwidth : float or None
        [Hz]; None: no setting keeps the limits.
    filter : str
    disk, gain, phase, ripple : float or None
        Of `cabledrive.rig.ranking.margins.Margins`; None: infinite, or no setting.
    seconds : float
        What the tuning took [s].
    reason : str
        Why there is no setting; empty where there is one.
    """

    name: str
    bandwidth: float | None
    filter: str
    disk: float | None
    gain: float | None
    phase: float | None
    ripple: float | None
    seconds: float
    reason: str = ""


def recorded(name: str, bandwidth: float, words: str, margins: Margins, seconds: float) -> TuningRecord:
    """A tuned law as plain data."""
    return TuningRecord(
        name=name,
        bandwidth=bandwidth,
        filter=words,
        disk=_finite(margins.disk),
        gain=_finite(margins.gain),
        phase=_finite(margins.phase),
        ripple=_finite(margins.ripple),
        seconds=seconds,
    )


def untuned(name: str, reason: str, seconds: float = 0.0) -> TuningRecord:
    """A law without a setting, and why."""
    nothing = dict.fromkeys(("bandwidth", "disk", "gain", "phase", "ripple"))
    return TuningRecord(name=name, filter="", seconds=seconds, reason=reason, **nothing)


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedLaw:
    """One law of a comparison.

    Attributes
    ----------
    tuning : TuningRecord
    scores : Scores or None
        None: it could not be tuned.
    learns : bool
        Whether its first pulse is for learning, and the error counts after it.
    """

    tuning: TuningRecord
    scores: Scores | None
    learns: bool

    def rank(self, goal: float) -> tuple[bool, float, float]:
        """Smaller is better; a law without runs comes last."""
        if self.scores is None:
            return True, 1.0, float("inf")
        return (False, *rank(self.scores, goal, learns=self.learns))


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Comparison(ResultCard):
    """Controllers side by side, the best first.

    Attributes
    ----------
    summary : dict
        What `cabledrive compare --json` prints.
    laws : tuple of ComparedLaw
    """

    summary: dict[str, Any]
    laws: tuple[ComparedLaw, ...]

    def _card(self) -> list[tuple[str, str]]:
        rows = []
        for one in self.summary["controllers"]:
            worst, median = one["worst_deg"], one["median_deg"]
            words = one["reason"] if worst is None else f"median {median:.4f}, worst {worst:.4f} deg"
            rows.append((one["name"], words))
        return [("Comparison", f"{self.summary['draws']} plants"), *rows]


def law_words(law: ComparedLaw, goal: float) -> dict[str, Any]:
    """One row of the answer: errors in degrees, torques in N m, margins.

    ``goal``: largest error allowed [rad].
    """
    tuning, scores = law.tuning, law.scores
    words: dict[str, Any] = {
        "name": tuning.name,
        "bandwidth_hz": tuning.bandwidth,
        "filter": tuning.filter,
        "learns": law.learns,
        "disk_margin": tuning.disk,
        "gain_margin": tuning.gain,
        "phase_margin_deg": None if tuning.phase is None else tuning.phase / DEGREE,
        "torque_ripple": tuning.ripple,
        "tuning_seconds": tuning.seconds,
        "reason": tuning.reason,
    }
    return words | (_no_runs() if scores is None else _run_words(law, scores, goal))


def _no_runs() -> dict[str, Any]:
    names = (
        *("worst_deg", "median_deg", "error_99_deg", "worst_whole_run_deg", "worst_later_deg"),
        *("share_within", "share_low", "peak_torque", "median_torque"),
    )
    return {"runs": 0, "failed": 0, "saturated_runs": 0} | dict.fromkeys(names)


def _run_words(law: ComparedLaw, scores: Scores, goal: float) -> dict[str, Any]:
    failed = np.array(scores.failed)
    errors = np.array(scores.later if law.learns else scores.peaks)
    lasting = errors[~failed] / DEGREE
    inside, runs = int(np.count_nonzero((errors <= goal) & ~failed)), len(errors)
    whole, later = (np.array(values)[~failed] / DEGREE for values in (scores.peaks, scores.later))
    some = len(lasting) > 0
    return {
        "runs": runs,
        "failed": int(failed.sum()),
        "worst_deg": float(lasting.max()) if some else None,
        "median_deg": float(np.median(lasting)) if some else None,
        "error_99_deg": float(np.quantile(lasting, 0.99)) if some else None,
        "worst_whole_run_deg": float(whole.max()) if some else None,
        "worst_later_deg": float(later.max()) if some else None,
        "share_within": inside / runs,
        "share_low": share_low(inside, runs),
        "peak_torque": float(np.max(scores.torques)),
        "median_torque": float(np.median(scores.torques)),
        "saturated_runs": int(np.count_nonzero(np.array(scores.saturated) > 0.0)),
    }
