"""What comes out of a run of a machine whose bodies travel: lengths and directions of spans follow them."""

from collections.abc import Iterator
from typing import Any

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
        doubts=tuple(_doubts(case, state, rows)),
        provenance=case.provenance(
            {"travels": True, "motor": "free" if case.move is None else "prescribed"},
            move=None if case.move is None else dict(case.move.moves),
            rise=None if case.move is None else case.move.rise,
            torque=[signal.fingerprint for signal in case.torques],
        ),
    )


def _assumptions(case: TravelCase) -> tuple[str, ...]:
    drive, plan, found = case.network.drive, case.plan, list(_ASSUMPTIONS)
    sideways = np.stack([-plan.bearing[:, 1], plan.bearing[:, 0]], axis=1)
    if np.max(np.abs(np.einsum("sc,sicn->sin", sideways, plan.frame)), initial=0.0) > PARALLEL:
        mass = float(np.sum(plan.piece[:, ROPES] * plan.piece[:, DENSITY] * case.length))
        carried = sum(body.mass for body in drive.body)
        found.append(f"{_ACROSS}: {mass:.3g} kg of ropes beside {carried:.4g} kg of bodies")
    if case.move is None:
        found.append("torque: beyond what holds the machine at rest")
    return (*found, *left_out(drive))


def _wraps(case: TravelCase, state: TravelState) -> tuple[dict[str, Any], ...]:
    """Largest friction coefficient that each wrap needed, beside the file's."""
    found: dict[str, dict[str, Any]] = {}
    for s, span in enumerate(case.network.drive.free_spans):
        if span.wrap is None or span.end.pulley is None or case.plan.beyond[s, 1] < 0:
            continue
        name, needed = span.end.name, float(state.reached[1, s])
        if name not in found or needed > found[name]["needed_friction"]:
            own = case.network.drive.pulley[span.end.pulley].capstan_friction
            found[name] = {"pulley": name, "needed_friction": needed, "friction": own}
    return tuple(found.values())


def _doubts(case: TravelCase, state: TravelState, rows: Array) -> Iterator[str]:
    """What the run assumed and did not keep to, and where it asks more of a motor than the file allows."""
    for wrap in _wraps(case, state):
        needed, own = wrap["needed_friction"], wrap["friction"]
        if own is not None and needed > own:
            yield (
                f"the rope would slip on {wrap['pulley']}: it needs a friction coefficient of {needed:.3g}, "
                f"capstan_friction is {own:.3g}; the run holds it fast"
            )
    columns = {channel.name: k for k, channel in enumerate(case.channels)}
    for motor, name, rotor in zip(case.network.drive.motor, case.motors, case.plan.rotor, strict=False):
        asked = (
            ("torque", motor.torque_limit, f"torque on {name}", "N m"),
            ("speed", motor.speed_limit, f"speed of {case.names[int(rotor)]}", "rad/s"),
        )
        for what, limit, channel, unit in asked:
            largest = float(np.max(np.abs(rows[:, columns[channel]]), initial=0.0))
            if limit is not None and largest > limit:
                yield (
                    f"the {what} of {name} reaches {largest:.4g} {unit}, above {what}_limit = {limit:.4g}: "
                    "move more slowly"
                )
