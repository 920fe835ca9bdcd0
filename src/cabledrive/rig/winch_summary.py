"""What a run of two motors was in words, and the bound of the body's place."""

from math import pi
from typing import Any

import numpy as np

from cabledrive.parameters.arrays import Array
from cabledrive.reduction.two_motors import ASSUMED, TwoMotors
from cabledrive.rig.setting import none
from cabledrive.rig.tracking import Tracking
from cabledrive.rig.winch_plan import Setup
from cabledrive.rig.winch_run import PlantRun, bound_of_place, loop_poles, part_used

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


CONTROLLER = "tension-position"
OF_A_LOAD = (
    *("load_angle", "sigma", "estimates", "estimate_bounds", "angles", "speeds", "readings"),
    *("encoder_angles", "stuck"),
)
_AT_LIMIT, _AT_ONE = 1.0 - 1e-9, 1e-12
PLACES = 8
"""At which the poles of the loop are computed."""
_TOLD = 1e-3
"""Part of the samples from which reshaping is reported."""


def summarize(
    setup: Setup, actual: TwoMotors, done: PlantRun, force: Array, *, seed: int, drawn: dict[str, Any] | None
) -> Tracking:
    """Put a run of ``actual`` into words and arrays; ``force``, shape (samples, m): on the body [N]."""
    gains, design, machine = setup.design.gains, setup.design, setup.machine
    m, record = len(machine.names), done.record
    wanted = setup.table[: len(record), :m]
    error = record[:, :m] - wanted
    square, largest = (error**2).sum(axis=1), np.abs(error).max(axis=0)
    tension, torque, limit = record[:, m : m + 2], record[:, m + 2 : m + 4], machine.numbers.limit
    peaks = np.abs(torque).max(axis=0)
    # Of the samples: with a torque at its limit, with tensions that were reshaped.
    full = float(np.mean(np.any(np.abs(torque) >= _AT_LIMIT * limit, axis=1)))
    share = float(np.mean(record[:, m + 6] > 0.0))
    least = [float(value) if np.isfinite(value) else None for value in done.least]
    kept = len(record) == len(setup.table) and bool((done.least >= design.floor).all())
    summary: dict[str, Any] = {
        "controller": CONTROLLER,
        "plant": "body between two lines, exact geometry",
        "observer": "drum encoders and load cells",
        "gains": {
            "position_hz": gains.position / (2.0 * pi),
            "tension_hz": gains.tension / (2.0 * pi),
            "observer_hz": gains.observer / (2.0 * pi),
        },
        "peak_error_mm": 1e3 * float(np.sqrt(square.max())),
        "rms_error_mm": 1e3 * float(np.sqrt(square.mean())),
        "error_mm": dict(zip(machine.names, (1e3 * largest).tolist(), strict=True)),
        **none("peak_error_deg", "the body slides: see peak_error_mm"),
        **none("rms_error_deg", "the body slides: see rms_error_mm"),
        **none("estimates_within_bounds", "the law has no estimates with bounds"),
        "least_tension": float(done.least.min()) if None not in least else None,
        "least_allowed": design.floor,
        "tension_kept": kept,
        "lines": [
            {
                "name": machine.lines[i],
                "spans": list(machine.spans[i]),
                "least_tension": least[i],
                "largest_tension": float(tension[:, i].max()),
                "at_rest": float(machine.tension[i]),
                "least_allowed": design.floor,
                "margin": float(design.margin[i]),
            }
            for i in range(2)
        ],
        "motors": [
            {
                "name": machine.motors[i],
                "peak_torque": float(peaks[i]),
                "rms_torque": float(np.sqrt((torque[:, i] ** 2).mean())),
                "torque_limit": float(limit[i]),
            }
            for i in range(2)
        ],
        "peak_torque": float(peaks.max()),
        "saturated_fraction": full,
        "reshaped_fraction": share,
        "gust": design.gust,
        "motion": {
            "way": {
                name: float(setup.table[:, j].max() + setup.table[:, j].min())
                for j, name in enumerate(machine.names)
            },
            "used": setup.used,
        }
        | setup.task.words,
        "sample_rate": 1.0 / gains.interval,
        "internal_step": gains.interval / done.rig.substeps,
        "seed": seed,
    }
    places = setup.table[:: max(1, len(setup.table) // PLACES), :m]
    poles = np.concatenate([loop_poles(machine.numbers, gains, place, done.rig) for place in places])
    poles = poles[np.abs(poles) > _AT_ONE]
    summary["least_damping"] = damping = float((-poles.real / np.abs(poles)).min())
    broken = _broken(setup, force, full)
    if damping <= 0.0:
        broken.append("the linearised loop is unstable on the way: lower the bandwidth")
    summary |= none("theory_bound_deg", "the body slides: see position_bound_mm")
    summary |= {"within_bound": kept if not broken else None, "broken_assumptions": broken}
    if broken:
        summary["within_bound_reason"] = "; ".join(broken)
    bound = bound_of_place(setup)
    used, named = part_used(bound, error), list(broken)
    if not used <= 1.0:  # in what the run differs from what the bound supposes
        for key, words in NAMES.items():
            ours, theirs = getattr(machine.numbers, key), getattr(actual, key)
            off = float(np.max(np.abs(theirs - ours) / np.maximum(np.abs(ours), 1e-12), initial=0.0))
            named += [f"{words} {100.0 * off:.0f} % off"] if off > 1e-9 else []
        if share > 0.0:
            named.append(f"wanted tensions were reshaped at {share:.1%} of the samples")
        named += ALWAYS
    summary |= {
        "position_bound_mm": dict(zip(machine.names, (1e3 * bound).tolist(), strict=True)),
        "position_bound_used": used,
        "position_within_bound": None if named else True,
        "position_broken_assumptions": named,
        "assumptions": list(ASSUMED),
        "reasons": [],
    }
    if share >= _TOLD:  # the position gave way to the tension
        words = f"at {share:.1%} of the samples the wanted tensions were outside their limits and were moved"
        summary["reasons"] = [f"{words} to them: the position gives way, the tension does not", *broken]
    if drawn is not None:
        summary["over_draws"] = drawn
    return Tracking(
        summary=summary,
        time=np.asarray(gains.interval * np.arange(len(record)), dtype=np.float64),
        unit=setup.task.unit,
        reference=wanted,
        place=record[:, :m],
        error=error,
        tensions=tension,
        torque=torque,
        incomplete=_incomplete(setup, done, tension, broken, drawn),
        bound=None,
        **dict[str, Any](dict.fromkeys(OF_A_LOAD, np.zeros(0))),
    )


def _broken(setup: Setup, force: Array, full: float) -> list[str]:
    """What the promise of the floor supposes and this run did not have."""
    design, machine, used, found = setup.design, setup.machine, setup.used, []
    if used > 1.0:
        low = setup.tension.min(axis=0)
        i = int(np.argmin(low - design.gains.low))
        found.append(
            f"the motion uses {used:.2f} times what tension, torque and speed allow ({machine.lines[i]}: "
            f"{low[i]:.4g} N asked for, {design.gains.low[i]:.4g} N with its margin): take a longer rise"
        )
    gust = float(np.sqrt((force**2).sum(axis=1)).max(initial=0.0))
    if gust > design.gust * (1.0 + 1e-9):
        found.append(f"a force of {gust:.4g} N acts on the body, the promise is for {design.gust:.4g} N")
    if full > 0.0:
        beyond = np.abs(setup.torque).max(axis=0) > machine.numbers.limit
        names = " and ".join(name for name, so in zip(machine.motors, beyond, strict=True) if so)
        asked = f" (the motion itself asks {names} for more)" if names else ""
        found.append(f"the torque is at its limit at {full:.2%} of the samples{asked}")
    return found


def _incomplete(
    setup: Setup, done: PlantRun, tension: Array, broken: list[str], drawn: dict[str, Any] | None
) -> str | None:
    """What was not kept, and why; None where all was."""
    machine, floor = setup.machine, setup.design.floor
    why = "; ".join(broken) or "no assumption is broken: the margin is too small for this plant"
    if len(done.record) < len(setup.table):
        return f"the run diverged at {len(done.record) * setup.design.gains.interval:.4g} s: {why}"
    i = int(np.argmin(done.least))
    if done.least[i] < floor:
        when = setup.design.gains.interval * int(np.argmin(tension[:, i]))
        said = f"{machine.lines[i]}: its tension fell to {done.least[i]:.4g} N near {when:.4g} s"
        return f"{said}, below the least allowed of {floor:.4g} N: {why}"
    if drawn is not None and drawn["kept"] < drawn["draws"]:
        return (
            f"{drawn['draws'] - drawn['kept']} of {drawn['draws']} drawn plants let the tension fall below "
            f"{floor:.4g} N; the least was {drawn['least_tension']:.4g} N"
        )
    return None
