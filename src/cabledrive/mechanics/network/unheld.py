"""Pulleys that the ropes at rest would turn: drums without a motor, pulleys that unequal ropes share."""

import numpy as np

from cabledrive.mechanics.network.motion import Motion
from cabledrive.mechanics.network.statics import Statics

_BALANCED = 1e-6
"""Torque over the largest of any rope at its rim that counts as none."""


def unheld_pulleys(motion: Motion, statics: Statics) -> dict[str, float]:
    """Torques of the ropes at rest that no motor, friction or other rope balances, by pulley [N m]."""
    drive = motion.drive
    driven = drive.driven or (0,)
    torques = np.zeros(len(drive.pulley))
    for span, forces in zip(drive.free_spans, statics.forces, strict=True):
        for place, contact, force in zip((span.start, span.end), span.contacts, forces, strict=True):
            if place.pulley is not None:
                arm = np.subtract(contact, place.centre)
                torques[place.pulley] += arm[0] * force[1] - arm[1] * force[0]
    largest = float(np.abs(statics.forces).max(initial=0.0))
    return {
        pulley.name: float(torque)
        for number, (pulley, torque) in enumerate(zip(drive.pulley, torques, strict=True))
        if motion.turns(number)
        and number not in driven
        and abs(torque) > pulley.coulomb_friction + _BALANCED * largest * pulley.radius
    }


def unheld_words(motion: Motion, statics: Statics) -> list[str]:
    """A warning for each pulley that nothing in the file holds at rest, such as the far drum of a line."""
    return [
        f"the ropes at rest turn pulley {name} by {abs(torque):.4g} N m and nothing in the file holds it: "
        "what is computed holds where a load does; else give it a motor, or fixed = true where a brake does"
        for name, torque in unheld_pulleys(motion, statics).items()
    ]
