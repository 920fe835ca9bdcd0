"""The least bandwidth that a law without dampers tolerates on the drive it is made for."""

from collections.abc import Callable
from dataclasses import replace

from cabledrive.control.numbers import BACKSTEPPING
from cabledrive.parameters import InputRefused
from cabledrive.rig.laws.controllers import Controller, DesignSpec
from cabledrive.rig.laws.eigenvalues import closed_loop_poles

HIGHEST_HZ = 200.0


def check_least_bandwidth(
    law: Callable[[DesignSpec], Controller], made: Controller, spec: DesignSpec
) -> None:
    """Refuse a bandwidth below which a law of Model 4 is unstable on its own drive.

    Without the dampers in its model the law needs a stiffness of its own to outdo them. Other laws are let
    through: what they excite belongs to what is to be seen.

    ``law``: makes the controller of a spec.
    Raises `InputRefused` if the linear loop with true states is unstable and a higher bandwidth makes it
    stable.
    """
    hertz = spec.bandwidth
    one_of_them = made.law.kind == BACKSTEPPING or not (made.damped or made.flat is None)
    if hertz is None or made.model != 4 or not one_of_them or _stable(made, spec):
        return
    high = hertz
    while not _stable(law(replace(spec, bandwidth=high)), spec):
        high *= 1.5
        if high > HIGHEST_HZ:
            return
    low = high / 1.5
    while high - low > 0.01 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _stable(law(replace(spec, bandwidth=middle)), spec) else (middle, high)
    raise InputRefused(
        f"bandwidth = {hertz:.4g} Hz is below {high:.3g} Hz, where {made.name} is unstable on this drive "
        "(its feedback leaves the damping of the cable out): raise it, or take darc-4-damped"
    )


def _stable(made: Controller, spec: DesignSpec) -> bool:
    return all(pole.damping_ratio > -1e-9 for pole in closed_loop_poles(spec.drive, made))
