"""What a run of the rig leaves besides its peaks, and in what it departs from the theorems' assumptions.

A departure that acts as a torque of the motor, such as rounding or delay, is a disturbance, and the theorems
allow one up to a bound. `cabledrive.rig.bounds` measures how much of what they allow a run used. Departures
that are never such a disturbance, such as a parameter outside its bounds, are named whenever they occur.
"""

from typing import Any

import numpy as np

from cabledrive.control.backstepping import stability_margin
from cabledrive.control.bound import robust_conditions
from cabledrive.control.numbers import BACKSTEPPING, BY_REFERENCE, DARC, HIGH, LOW, SLOPE
from cabledrive.mechanics.holding import FREE, HOLDING, left_out_under_torque
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import lumped_model
from cabledrive.rig import bounds
from cabledrive.rig.closed_loop.chain_kernels import LEAST, SUMMARY, WENT_SLACK
from cabledrive.rig.closed_loop.loop import Loop, Run
from cabledrive.rig.laws.controllers import load_gear, plant_chain
from cabledrive.rig.setting import CABLE, DEGREE, none

FLEXIBLE: dict[int, tuple[str, ...]] = {1: (), 2: ("joint",), 3: ("cable",), 4: ("joint", "cable")}
PARAMETERS = ("inertia", "viscous friction", "Coulomb friction", "offset torque")
NEGLIGIBLE = 0.25
SAMPLES_PER_PERIOD = 100.0
"""From so many samples in a period of the bandwidth on, the hold between samples is no departure."""


DEFINITE, PLANT = "definite", "plant"
"""Kinds of departures: what breaks an assumption however small it is; a cable or load that is another than
believed, which breaks one where what no torque of the motor can make is more than a quarter of the tube."""


def departures(loop: Loop, done: Run) -> dict[str, str]:
    """In what a run departs from the theorems' assumptions, in words, and the kind of each."""
    found, plant = dict.fromkeys([*_beyond_bounds(loop), *_announcement(loop, done)], DEFINITE), ""
    if loop.own_plant is not None:
        found[f'plant "{loop.own_plant.name}" is your own: its parameters are not known'] = DEFINITE
    elif bounds.foreign(loop, loop.spec.drive):
        plant = f"unmatched: the plant is a {loop.named}"
    elif unmatched(loop.spec.drive, loop.spec.actual):
        plant = "unmatched: what the cable drives differs from what the law believes"
    found |= dict.fromkeys([*_on_the_rig(loop, done), *_structure(loop)], "")
    return found | ({plant: PLANT} if plant else {})


def _on_the_rig(loop: Loop, done: Run) -> list[str]:
    """What sensors, sampling, limits and disturbances were beside the equations of the law."""
    rig, made, options, sensors = loop.rig, loop.controller, loop.spec.options, loop.spec.actual.sensors
    happened = dict(zip(SUMMARY, done.state.summary > 0, strict=True))
    delay = f"delay of {1e3 * sensors.delay:.4g} ms" if sensors else "delay"
    per_period = float(made.gains.get("bandwidth_hz") or 0.0) * rig.interval
    found = {
        "torque at its limit": happened["saturated"],
        "a sensor failed": happened["invalid"],
        "a flank of the pair of motors was open": loop.pair is not None and happened["loose"],
        "backlash in the gearhead": loop.pair is None and loop.backlash > 0.0,
        "a span went slack": happened["slack"] or done.state.discrete[1] == WENT_SLACK,
        "states come from encoders": not options.ideal_sensors and made.field is None,
        delay: rig.late_samples or rig.late_part > 0.0,
        f"jitter of the sample times of {1e6 * options.jitter:.4g} us": rig.jitter.size,
        f"sampled {1.0 / per_period if per_period else 0.0:.3g} times in a period of the bandwidth": (
            per_period * SAMPLES_PER_PERIOD > 1.0
        ),
        "disturbance at the load": rig.forces[:, 1].any(),
        "disturbance at the motor": rig.forces[:, 0].any(),
        "friction acts against the sign that the law takes from the reference": _against(loop, done),
    }
    return [words for words, so in found.items() if so]


def broken_assumptions(found: dict[str, str], used: float | None, unmatched_part: float) -> list[str]:
    """Departures that break the theorems' assumptions, by the shares of the tube that causes used."""
    every = used is None or not used <= 1.0
    breaks = (DEFINITE, PLANT) if unmatched_part > NEGLIGIBLE else (DEFINITE,)
    return [words for words, kind in found.items() if every or kind in breaks]


def _beyond_bounds(loop: Loop) -> list[str]:
    """Parameters and disturbances of the motor beyond the bounds of the law."""
    made, actual = loop.controller, loop.spec.actual
    found: list[str] = []
    if made.law.kind != DARC or loop.own_plant is not None:
        return found
    if bounds.foreign(loop, actual) and loop.chain.names != plant_chain(actual, made.model).names:
        inertias = f"the law of Model {made.model} has other inertias than the {loop.named}"
        return [f"{inertias}: its bounds of the parameters cannot be checked"]
    truth, learning = bounds.true_parameters(loop), made.law.learning
    slack = 1e-9 * np.maximum(np.abs(learning[LOW]), np.abs(learning[HIGH]))
    outside = (truth < learning[LOW] - slack) | (truth > learning[HIGH] + slack)
    for i in np.flatnonzero(outside):
        low, high = learning[LOW, i], learning[HIGH, i]
        found.append(f"{PARAMETERS[i]} {truth[i]:.4g} outside its bounds {low:.4g} to {high:.4g}")
    push, most = float(np.abs(loop.rig.forces[:, 0]).max(initial=0.0)), float(learning[HIGH, 2])
    if push > most:
        found.append(f"disturbance at the motor of {push:.4g} N m, beyond the bound of {most:.4g} N m")
    return found


def _announcement(loop: Loop, done: Run) -> list[str]:
    """Where the load that a law goes by is another than that of the plant."""
    made = loop.controller
    if made.schedule is None or made.load is None or loop.own_plant is not None:
        return []
    stated = made.reference[: done.ended, -1]
    true = bounds.load_along(loop, done.ended) / made.load
    off = np.abs(true / stated - 1.0)
    if not off.size or off.max() <= bounds.TOLERANCE:
        return []
    first = int(np.argmax(off > bounds.TOLERANCE))
    time = loop.rig.interval * float(np.count_nonzero(off > bounds.TOLERANCE))
    return [
        f"the announced load is {stated[first]:.4g} times the drive's and the true one {true[first]:.4g} "
        f"from {first * loop.rig.interval:.4g} s on, for {time:.4g} s in all: more than "
        f"{bounds.TOLERANCE:.0%} apart"
    ]


def _structure(loop: Loop) -> list[str]:
    """What the lumped chain that the law is made for leaves out of the plant, and its reference."""
    made, flat, found = loop.controller, loop.controller.flat, list[str]()
    mass = ["the cable has mass: the law leaves its own modes out"] if loop.cable is not None else []
    bounded, rough = (loop.spec.motion.rise_order + 1) // 2, list[str]()
    if flat is not None and bounded < 2 * flat.size:
        said = f"reference of order {loop.spec.motion.rise_order}: derivative {bounded} jumps"
        rough.append(f"{said}, and the law takes {2 * flat.size} bounded ones (order {4 * flat.size - 1})")
    if made.own is not None or loop.own_plant is not None:  # neither is made for a model
        return mass + rough
    ours, theirs = set(FLEXIBLE[made.model]), set(FLEXIBLE[plant_model(loop)])
    for these, those, words in (
        (theirs, ours, "of the plant bend, those of the law do not"),
        (ours, theirs, "of the law bend, those of the plant do not"),
    ):
        if these - those:
            found.append(f"the {' and the '.join(sorted(these - those))} {words}")
    if not made.damped and (any(loop.chain.damping) or any(loop.chain.viscous[1:])):
        found.append("damping of the plant's joint or cable is neglected")
    found += mass
    if made.law.kind == DARC and any(loop.chain.coulomb[1:]):
        found.append("Coulomb friction at the load")
    return found + rough


def _against(loop: Loop, done: Run) -> bool:
    """Whether the motor turned against the reference whose sign its friction is taken to have."""
    made = loop.controller
    if made.law.kind != DARC or not made.law.scalars[BY_REFERENCE] or not done.log.size:
        return False
    shape = np.tanh(made.law.scalars[SLOPE] * made.reference[: done.ended, -2])
    speed = done.log[: done.ended, loop.chain.size]
    return bool(np.any((shape * speed < 0.0) & (np.abs(shape) > 1e-3)))


def unmatched(drive: Drive, actual: Drive) -> bool:
    """Whether anything but the motor's inertia, friction and offset differs between two drives."""
    chains = (lumped_model(one) for one in (drive, actual))
    ours, theirs = ((one.inertias[1:], one.stiffness, one.damping, one.viscous[1:]) for one in chains)
    return ours != theirs or load_gear(drive) != load_gear(actual)


def plant_model(loop: Loop) -> int:
    """Number of the model that is the plant."""
    joint, cable = "drive" in loop.chain.names and loop.chain.size > 1, "load" in loop.chain.names
    joint = joint and loop.chain.names[0] == "motor"
    return 1 + joint + 2 * cable


def why_ended(loop: Loop, done: Run) -> str | None:
    """Why a run ended before its time, if it did."""
    if not done.failed:
        return None
    time = done.ended * loop.rig.interval
    if done.state.discrete[1] == WENT_SLACK:
        torque = loop.slack * loop.chain.stiffness[-1]
        said = f"a span went slack at t = {time:.4g} s: the cable carried over {torque:.4g} N m"
        return f"{said}; slow down, raise cable.pretension, or take --tension-only"
    if loop.controller.field is not None:
        return f"the stepper lost its steps and ran away at t = {time:.4g} s: slow down, or raise its current"
    return f"the plant diverged at t = {time:.4g} s: lower the bandwidth, or feed back the motor's encoder"


def plant_words(loop: Loop) -> dict[str, Any]:
    """What the plant is, its friction, backlash and slack; unknown of a plant of the user's own."""
    if loop.own_plant is not None:
        reason = "the plant is your own: slack of its spans and backlash are not looked at"
        said = {"plant": loop.named, "friction": "the plant's own", "slack_rule": reason}
        return said | none("backlash", reason)
    return {
        "plant": CABLE if loop.cable is not None else loop.named or f"model-{plant_model(loop)}",
        "friction": "smooth, c tanh(50 w)" if loop.spec.options.smooth_friction else "stick-slip Coulomb",
        "backlash": loop.backlash,
        "slack_rule": "ends the run" if loop.spec.options.forbid_slack else "a slack span carries nothing",
    }


def span_tensions(loop: Loop, log: Array) -> Array | None:
    """Tension of both spans without dampers, shape (samples, 2) [N], at least zero; None without a loop."""
    n, chain, actual = loop.chain.size, loop.chain, loop.spec.actual
    if "load" not in chain.names or not actual.closed or loop.own_plant is not None:
        return None
    twist = log[:, n - 2] - log[:, n - 1]
    share = chain.stiffness[-1] * twist / (2.0 * actual.drive_pulley.radius)
    both = actual.cable.pretension + np.column_stack((-share, share))
    return np.maximum(both, 0.0)


def disturbance_facts(loop: Loop) -> dict[str, Any]:
    """What was asked of the rig beside its plant: jitter [s], disturbances, limits, dropout."""
    options, motor = loop.spec.options, loop.spec.actual.motor
    found: dict[str, Any] = {"jitter": options.jitter, "disturbances": []}
    for one in options.disturbances:
        words = {"on": one.on, "torque": one.torque, "start": one.start}
        found["disturbances"].append(words | ({"end": one.end} if np.isfinite(one.end) else {}))
    if np.isfinite(loop.rig.torque_limit):
        found["torque_limit"] = loop.rig.torque_limit
    if motor is not None and motor.current_bandwidth is not None:
        found["current_bandwidth_hz"] = motor.current_bandwidth
    if options.load_change is not None:
        start, factor = options.load_change
        found["load_change"] = {"start": start, "factor": factor}
    if options.blind is not None:
        found["blind"] = list(options.blind)
    return found


def motor_words(actual: Drive, *, stepper: bool = False) -> dict[str, str]:
    """How the rotor is held: it turns freely; why a holding stiffness is left out."""
    if stepper:
        return {"motor": HOLDING}
    reason = left_out_under_torque(actual)
    return {"motor": FREE} | ({"motor_reason": reason} if reason else {})


def condition_words(
    loop: Loop, shaft: Array, command: Array, sigma: Array, regressor: Array
) -> dict[str, Any]:
    """Whether the robust term met its two conditions along a run; none with a reason for other laws."""
    law = loop.controller.law
    if law.kind != DARC or len(sigma) < 2:
        return none("robust_conditions", "the conditions are those of the adaptive robust laws of the chain")
    delta = bounds.disturbance_bound(law, shaft, command)
    return {"robust_conditions": robust_conditions(law, sigma, regressor, delta)}


LAST_SHARE = 0.5
"""Part of the last dwell in which the swing at rest is measured."""


def rest_words(loop: Loop, error: Array) -> dict[str, Any]:
    """Swing of the load at the end of the last dwell of a plant with backlash, where a loop may cycle."""
    if loop.backlash <= 0.0 or loop.own_plant is not None:
        return {}
    last = round(LAST_SHARE * loop.spec.motion.dwell / loop.rig.interval)
    if len(error) < len(loop.target) or last < 2:
        reason = "the run did not come to its last dwell" if last >= 2 else "the motion has no dwell"
        words = none("rest_swing_deg", reason) | none("rest_swing_counts", reason)
        return words | {"rest_swing_reason": reason}
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
    opened = int(done.score["loose"])
    first = 2 * loop.chain.size + 1 + LEAST
    least, limit = np.asarray(done.state.x[first : first + 2]), pair.law.limit
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
        short = taken.max() >= limit * (1.0 - 1e-9)
        then = ", and a motor was at its torque limit" if short else ": raise the preload, or move slower"
        said["reason"] = (
            f"a flank was open at {opened / max(len(flanks), 1):.2%} of the samples: half the joint's torque "
            f"exceeded the preload{then}"
        )
    return {"pair": said}


def bound_words(
    check: bounds.BoundCheck | None, error: Array, broken: list[str], gear: float
) -> dict[str, Any]:
    """The bound, whether the error [rad] kept it, and which assumptions of the theorem did not hold."""
    if check is None:
        why = "bounds are those of the laws of the chain, of the laws that learn the load and of the one "
        why += "that knows it, on the model that they are made for"
        words = none("theory_bound_deg", why) | none("within_bound", "no bound")
        return words | {"bound_used": None, "broken_assumptions": broken}
    tube = check.bound.tube / gear
    printed = check.bound.printed / gear / DEGREE
    inside = bool(np.all(np.abs(error) <= tube + 1e-12))
    words = {
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
    law, reference = loop.controller.law, loop.controller.reference
    sound = np.flatnonzero(np.all(np.isfinite(states), axis=1)) if states.size else np.zeros(0, dtype=int)
    if law.kind != BACKSTEPPING or not len(sound):
        return {}
    chosen = sound[:: max(1, len(sound) // INSTANTS)]
    margins = [stability_margin(law, estimates[k], states[k], reference[k]) for k in chosen]
    share = float(np.mean(np.array(margins) > 0.0))
    return {"d_z": {"smallest": min(margins), "largest": max(margins), "positive_share": share}}
