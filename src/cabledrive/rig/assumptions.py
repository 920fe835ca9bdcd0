"""In what a run of the rig departs from the theorems' assumptions, and which departures break them.

A departure that acts as a torque of the motor, such as rounding or delay, is a disturbance, and the theorems
allow one up to a bound. `cabledrive.rig.bounds` measures how much of what they allow a run used. Departures
that are never such a disturbance, such as a parameter outside its bounds, are named whenever they occur.
"""

from dataclasses import dataclass

import numpy as np

from cabledrive.control.numbers import BY_REFERENCE, DARC, HIGH, LOW, SLOPE
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import lumped_model
from cabledrive.rig.closed_loop.chain_kernels import SUMMARY, WENT_SLACK
from cabledrive.rig.closed_loop.loop import Loop, Run, plant_chain
from cabledrive.rig.closed_loop.own_plant import models_of
from cabledrive.rig.laws.controllers import load_gear

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


def departures(loop: Loop, done: Run) -> list[Departure]:
    """In what a run departs from the theorems' assumptions."""
    definite = [*_beyond_bounds(loop), *_announcement(loop, done)]
    plant = []
    if loop.own_plant is not None:
        definite.append(f'plant "{loop.own_plant.name}" is your own: its parameters are not known')
    elif foreign(loop, loop.drive):
        plant = [f"unmatched: the plant is a {loop.named}"]
    elif unmatched(loop.drive, loop.actual):
        plant = ["unmatched: what the cable drives differs from what the law believes"]
    return [
        *(Departure(words=words, definite=True) for words in definite),
        *(Departure(words=words) for words in _on_the_rig(loop, done)),
        *(Departure(words=words) for words in _structure(loop)),
        *(Departure(words=words, plant=True) for words in plant),
    ]


def _on_the_rig(loop: Loop, done: Run) -> list[str]:
    """What sensors, sampling, limits and disturbances were beside the equations of the law."""
    rig, made, options, sensors = loop.rig, loop.controller, loop.options, loop.actual.sensors
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


def broken_assumptions(found: list[Departure], used: float | None, unmatched_part: float = 1.0) -> list[str]:
    """Departures that break the theorems' assumptions, by the shares of the tube that causes used."""
    every = used is None or not used <= 1.0
    plant = unmatched_part > NEGLIGIBLE
    return [one.words for one in found if every or one.definite or (one.plant and plant)]


def _beyond_bounds(loop: Loop) -> list[str]:
    """Parameters and disturbances of the motor beyond the bounds of the law."""
    made, actual = loop.controller, loop.actual
    found: list[str] = []
    if made.law.kind != DARC or loop.own_plant is not None:
        return found
    if foreign(loop, actual) and loop.chain.names != plant_chain(actual, made.model).names:
        return [f"the law of Model {made.model} has other inertias than the {loop.named}: its bounds of the "
                "parameters cannot be checked"]  # fmt: skip
    truth, learning = true_parameters(loop), made.law.learning
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


def true_parameters(loop: Loop) -> Array:
    """First inertia, viscous and Coulomb friction and offset torque as they are, shape (4,)."""
    chain = plant_chain(loop.actual, loop.controller.model)
    if foreign(loop, loop.actual) and loop.chain.names == chain.names:
        chain = loop.chain
    return np.array([chain.inertias[0], chain.viscous[0], chain.coulomb[0], chain.offsets[0]])


def _structure(loop: Loop) -> list[str]:
    """What the lumped chain that the law is made for leaves out of the plant, and its reference."""
    made, flat, found = loop.controller, loop.controller.flat, list[str]()
    mass = ["the cable has mass: the law leaves its own modes out"] if loop.cable is not None else []
    bounded, rough = (loop.motion.rise_order + 1) // 2, list[str]()
    if flat is not None and bounded < 2 * flat.size:
        rough.append(
            f"reference of order {loop.motion.rise_order}: derivative {bounded} jumps, and the law takes "
            f"{2 * flat.size} bounded ones (order {4 * flat.size - 1})"
        )
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
