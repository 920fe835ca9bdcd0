"""The sufficient condition of backstepping, looked at along a run."""

from typing import Any

import numpy as np

from cabledrive.control.backstepping import stability_margin
from cabledrive.control.numbers import BACKSTEPPING
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import Array

INSTANTS = 40


def margin_words(loop: Loop, estimates: Array, states: Array) -> dict[str, Any]:
    """Smallest eigenvalue of D_z of (6.100) over the states and estimates that a run met.

    ``estimates``, shape (samples, p); ``states``, shape (samples, 2n): angles and speeds as the law took
    them.
    Returns empty for other laws and for runs without a sound sample.
    """
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
