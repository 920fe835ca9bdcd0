"""What comes out of a run of a machine whose bodies travel: lengths and directions of spans follow them."""

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.network.result import NetworkResult, left_out
from cabledrive.simulation.run import Outcome
from cabledrive.simulation.travel.case import TravelCase
from cabledrive.simulation.travel.plan import DENSITY, ROPES, TALLIES, TravelState

PARALLEL = 1e-3
"""Sine of the angle by which spans may turn without inertia of the ropes across them counting."""

_ASSUMPTIONS = (
    "ropes are straight between pulleys: no vibration across them, no sag",
    "ropes stick to pulleys (see the friction that needs) and have no mass on them; on a drum they stay in "
    "one layer and keep the tension of their span",
)
_ACROSS = "ropes have weight but no inertia across their spans"


def travel_result(case: TravelCase, outcome: Outcome) -> NetworkResult:
    """Result of a run, as far as it went."""
    rows, state = outcome.rows, outcome.state
    columns = {channel.name: k for k, channel in enumerate(case.channels)}
    first, last = columns["rope_energy"], columns["balance"] - TALLIES
    # Strain and springs count from the start: at rest they are large, and nothing happens to them.
    moving = rows[:, first : first + 2].sum(axis=1)
    work = np.abs(rows[:, last]) if len(rows) else np.zeros(1)
    extremes = np.where(np.isfinite(state.extremes), state.extremes, 0.0)
    return NetworkResult(
        **outcome.common(case),
        spans=case.spans,
        energy_handled=max(float(np.max(moving, initial=0.0)), float(np.max(work, initial=0.0))),
        energy_at_rest=float(rows[0, columns["strain_energy"]]) if len(rows) else 0.0,
        extremes={
            name: (float(low), float(high)) for name, low, high in zip(case.names, *extremes, strict=True)
        },
        midpoint_peaks={},
        largest_motion=0.0,
        assumptions=_assumptions(case),
        wraps=_wraps(case, state),
        doubts=_doubts(case, state) + _over_limits(case, rows),
        provenance=case.provenance(
            {"travels": True, "motor": "free" if case.move is None else "prescribed"},
            move=None if case.move is None else dict(case.move.moves),
            rise=None if case.move is None else case.move.rise,
            torque=[signal.fingerprint for signal in case.torques],
        ),
    )


def _assumptions(case: TravelCase) -> tuple[str, ...]:
    drive = case.network.drive
    torque = "torque: beyond what holds the machine at rest" if case.move is None else None
    plan = case.plan
    across: tuple[str, ...] = ()
    if any(_turns(case, s) for s in range(len(case.spans))):
        mass = float(np.sum(plan.piece[:, ROPES] * plan.piece[:, DENSITY] * case.length))
        carried = sum(body.mass for body in drive.body)
        across = (f"{_ACROSS}: {mass:.3g} kg of ropes beside {carried:.4g} kg of bodies",)
    return (*_ASSUMPTIONS, *across, *((torque,) if torque else ()), *left_out(drive))


def _turns(case: TravelCase, span: int) -> bool:
    """Whether a body can move an end of a span across it."""
    along = case.plan.bearing[span]
    across = np.array([-along[1], along[0]])
    sideways = np.einsum("c,icn->in", across, case.plan.frame[span])
    return bool(np.max(np.abs(sideways), initial=0.0) > PARALLEL)


def _wraps(case: TravelCase, state: TravelState) -> tuple[dict[str, float | str | None], ...]:
    """Largest friction coefficient that each wrap needed, beside the file's."""
    found: dict[str, dict[str, float | str | None]] = {}
    for s, span in enumerate(case.network.drive.free_spans):
        if span.wrap is None or span.end.pulley is None or case.plan.beyond[s, 1] < 0:
            continue
        needed = float(state.reached[1, s])
        before = found.get(span.end.name)
        if before is None or needed > float(before["needed_friction"] or 0.0):
            own = case.network.drive.pulley[span.end.pulley].capstan_friction
            found[span.end.name] = {"pulley": span.end.name, "needed_friction": needed, "friction": own}
    return tuple(found.values())


def _doubts(case: TravelCase, state: TravelState) -> tuple[str, ...]:
    """What the run assumed and did not keep to."""
    words = []
    for wrap in _wraps(case, state):
        needed, own = wrap["needed_friction"], wrap["friction"]
        if isinstance(own, float) and isinstance(needed, float) and needed > own:
            words.append(
                f"the rope would slip on {wrap['pulley']}: it needs a friction coefficient of {needed:.3g}, "
                f"capstan_friction is {own:.3g}; the run holds it fast"
            )
    return tuple(words)


def _over_limits(case: TravelCase, rows: Array) -> tuple[str, ...]:
    """Where the run asks more of a motor than the file allows."""
    drive, words = case.network.drive, []
    columns = {channel.name: k for k, channel in enumerate(case.channels)}
    for motor, name, rotor in zip(drive.motor, case.motors, case.plan.rotor, strict=False):
        asked = (
            ("torque", motor.torque_limit, f"torque on {name}", "N m"),
            ("speed", motor.speed_limit, f"speed of {case.names[int(rotor)]}", "rad/s"),
        )
        for what, limit, channel, unit in asked:
            largest = float(np.max(np.abs(rows[:, columns[channel]]), initial=0.0))
            if limit is not None and largest > limit:
                words.append(
                    f"the {what} of {name} reaches {largest:.4g} {unit}, above {what}_limit = {limit:.4g}: "
                    "move more slowly"
                )
    return tuple(words)
