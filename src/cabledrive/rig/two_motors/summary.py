"""What a run of two motors was in words, and the bound of the body's place."""

from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters.arrays import Array
from cabledrive.reduction.two_motors import ASSUMED
from cabledrive.reduction.two_motors_kernels import TwoMotors
from cabledrive.rig.two_motors.plan import least_damping
from cabledrive.rig.two_motors.run import PlantRun, Setup, TwoMotorTracking, bound_of_place, part_used

NAMES = {
    "mass": "mass of the body",
    "rigidity": "stiffness of the lines",
    "loss": "damping of the lines",
    "force": "weight of the body",
    "turning_coulomb": "friction of the drums",
    "turning_viscous": "viscous friction of the drums",
    "inertia": "inertia of the drums",
    "coulomb": "friction of the body",
}
ALWAYS = (
    "the loop is sampled, and a drum's friction sticks and slides",
    "the lines turn and change their stiffness on the way: the bound is that of the linear loop",
)


def place_departures(setup: Setup, actual: TwoMotors, reshaped: float) -> list[str]:
    """In what a run differs from what the bound of the place supposes; ``reshaped``: part of its samples."""
    believed = setup.machine.numbers
    found = [
        f"{words} {100.0 * off:.0f} % off"
        for key, words in NAMES.items()
        if (off := _off(getattr(actual, key), getattr(believed, key))) > 1e-9
    ]
    if reshaped > 0.0:
        found.append(f"wanted tensions were reshaped at {reshaped:.1%} of the samples")
    return [*found, *ALWAYS]


def _off(actual: Array, believed: Array) -> float:
    """Largest relative difference."""
    scale = np.maximum(np.abs(believed), 1e-12)
    return float(np.max(np.abs(actual - believed) / scale, initial=0.0))


def place_words(
    setup: Setup, actual: TwoMotors, error: Array, broken: list[str], reshaped: float
) -> dict[str, Any]:
    """The bound beside the error, shape (samples, m) [m], inside it where no broken assumption is named."""
    bound = bound_of_place(setup)
    used = part_used(bound, error)
    named = list(broken)
    if not used <= 1.0:
        named += place_departures(setup, actual, reshaped)
    return {
        "position_bound_mm": {
            name: 1e3 * float(value) for name, value in zip(setup.machine.names, bound, strict=True)
        },
        "position_bound_used": used,
        "position_within_bound": None if named else True,
        "position_broken_assumptions": named,
    }


Flags = NDArray[np.bool_]

CONTROLLER = "tension-position"
_AT_LIMIT = 1.0 - 1e-9
PLACES = 8
"""At which the poles of the loop are computed."""
_TOLD = 1e-3
"""Part of the samples from which reshaping is reported."""


def summarize(
    setup: Setup, actual: TwoMotors, done: PlantRun, force: Array, *, seed: int, drawn: dict[str, Any] | None
) -> TwoMotorTracking:
    """Put a run of ``actual`` into words and arrays; ``force``, shape (samples, m): on the body [N]."""
    gains, design, machine = setup.design.gains, setup.design, setup.machine
    m, record, samples = len(machine.names), done.record, len(setup.plan.table)
    wanted = setup.plan.table[: len(record), :m]
    error = record[:, :m] - wanted
    size = np.sqrt((error**2).sum(axis=1)) if len(record) else np.zeros(1)
    tension, torque, limit = record[:, m : m + 2], record[:, m + 2 : m + 4], machine.numbers.limit
    saturated: Flags = np.any(np.abs(torque) >= _AT_LIMIT * limit, axis=1)
    reshaped: Flags = record[:, m + 6] > 0.0
    finite = len(record) == samples
    least = [float(value) if np.isfinite(value) else None for value in done.least]
    kept = finite and bool((done.least >= design.floor).all())
    move = setup.plan.trajectory.moves[0]
    summary: dict[str, Any] = {
        "controller": CONTROLLER,
        "plant": "body between two lines, exact geometry",
        "observer": "drum encoders and load cells",
        "gains": {
            "position_hz": gains.position / (2.0 * pi),
            "tension_hz": gains.tension / (2.0 * pi),
            "observer_hz": gains.observer / (2.0 * pi),
        },
        "peak_error_mm": 1e3 * float(size.max()),
        "rms_error_mm": 1e3 * float(np.sqrt((size**2).mean())),
        "error_mm": {
            name: 1e3 * float(np.abs(error[:, j]).max(initial=0.0)) for j, name in enumerate(machine.names)
        },
        "peak_error_deg": None,
        "peak_error_deg_reason": "the body slides: see peak_error_mm",
        "rms_error_deg": None,
        "rms_error_deg_reason": "the body slides: see rms_error_mm",
        "estimates_within_bounds": None,
        "estimates_within_bounds_reason": "the law has no estimates with bounds",
        "least_tension": float(done.least.min()) if None not in least else None,
        "least_allowed": design.floor,
        "tension_kept": kept,
        "lines": [
            {
                "name": machine.lines[i],
                "spans": list(machine.spans[i]),
                "least_tension": least[i],
                "largest_tension": float(tension[:, i].max(initial=0.0)),
                "at_rest": float(machine.tension[i]),
                "least_allowed": design.floor,
                "margin": float(design.margin[i]),
            }
            for i in range(2)
        ],
        "motors": [
            {
                "name": machine.motors[i],
                "peak_torque": float(np.abs(torque[:, i]).max(initial=0.0)),
                "rms_torque": float(np.sqrt((torque[:, i] ** 2).mean())) if len(record) else None,
                "torque_limit": float(limit[i]),
            }
            for i in range(2)
        ],
        "peak_torque": float(np.abs(torque).max(initial=0.0)),
        "saturated_fraction": float(saturated.mean()) if len(record) else None,
        "reshaped_fraction": float(reshaped.mean()) if len(record) else None,
        "gust": design.gust,
        "motion": {
            "way": {name: float(setup.plan.table[:, j].max() + setup.plan.table[:, j].min())
                    for j, name in enumerate(machine.names)},
            "rise": move.duration,
            "pulses": len(setup.plan.trajectory.moves) // 2,
            "order": setup.plan.trajectory.order,
            "used": setup.plan.used(machine, design),
        },
        "sample_rate": 1.0 / gains.interval,
        "internal_step": gains.interval / done.substeps,
        "seed": seed,
    }  # fmt: skip
    places = setup.plan.table[:: max(1, len(setup.plan.table) // PLACES), :m]
    damping = least_damping(machine.numbers, gains, places, done.substeps)
    summary["least_damping"] = damping
    broken = _broken(setup, force, saturated)
    if damping <= 0.0:
        broken.append("the linearised loop is unstable on the way: lower the bandwidth")
    summary |= {"theory_bound_deg": None, "theory_bound_deg_reason": "the body slides: see position_bound_mm"}
    summary |= {"within_bound": kept if not broken else None, "broken_assumptions": broken}
    if broken:
        summary["within_bound_reason"] = "; ".join(broken)
    share = float(reshaped.mean()) if len(reshaped) else 0.0
    summary |= place_words(setup, actual, error, broken, share)
    summary["assumptions"] = list(ASSUMED)
    summary["reasons"] = _reasons(setup, reshaped, broken)
    if drawn is not None:
        summary["over_draws"] = drawn
    return TwoMotorTracking(
        summary=summary,
        time=np.asarray(gains.interval * np.arange(len(record)), dtype=np.float64),
        reference=wanted,
        place=record[:, :m],
        tensions=tension,
        torques=torque,
        incomplete=_incomplete(setup, done, tension, broken, drawn),
    )


def _broken(setup: Setup, force: Array, saturated: Flags) -> list[str]:
    """What the promise of the floor supposes and this run did not have."""
    design, machine, found = setup.design, setup.machine, []
    used = setup.plan.used(machine, design)
    if used > 1.0:
        low = setup.plan.tension.min(axis=0)
        i = int(np.argmin(low - design.gains.low))
        found.append(
            f"the motion uses {used:.2f} times what tension, torque and speed allow ({machine.lines[i]}: "
            f"{low[i]:.4g} N asked for, {design.gains.low[i]:.4g} N with its margin): take a longer rise"
        )
    gust = float(np.sqrt((force**2).sum(axis=1)).max(initial=0.0))
    if gust > design.gust * (1.0 + 1e-9):
        found.append(f"a force of {gust:.4g} N acts on the body, the promise is for {design.gust:.4g} N")
    if saturated.any():
        names = " and ".join(
            name
            for name, limit, t in zip(
                machine.motors, machine.numbers.limit, np.abs(setup.plan.torque).max(axis=0), strict=True
            )
            if t > limit
        )
        asked = f" (the motion itself asks {names} for more)" if names else ""
        found.append(f"the torque is at its limit at {saturated.mean():.2%} of the samples{asked}")
    return found


def _reasons(setup: Setup, reshaped: Flags, broken: list[str]) -> list[str]:
    """Why the position gave way to the tension."""
    share = float(reshaped.mean()) if len(reshaped) else 0.0
    if share < _TOLD:
        return []
    return [
        f"at {share:.1%} of the samples the wanted tensions were outside their limits and were moved to "
        "them: the position gives way, the tension does not",
        *broken,
    ]


def _incomplete(
    setup: Setup, done: PlantRun, tension: Array, broken: list[str], drawn: dict[str, Any] | None
) -> str | None:
    """What was not kept, and why; None where all was."""
    machine, floor = setup.machine, setup.design.floor
    why = "; ".join(broken) or "no assumption is broken: the margin is too small for this plant"
    if len(done.record) < len(setup.plan.table):
        return f"the run diverged at {len(done.record) * setup.design.gains.interval:.4g} s: {why}"
    i = int(np.argmin(done.least))
    if done.least[i] < floor:
        when = setup.design.gains.interval * int(np.argmin(tension[:, i]))
        return (
            f"{machine.lines[i]}: its tension fell to {done.least[i]:.4g} N near {when:.4g} s, below the "
            f"least allowed of {floor:.4g} N: {why}"
        )
    if drawn is not None and drawn["kept"] < drawn["draws"]:
        return (
            f"{drawn['draws'] - drawn['kept']} of {drawn['draws']} drawn plants let the tension fall below "
            f"{floor:.4g} N; the least was {drawn['least_tension']:.4g} N"
        )
    return None
