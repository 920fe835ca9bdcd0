"""Runs of the rig made to leave the tube of the theorem: drives, laws, motions, plants and sensors at random.

Nothing here is tuned to the check that the runs are for. Each hazard is drawn by itself, so that most runs
have one or two and some have none; values reach from negligible to absurd.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cabledrive.control.darc import printed_bounds
from cabledrive.parameters import Drive, InputRefused, load_drive
from cabledrive.reduction.lumped_chain import FLEXIBLE_JOINT, highest_model
from cabledrive.rig import Motion, RigOptions, track
from cabledrive.rig.closed_loop.loop import plant_chain
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.setting import DEGREE, Disturbance
from cabledrive.trajectories import move_limits, shortest_rise

LAWS = {
    4: {"darc-4-damped": 0.55, "darc-4": 0.2, "darc-3": 0.15, "darc-2": 0.05, "darc-1": 0.05},
    3: {"darc-3-damped": 0.5, "darc-3": 0.2, "darc-indirect": 0.2, "darc-1": 0.1},
}
LONGEST = 1.5
"""Longest rise [s]: what happens, happens in less, and every sample costs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What one run said of the bound.

    ``inside``: whether the error kept inside the tube at every sample; ``within``: what the result says of
    it; ``broken``, tuple of str: assumptions named; ``words``: how to make the run again.
    """

    inside: bool
    within: bool | None
    broken: tuple[str, ...]
    used: float | None
    words: str


def adversarial_outcomes(runs: int, seed: int) -> list[Outcome]:
    """Outcomes of seeded runs; specs that are refused are drawn again."""
    return [adversarial_outcome(one) for one in np.random.default_rng(seed).spawn(runs)]


def adversarial_outcome(generator: np.random.Generator) -> Outcome:
    """Outcome of one run."""
    while True:
        drive, choices = adversarial_spec(generator)
        try:
            said = track(drive, **choices).summary
        except InputRefused:
            continue
        return Outcome(
            inside=said["inside_tube"],
            within=said["within_bound"],
            broken=tuple(said["broken_assumptions"]),
            used=said["bound_used"],
            words=f"{drive!r} {choices!r}",
        )


def adversarial_spec(rng: np.random.Generator) -> tuple[Drive, dict[str, Any]]:
    """A drive, and what `track` is asked to do with it."""
    drive = drawn_drive(rng)
    laws = LAWS[highest_model(drive)]
    law = str(rng.choice(list(laws), p=list(laws.values())))
    order = None if rng.random() < 0.9 else int(rng.choice([5, 7, 9, 13]))
    motion = drawn_motion(drive, rng, order)
    bandwidth = None if rng.random() < 0.02 else spread(rng, 5.0, 80.0)
    choices: dict[str, Any] = {
        "controller": law,
        "motion": motion,
        "bandwidth": bandwidth,
        "options": drawn_options(drive, motion, rng),
        "plant_drive": sampled_plant(drive, law, rng),
        "seed": int(rng.integers(1_000)),
        "adapt": bool(rng.random() < 0.9),
    }
    if rng.random() < 0.05:
        choices["plant"] = f"model-{rng.integers(1, highest_model(drive) + 1)}"
    return drive, choices


def spread(rng: np.random.Generator, low: float, high: float) -> float:
    """A value between two others, its logarithm uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def drawn_drive(rng: np.random.Generator) -> Drive:
    """The rig of the dissertation with every size drawn over a decade, or the finger's tendon."""
    if rng.random() < 0.1:
        return load_drive("finger-tendon")
    drive = load_drive("dissertation-3")
    motor, lumped = drive.motor, drive.lumped
    assert motor is not None
    assert lumped is not None
    assert drive.sensors is not None
    motor = replace(
        motor,
        inertia=motor.inertia * spread(rng, 0.3, 3.0),
        viscous_friction=motor.viscous_friction * spread(rng, 0.1, 3.0),
        coulomb_friction=motor.coulomb_friction * spread(rng, 0.1, 3.0),
        joint_stiffness=motor.joint_stiffness * spread(rng, 0.3, 3.0),
        joint_damping=motor.joint_damping * spread(rng, 0.1, 3.0),
        offset_torque=float(rng.choice([0.0, 0.005, -0.005])),
        current_bandwidth=None if rng.random() < 0.2 else spread(rng, 300.0, 5_000.0),
    )
    if rng.random() < 0.4:
        motor = replace(motor, joint_stiffness=None, joint_damping=0.0)
    lumped = replace(
        lumped,
        cable_stiffness=lumped.cable_stiffness * spread(rng, 0.3, 3.0),
        cable_damping=lumped.cable_damping * spread(rng, 0.1, 3.0),
    )
    delay = 0.0 if rng.random() < 0.85 else spread(rng, 2e-5, 2e-3)
    rate = float(rng.choice([1_000.0, 2_000.0, 5_000.0, 10_000.0], p=[0.1, 0.3, 0.5, 0.1]))
    sensors = replace(drive.sensors, delay=delay, sample_rate=rate)
    return replace(drive, motor=motor, lumped=lumped, sensors=sensors)


def drawn_motion(drive: Drive, rng: np.random.Generator, order: int | None) -> Motion:
    """A pulse of 0.1 to 180 deg in up to thirty times the shortest rise that torque and speed allow."""
    angle = spread(rng, 0.1, 180.0)
    least, _ = shortest_rise(move_limits(drive), angle * DEGREE, order or 11)
    rise = float(np.clip(least * spread(rng, 1.05, 30.0), 0.02, LONGEST))
    return Motion(angle=angle, rise=rise, dwell=spread(rng, 0.02, 0.3), order=order)


def drawn_options(drive: Drive, motion: Motion, rng: np.random.Generator) -> RigOptions:
    """Sensors, friction, disturbances, jitter, an encoder that drops out, a slack span let pass."""
    end = 2.0 * (motion.rise + motion.dwell)
    coulomb = drive.motor.coulomb_friction if drive.motor else 0.0

    def push(on: str, low: float, high: float) -> Disturbance:
        start = float(rng.uniform(0.0, 0.8 * end))
        torque = float(rng.choice([-1.0, 1.0])) * coulomb * spread(rng, low, high)
        return Disturbance(torque=torque, start=start, end=start + float(rng.uniform(0.01, end)), on=on)

    pushes = [push("motor", 0.03, 5.0)] if rng.random() < 0.08 else []
    pushes += [push("load", 0.003, 3.0)] if rng.random() < 0.05 else []
    blind = None
    if rng.random() < 0.02:
        start = float(rng.uniform(0.0, 0.9 * end))
        blind = ("load", start, start + spread(rng, 1e-3, 0.1))
    return RigOptions(
        ideal_sensors=bool(rng.random() < 0.6),
        observer="difference" if rng.random() < 0.15 else "kalman",
        encoder_phase="centred" if rng.random() < 0.2 else "random",
        smooth_friction=bool(rng.random() < 0.3),
        forbid_slack=bool(rng.random() < 0.8),
        jitter=spread(rng, 1e-7, 2e-5) if rng.random() < 0.05 else 0.0,
        disturbances=tuple(pushes),
        blind=blind,
    )


def sampled_plant(drive: Drive, law: str, rng: np.random.Generator) -> Drive:
    """The drive as it is: the motor within a law's bounds or on them, sometimes beyond, or another cable."""
    motor = drive.motor
    assert motor is not None
    bounds = law_bounds(drive, law)
    corner = rng.random() < 0.4

    def within(low: float, high: float) -> float:
        return float(rng.choice([low, high]) if corner else rng.uniform(low, high))

    names = ("inertia", "viscous_friction", "coulomb_friction", "offset_torque")
    changed = {
        name: getattr(motor, name) + within(*pair) for name, pair in zip(names, bounds.tolist(), strict=True)
    }
    if rng.random() < 0.06:
        name = str(rng.choice(names[:3]))
        changed[name] = getattr(motor, name) * spread(rng, 0.3, 3.0)
    if rng.random() < 0.04:
        changed["backlash"] = spread(rng, 1e-4, 0.02)
    if rng.random() < 0.04:
        changed["torque_limit"] = motor.torque_limit * spread(rng, 0.05, 1.0)
    plant = replace(drive, motor=replace(motor, **changed))
    return replace(plant, **_other_cable(plant, rng)) if rng.random() < 0.1 else plant


def law_bounds(drive: Drive, law: str) -> Array:
    """How far the motor's inertia, friction and offset may lie from the drive's, shape (4, 2)."""
    model = int(law.split("-")[1]) if law[5].isdigit() else highest_model(drive)
    bounds = printed_bounds(plant_chain(drive, model), flexible_joint=FLEXIBLE_JOINT[model])
    return np.column_stack((bounds.low - bounds.nominal, bounds.high - bounds.nominal))


def _other_cable(plant: Drive, rng: np.random.Generator) -> dict[str, Any]:
    """Cable or load of another size than the law believes, or friction at the load."""
    pulley = plant.load_pulley
    kinds: dict[str, Callable[[], dict[str, Any]]] = {
        "inertia": lambda: _pulley(plant, inertia=pulley.inertia * spread(rng, 0.7, 1.4)),
        "friction": lambda: _pulley(plant, coulomb_friction=spread(rng, 1e-4, 0.05)),
        "viscous": lambda: _pulley(plant, viscous_friction=spread(rng, 1e-5, 0.01)),
    }
    if plant.lumped is not None:
        lumped = plant.lumped
        kinds["stiffness"] = lambda: {
            "lumped": replace(lumped, cable_stiffness=lumped.cable_stiffness * spread(rng, 0.7, 1.4))
        }
        kinds["damping"] = lambda: {
            "lumped": replace(lumped, cable_damping=lumped.cable_damping * spread(rng, 0.3, 3.0))
        }
    return kinds[str(rng.choice(list(kinds)))]()


def _pulley(plant: Drive, **changes: float) -> dict[str, Any]:
    first, last = plant.pulley
    return {"pulley": (first, replace(last, **changes))}
