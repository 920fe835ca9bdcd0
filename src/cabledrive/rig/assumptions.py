"""In what a run of the rig departs from the theorems' assumptions, and which departures break them.

A departure that acts as a torque of the motor, such as rounding or delay, is a disturbance, and the theorems
allow one up to a bound. `cabledrive.rig.theorem` measures how much of what they allow a run used. Departures
that are never such a disturbance, such as a parameter outside its bounds, are named whenever they occur.
"""

from dataclasses import dataclass

import numpy as np

from cabledrive.control.numbers import BY_REFERENCE, DARC, HIGH, LOW, SLOPE
from cabledrive.parameters import Drive
from cabledrive.reduction.lumped_chain import lumped_model
from cabledrive.rig.closed_loop.loop import Loop, Run, plant_chain
from cabledrive.rig.closed_loop.loop_numbers import WENT_SLACK, Array
from cabledrive.rig.closed_loop.own_plant import models_of
from cabledrive.rig.laws.controllers import load_gear
from cabledrive.rig.setting import Motion, RigOptions

FLEXIBLE: dict[int, tuple[str, ...]] = {1: (), 2: ("joint",), 3: ("cable",), 4: ("joint", "cable")}
PARAMETERS = ("inertia", "viscous friction", "Coulomb friction", "offset torque")
NEGLIGIBLE = 0.25
TOLERANCE = 0.05
"""Of an announced load, as `cabledrive.rig.plant_samples.Spreads` has that of a data sheet."""
SAMPLES_PER_PERIOD = 100.0
"""From so many samples in a period of the bandwidth on, the hold between samples is no departure."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Departure:
    """One way in which a run departs from the theorems' assumptions."""

    words: str
    definite: bool = False  # whether it breaks an assumption however small it is
    # whether cable or load are others than believed: breaks an assumption where what no torque of the motor
    # can make is more than a quarter of the tube
    plant: bool = False


def departures(
    loop: Loop, drive: Drive, actual: Drive, motion: Motion, options: RigOptions, done: Run
) -> list[Departure]:
    """In what a run departs from the theorems' assumptions."""
    found = [
        *(Departure(words=words, definite=True) for words in _beyond_bounds(loop, actual)),
        *(Departure(words=words, definite=True) for words in _announcement(loop, done)),
        *(Departure(words=words) for words in _failures(loop, done)),
        *(Departure(words=words) for words in _sensing(loop, actual, options)),
        *(Departure(words=words) for words in _structure(loop)),
        *(Departure(words=words) for words in _disturbing(loop, done)),
    ]
    if loop.own_plant is not None:
        words = f'plant "{loop.own_plant.name}" is your own: its parameters are not known'
        found.append(Departure(words=words, definite=True))
    elif foreign(loop, drive):
        found.append(Departure(words=f"unmatched: the plant is a {loop.named}", plant=True))
    elif unmatched(drive, actual):
        words = "unmatched: what the cable drives differs from what the law believes"
        found.append(Departure(words=words, plant=True))
    rough = _smoothness(loop, motion)
    return found + ([Departure(words=rough)] if rough else [])


def broken_assumptions(found: list[Departure], used: float | None, unmatched_part: float = 1.0) -> list[str]:
    """Departures that break the theorems' assumptions, by the shares of the tube that causes used."""
    every = used is None or not used <= 1.0
    plant = unmatched_part > NEGLIGIBLE
    return [one.words for one in found if every or one.definite or (one.plant and plant)]


def _beyond_bounds(loop: Loop, actual: Drive) -> list[str]:
    """Parameters and disturbances of the motor beyond the bounds of the law."""
    made = loop.controller
    found: list[str] = []
    if made.law.kind != DARC or loop.own_plant is not None:
        return found
    if foreign(loop, actual) and loop.chain.names != plant_chain(actual, made.model).names:
        return [f"the law of Model {made.model} has other inertias than the {loop.named}: its bounds of the "
                "parameters cannot be checked"]  # fmt: skip
    truth, learning = true_parameters(loop, actual), made.law.learning
    slack = 1e-9 * np.maximum(np.abs(learning[LOW]), np.abs(learning[HIGH]))
    outside = (truth < learning[LOW] - slack) | (truth > learning[HIGH] + slack)
    for i in np.flatnonzero(outside):
        low, high = learning[LOW, i], learning[HIGH, i]
        found.append(f"{PARAMETERS[i]} {truth[i]:.4g} outside its bounds {low:.4g} to {high:.4g}")
    push, most = float(np.abs(loop.rig.forces[:, 0]).max(initial=0.0)), float(learning[HIGH, 2])
    if push > most:
        found.append(f"disturbance at the motor of {push:.4g} N m, beyond the bound of {most:.4g} N m")
    return found


def load_along(loop: Loop, samples: int) -> Array:
    """Inertia of the plant's load at every sample, shape (samples,) [kg m^2 at the first shaft]."""
    found = np.full(samples, loop.chain.inertias[-1])
    found[round(loop.plant.load_time / loop.rig.interval) :] *= loop.plant.load_factor
    return found


def _announcement(loop: Loop, done: Run) -> list[str]:
    """Where the load that a law goes by is another than that of the plant."""
    made = loop.controller
    if made.schedule is None or made.load is None or loop.own_plant is not None:
        return []
    told = made.reference[: done.ended, -1]
    true = load_along(loop, done.ended) / made.load
    off = np.abs(true / told - 1.0)
    if not off.size or off.max() <= TOLERANCE:
        return []
    first = int(np.argmax(off > TOLERANCE))
    time = loop.rig.interval * float(np.count_nonzero(off > TOLERANCE))
    return [
        f"the announced load is {told[first]:.4g} times the drive's and the true one {true[first]:.4g} from "
        f"{first * loop.rig.interval:.4g} s on, for {time:.4g} s in all: more than {TOLERANCE:.0%} apart"
    ]


def foreign(loop: Loop, drive: Drive) -> bool:
    """Whether the plant is a lumped chain of the user's own that is none of the drive's models."""
    return bool(loop.named) and loop.own_plant is None and loop.chain not in models_of(drive)


def true_parameters(loop: Loop, actual: Drive) -> Array:
    """First inertia, viscous and Coulomb friction and offset torque as they are, shape (4,)."""
    chain = plant_chain(actual, loop.controller.model)
    if foreign(loop, actual) and loop.chain.names == chain.names:
        chain = loop.chain
    return np.array([chain.inertias[0], chain.viscous[0], chain.coulomb[0], chain.offsets[0]])


def _failures(loop: Loop, done: Run) -> list[str]:
    found = []
    if done.state.summary[5] > 0:
        found.append("torque at its limit")
    if done.state.summary[6] > 0:
        found.append("a sensor failed")
    if loop.pair is not None:
        if done.state.summary[10] > 0:
            found.append("a flank of the pair of motors was open")
    elif loop.backlash > 0.0:
        found.append("backlash in the gearhead")
    if done.state.summary[9] > 0 or done.state.discrete[1] == WENT_SLACK:
        found.append("a span went slack")
    return found


def _sensing(loop: Loop, actual: Drive, options: RigOptions) -> list[str]:
    """Sensors, delay and sampling."""
    found, rig = [], loop.rig
    if not options.ideal_sensors and loop.controller.field is None:
        found.append("states come from encoders")
    if rig.late_samples or rig.late_part > 0.0:
        found.append(f"delay of {1e3 * actual.sensors.delay:.4g} ms" if actual.sensors else "delay")
    if rig.jitter.size:
        found.append(f"jitter of the sample times of {1e6 * options.jitter:.4g} us")
    hertz = float(loop.controller.gains.get("bandwidth_hz") or 0.0)
    if hertz * rig.interval * SAMPLES_PER_PERIOD > 1.0:
        found.append(f"sampled {1.0 / (hertz * rig.interval):.3g} times in a period of the bandwidth")
    return found


def _structure(loop: Loop) -> list[str]:
    """What the lumped chain that the law is made for leaves out of the plant."""
    made, found = loop.controller, []
    if made.own is not None or loop.own_plant is not None:  # neither is made for a model
        return ["the cable has mass: the law leaves its own modes out"] if loop.cable is not None else []
    ours, theirs = set(FLEXIBLE[made.model]), set(FLEXIBLE[plant_model(loop)])
    if theirs - ours:
        lacking = " and the ".join(sorted(theirs - ours))
        found.append(f"the {lacking} of the plant bend, those of the law do not")
    if ours - theirs:
        found.append(
            f"the {' and the '.join(sorted(ours - theirs))} of the law bend, those of the plant do not"
        )
    if not made.damped and (any(loop.chain.damping) or any(loop.chain.viscous[1:])):
        found.append("damping of the plant's joint or cable is neglected")
    if loop.cable is not None:
        found.append("the cable has mass: the law leaves its own modes out")
    if made.law.kind == DARC and any(loop.chain.coulomb[1:]):
        found.append("Coulomb friction at the load")
    return found


def _disturbing(loop: Loop, done: Run) -> list[str]:
    """Torques on motor and load, and friction of another sign than the law feeds forward."""
    found, forces = [], loop.rig.forces
    if forces[:, 1].any():
        found.append("disturbance at the load")
    if forces[:, 0].any():
        found.append("disturbance at the motor")
    if _against(loop, done):
        found.append("friction acts against the sign that the law takes from the reference")
    return found


def _against(loop: Loop, done: Run) -> bool:
    """Whether the motor turned against the reference whose sign its friction is taken to have."""
    made = loop.controller
    if made.law.kind != DARC or not made.law.scalars[BY_REFERENCE] or not done.log.size:
        return False
    shape = np.tanh(made.law.scalars[SLOPE] * made.reference[: done.ended, -2])
    speed = done.log[: done.ended, loop.chain.size]
    return bool(np.any((shape * speed < 0.0) & (np.abs(shape) > 1e-3)))


def _smoothness(loop: Loop, motion: Motion) -> str | None:
    """Whether the reference has fewer bounded derivatives than the law of the chain takes."""
    flat = loop.controller.flat
    if flat is None:
        return None
    bounded = (motion.rise_order + 1) // 2
    if bounded >= 2 * flat.size:
        return None
    return (
        f"reference of order {motion.rise_order}: derivative {bounded} jumps, and the law takes "
        f"{2 * flat.size} bounded ones (order {4 * flat.size - 1})"
    )


def unmatched(drive: Drive, actual: Drive) -> bool:
    """Whether anything but the motor's inertia, friction and offset differs between two drives."""
    ours, theirs = lumped_model(drive), lumped_model(actual)
    return (
        ours.inertias[1:] != theirs.inertias[1:]
        or ours.stiffness != theirs.stiffness
        or ours.damping != theirs.damping
        or ours.viscous[1:] != theirs.viscous[1:]
        or load_gear(drive) != load_gear(actual)
    )


def plant_model(loop: Loop) -> int:
    """Number of the model that is the plant."""
    joint, cable = "drive" in loop.chain.names and loop.chain.size > 1, "load" in loop.chain.names
    joint = joint and loop.chain.names[0] == "motor"
    return 1 + joint + 2 * cable
