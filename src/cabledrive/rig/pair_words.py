"""What a run of two motors on one shaft says of its flanks, its motors and what is left at rest."""

from typing import Any

import numpy as np

from cabledrive.rig.closed_loop.chain_kernels import LEAST
from cabledrive.rig.closed_loop.loop import Loop, Run
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.setting import DEGREE, Motion

LAST_SHARE = 0.5
"""Part of the last dwell in which the swing at rest is measured."""


def rest_words(loop: Loop, error: Array, motion: Motion) -> dict[str, Any]:
    """Swing of the load at the end of the last dwell; of a plant with backlash only, where a loop may cycle.

    ``error``, shape (samples,): of the load [rad].
    Returns nothing without backlash.
    """
    if loop.backlash <= 0.0 or loop.own_plant is not None:
        return {}
    last = round(LAST_SHARE * motion.dwell / loop.rig.interval)
    if len(error) < len(loop.target) or last < 2:
        reason = "the run did not come to its last dwell" if last >= 2 else "the motion has no dwell"
        return {"rest_swing_deg": None, "rest_swing_counts": None, "rest_swing_reason": reason}
    swing, count = float(np.ptp(error[-last:])), float(loop.rig.counts[-1]) / loop.gear
    counts = swing / count if count > 0.0 else None
    return {
        "rest_swing_deg": swing / DEGREE,
        "rest_swing_counts": counts,
        "limit_cycle": None if counts is None else counts > 1.0,
    }


def pair_words(loop: Loop, done: Run) -> dict[str, Any]:
    """Flanks and motors of a pair; nothing of a single motor."""
    pair = loop.pair
    if pair is None or done.flanks is None:
        return {}
    flanks = done.flanks[: done.ended]
    opened = int(done.state.summary[10])
    first = 2 * loop.chain.size + 1 + LEAST
    least = np.asarray(done.state.x[first : first + 2])
    limit = pair.law.limit
    taken = np.abs(flanks[:, 2:4]).max(axis=0, initial=0.0)
    said: dict[str, Any] = {
        "preload": pair.law.preload,
        "backlash": pair.backlash,
        "torque_limit": limit if np.isfinite(limit) else None,
        "flanks_closed": bool((least > 0.0).all()),
        "flank_open_samples": opened,
        "least_flank_torque": [float(value) for value in least],
        "motor_peak_torque": [float(value) for value in taken],
        "flank_observer_error": float(np.abs(flanks[:, 4:6] - flanks[:, :2]).max(initial=0.0)),
        "assumptions": [
            "both gears and motors are alike within what is drawn; friction of a mesh does not grow with its "
            "preload",
            "the preload was on when the encoders were switched on; what friction held then is not known",
        ],
    }
    if not said["flanks_closed"]:
        share, short = opened / max(len(flanks), 1), _short(pair.law.limit, flanks)
        said["reason"] = (
            f"a flank was open at {share:.2%} of the samples: half the joint's torque exceeded the preload"
            + (", and a motor was at its torque limit" if short else ": raise the preload, or move slower")
        )
    return {"pair": said}


def _short(limit: float, flanks: Array) -> bool:
    """Whether a motor was at its limit."""
    return bool((np.abs(flanks[:, 2:4]) >= limit * (1.0 - 1e-9)).any())
