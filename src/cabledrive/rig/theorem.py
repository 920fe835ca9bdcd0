"""The bound of the theorem along a run, and the sufficient condition of backstepping."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cabledrive.control.backstepping import stability_margin
from cabledrive.control.bound import (
    ErrorBound,
    SlidingResidual,
    error_bound,
    regressor_deviation,
    sliding_residual,
)
from cabledrive.control.numbers import BACKSTEPPING, DARC, DESIRED, LEARNING, NOMINAL, SCHEDULED
from cabledrive.parameters import Drive
from cabledrive.rig.assumptions import true_parameters
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import ESTIMATES, Array
from cabledrive.rig.law_checks import LearningCheck, check_learning, check_scheduled
from cabledrive.rig.laws.controllers import place
from cabledrive.rig.run_facts import disturbance_bound
from cabledrive.rig.setting import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TheoremCheck:
    """The bound of the theorem along a run, and the sources of the error beside it, at the first shaft."""

    bound: ErrorBound
    residual: SlidingResidual

    @property
    def beyond(self) -> tuple[str, ...]:
        """Named with the departures: nothing here."""
        return ()

    @property
    def used(self) -> float:
        """Largest share of the tube that the sources of the error use; above 1 an assumption fails."""
        return self._share(self.residual.total)

    @property
    def unmatched_part(self) -> float:
        """Largest share of the tube by what no torque of the motor makes."""
        return self._share(np.abs(self.residual.unmatched))

    def _share(self, part: Array) -> float:
        tube = self.bound.tube
        inside = tube > 0.0
        share = float(np.max(part[inside] / tube[inside], initial=0.0))
        return share if np.isfinite(share) else float("inf")


def check_theorem(loop: Loop, actual: Drive, log: Array) -> TheoremCheck | LearningCheck | None:
    """Bound of the theorem and sources of the error along a run; None for laws that have no bound here."""
    if loop.controller.law.kind == LEARNING:
        return check_learning(loop, log)
    if loop.controller.law.kind == SCHEDULED and loop.controller.believed is not None:
        return check_scheduled(loop, loop.controller.believed, log)
    bound = bound_along(loop, log)
    if bound is None:
        return None
    made = loop.controller
    assert made.flat is not None
    assert made.bandwidth is not None
    nominal = float(made.law.learning[NOMINAL, 0])
    share = float(true_parameters(loop, actual)[0]) / nominal if nominal > 0.0 else 1.0
    residual = sliding_residual(
        made.law,
        made.flat,
        made.bandwidth,
        share * made.law.mu,
        law_states(loop, log),
        made.reference[: len(log)],
        log[:, loop.chain.size - 1] - loop.target[: len(log)],
        loop.rig.interval,
    )
    return TheoremCheck(bound=bound, residual=residual)


def bound_along(loop: Loop, log: Array) -> ErrorBound | None:
    """Bound of the theorem along a run, actuator and friction at rest counted; None for laws without one."""
    made, n = loop.controller, loop.chain.size
    if made.law.kind != DARC or made.bandwidth is None or made.flat is None or len(log) < 2:
        return None
    column = 2 * n + 1 + len(loop.rig.encoders)
    start = column + 3 + ESTIMATES
    delta = disturbance_bound(made.law, log[:, 2 * n], log[:, column])
    deviation = None
    if made.law.scalars[DESIRED]:
        deviation = regressor_deviation(made.law, law_states(loop, log), made.reference[: len(log)])
    return error_bound(
        made.law,
        made.bandwidth,
        log[:, start : start + made.law.learning.shape[1]],
        delta,
        loop.rig.interval,
        made.flat.time_constants,
        deviation,
    )


def law_states(loop: Loop, log: Array) -> Array:
    """True angles, then speeds, of the inertias that a law takes, shape (samples, 2n)."""
    places = [place(loop.chain, shaft) for shaft in loop.controller.shafts]
    return np.ascontiguousarray(log[:, [*places, *(loop.chain.size + i for i in places)]])


def bound_words(
    check: TheoremCheck | LearningCheck | None, error: Array, broken: list[str], gear: float
) -> dict[str, Any]:
    """The bound, whether the error [rad] kept it, and which assumptions of the theorem did not hold."""
    if check is None:
        return {
            "theory_bound_deg": None,
            "theory_bound_deg_reason": (
                "bounds are those of the laws of the chain, of the laws that learn the load and of the one "
                "that is told it, on the model that they are made for"
            ),
            "within_bound": None,
            "within_bound_reason": "no bound",
            "bound_used": None,
            "broken_assumptions": broken,
        }
    tube = check.bound.tube / gear
    printed = check.bound.printed / gear / DEGREE
    inside = bool(np.all(np.abs(error) <= tube + 1e-12))
    words: dict[str, Any] = {
        "theory_bound_deg": float(tube.max()) / DEGREE,
        **({"printed_norm_bound_deg": printed} if np.isfinite(printed) else {}),
        "within_bound": None if broken else inside,
        "inside_tube": inside,
        "bound_used": check.used if np.isfinite(check.used) else None,
        "broken_assumptions": broken,
    }
    if broken:
        words["within_bound_reason"] = "; ".join(broken)
    return words


INSTANTS = 40


def margin_words(loop: Loop, estimates: Array, states: Array) -> dict[str, Any]:
    """Smallest eigenvalue of D_z of (6.100) over states and estimates of a run; empty for other laws."""
    law = loop.controller.law
    sound = np.flatnonzero(np.all(np.isfinite(states), axis=1)) if states.size else np.zeros(0, dtype=int)
    if law.kind != BACKSTEPPING or not len(sound):
        return {}
    chosen = sound[:: max(1, len(sound) // INSTANTS)]
    reference = loop.controller.reference
    margins = [stability_margin(law, estimates[k], states[k], reference[k]) for k in chosen]
    return {
        "d_z": {
            "smallest": min(margins),
            "largest": max(margins),
            "positive_share": float(np.mean(np.array(margins) > 0.0)),
        }
    }
