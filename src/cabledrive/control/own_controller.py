"""A controller of the user's own: what the rig runs, and its checks."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.mechanics.compiled import numba_at_hand
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import described, meaning

MEASURES = {"states": "angles, then speeds, of its shafts", "readings": "angles of every encoder"}
REFERENCES = {
    "inverse": "wanted angles, then speeds, of its shafts, then the motor's torque",
    "motion": "wanted load angle and its derivatives",
}
SHAFTS = ("motor", "drive", "load")


@described
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OwnController:
    """A controller of the user's own, for `cabledrive.track`, which takes any object with these attributes.

    All angles are at the first shaft: the load pulley's times r2 / r1. The controller gives the torque of the
    motor [N m]. Encoders, filter, torque limit, delay, torque loop and the plant are the rig's.
    """

    step: Callable[[Any, Any, Any, Any], tuple[Any, Any]] = meaning(
        "``step(gains, state, measurement, reference) -> (state, command)``, one sample, from the memory "
        "(m,) to that for the next one and the motor's torque [N m]: plain Python, or compiled by "
        "``numba.njit``, in which case the whole loop is compiled with it"
    )
    gains: Any = meaning("handed to every step as they are: numbers, an array, a NamedTuple", 0.0)
    initial_state: ArrayLike = meaning("(m,): memory before the first sample; default: none", ())
    name: str = meaning("for results: any but that of a packaged law", "own controller")
    sample_time: float | None = meaning("that it was designed for [s]; default: that of the rig", None)
    shafts: tuple[str, ...] = meaning(
        'shafts whose motion it takes, from the motor to the load, of "motor", "drive", "load"; default: '
        "every inertia of the highest model that the drive's data allow",
        (),
    )
    measures: str = meaning(
        'what a measurement is: "states", angles [rad], then speeds [rad/s], of its shafts, from the rig\'s '
        'filter; or "readings", the angle of every encoder [rad], without filter',
        "states",
    )
    follows: str = meaning(
        'what a reference is: "inverse", wanted angles [rad], then speeds [rad/s], of its shafts, then the '
        'motor\'s torque [N m], from the inverse of the lumped chain; or "motion", the wanted load angle '
        "with its 2n derivatives",
        "inverse",
    )


def checked_controller(given: Any) -> OwnController:
    """An object like `OwnController` as frozen data; refused if a part is missing or of the wrong kind."""
    if not callable(getattr(given, "step", None)) or isinstance(given, type):
        raise InputRefused(
            f"controller = {_shown(given)} is no name, no path of a controller.json and no controller: give "
            "an object with step(gains, state, measurement, reference), such as cabledrive.OwnController"
        )
    own: dict[str, Any] = {one.name: getattr(given, one.name, one.default) for one in fields(OwnController)}
    name, time, shafts = own["name"], own["sample_time"], own["shafts"]
    if not isinstance(name, str) or not name.strip():
        raise InputRefused(f"controller.name = {name!r} is no name: give a text")
    try:
        start = np.array(own["initial_state"], dtype=np.float64)
    except (TypeError, ValueError):
        start = np.full(1, np.nan)
    if start.ndim != 1 or not np.all(np.isfinite(start)):
        raise InputRefused(
            f'controller "{name}": initial_state = {_shown(own["initial_state"])} must be a list of finite '
            "numbers: give () where the controller has no memory"
        )
    if time is not None and not (isinstance(time, float | int) and 0.0 < time < float("inf")):
        raise InputRefused(f'controller "{name}": sample_time = {time!r} must be a time in s above 0')
    shafts = shafts if isinstance(shafts, tuple | list) else (shafts,)
    if list(shafts) != [shaft for shaft in SHAFTS if shaft in shafts]:
        said = f'controller "{name}": shafts = {_shown(shafts)} must name shafts from the motor to the load'
        raise InputRefused(f"{said}: take some of {', '.join(SHAFTS)}, in this order")
    for key, known in (("measures", MEASURES), ("follows", REFERENCES)):
        if not isinstance(own[key], str) or own[key] not in known:
            words = ", ".join(f"{word} ({what})" for word, what in known.items())
            raise InputRefused(f'controller "{name}": {key} = {_shown(own[key])} is not known: take {words}')
    return OwnController(**own | {"initial_state": start, "shafts": tuple(shafts)})


def _shown(value: Any) -> str:
    words = " ".join(repr(value).split())
    return words if len(words) <= 60 else f"{words[:57]}..."


def is_compiled(step: Any) -> bool:
    """Whether a step is compiled by numba, so that compiled loops can call it."""
    if not numba_at_hand():
        return False
    from numba.core.dispatcher import Dispatcher

    return isinstance(step, Dispatcher)


def stepped(
    own: OwnController, state: Array, measurement: Array, reference: Array, place: str
) -> tuple[Array, float]:
    """One sample of the user's controller: state, (m,), and torque [N m]; ``place``: when, in words."""

    def refused(what: str, remedy: str = "") -> InputRefused:
        return InputRefused(f'controller "{own.name}" returned {what} {place}{remedy}')

    found: Any = own.step(own.gains, state, measurement, reference)
    if not isinstance(found, tuple) or len(found) != 2:
        raise refused(_shown(found), ": return (state, command)")
    try:
        fresh, command = (np.asarray(part, dtype=np.float64) for part in found)
    except (TypeError, ValueError):
        raise refused(_shown(found), ": return numbers") from None
    if fresh.shape != state.shape:
        more = f", its initial_state has {state.shape}: return as many numbers"
        raise refused(f"a state of shape {fresh.shape}", more)
    if command.size != 1:
        raise refused(f"a command of shape {command.shape}", ": return one torque in N m")
    torque = float(command.reshape(()))
    if not np.isfinite(torque):
        raise refused(f"{torque} N m", ": a command must be a finite torque")
    if not np.all(np.isfinite(fresh)):
        raise refused("a state that is not finite")
    return fresh, torque
