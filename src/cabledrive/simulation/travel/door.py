"""One run of a machine whose bodies travel: lengths and directions of spans follow them."""

from math import degrees

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import why_plain
from cabledrive.parameters.schema import content_hash
from cabledrive.parameters.version import __version__
from cabledrive.simulation.network.result import NetworkResult, left_out
from cabledrive.simulation.plan import DONE, NOT_FINITE, SLACK, copy_state
from cabledrive.simulation.records import Records
from cabledrive.simulation.run import Outcome, loaded
from cabledrive.simulation.travel.case import TravelCase
from cabledrive.simulation.travel.plan import (
    DENSITY,
    NO_SPAN,
    OFF_THE_PULLEY,
    ROPES,
    TALLIES,
    TOO_SHORT,
    TravelState,
    TravelWorkspace,
)


class TravelStepper:
    """Takes the steps of a run in which bodies travel; see `cabledrive.simulation.records`."""

    def __init__(self, case: TravelCase) -> None:
        self.case = case
        self._work = new_travel_workspace(case)
        self._before = np.zeros((len(case.spans), 2))
        self._no_fields = np.zeros((0, 3, case.nodes))

    def chunk(self, state: TravelState, done: int, count: int) -> tuple[Array, Array, str | None]:
        """Steps of some records; returns what was recorded and why it is less than asked for, if so."""
        case, every = self.case, self.case.grid.every
        given = case.given(done * every, count * every)
        bad = np.flatnonzero(~np.isfinite(given).all(axis=1))
        whole = int(bad[0]) // every if bad.size else count
        rows, given = np.zeros((whole, case.width)), given[: whole * every]
        code = self._integrate(state, given, every, rows)
        if code == DONE:
            step = done * every + int(bad[0]) if bad.size else 0
            words = f"the torque is not finite at t = {step * case.grid.step:.6g} s" if bad.size else None
            return rows, self._no_fields, words
        made = -(-int(state.counts[0]) // every) - done - (1 if code == NOT_FINITE else 0)
        return rows[: max(made, 0)], self._no_fields, _stopped(case, state, code)

    def last(self, state: TravelState) -> tuple[Array, Array, str | None]:
        """The record at the end of the run, of a step beyond it that is taken back but for the extremes."""
        beyond, rows = copy_state(state), np.zeros((1, self.case.width))
        code = self._integrate(beyond, self.case.given(self.case.grid.steps, 1), 1, rows)
        for name in ("extremes", "reached", "events"):
            getattr(state, name)[...] = getattr(beyond, name)
        return rows, self._no_fields, None if code == DONE else _stopped(self.case, beyond, code)

    def _integrate(self, state: TravelState, given: Array, every: int, rows: Array) -> int:
        from cabledrive.simulation.travel.kernels import integrate_travel

        return int(integrate_travel(self.case.plan, state, self._work, given, every, rows, self._before))


def new_travel_workspace(case: TravelCase) -> TravelWorkspace:
    """Room for what is filled anew at each step."""
    n, spans, cells = len(case.names), len(case.spans), case.nodes
    frictions = case.plan.bound.size
    return TravelWorkspace(
        along=np.zeros((spans, 2)),
        free=np.zeros(spans),
        pull=np.zeros((spans, 2, 3)),
        tension=np.zeros(cells + spans),
        damped=np.zeros(cells + spans),
        rate=np.zeros(cells),
        pivot=np.zeros(cells),
        trial=np.zeros(cells),
        rows=np.zeros((spans, 2, n)),
        across=np.zeros((spans, 2, n)),
        speed=np.zeros((spans, 2)),
        matrix=np.zeros((2, n, n)),
        elimination=np.zeros((n, 2 * n)),
        force=np.zeros(n),
        carried=np.zeros(n),
        fallen=np.zeros(n),
        right=np.zeros(n),
        new=np.zeros(n),
        friction=np.zeros(frictions),
        bound=np.zeros(frictions),
        torque=np.zeros(len(case.motors)),
        kept=np.zeros((4, max(n, spans, cells, TALLIES))),
    )


def _stopped(case: TravelCase, state: TravelState, code: int) -> str:
    """Why a run stopped, in one line."""
    when = f"at t = {state.counts[0] * case.grid.step:.6g} s"
    span, figure = case.network.drive.free_spans[int(state.events[0, 0])], float(state.events[0, 1])
    if code == SLACK:
        return f"span {span.name} goes slack {when}: move more slowly, or raise pretension"
    if code == TOO_SHORT:
        return (
            f"span {span.name} is {figure:.4g} m long {when}: the step of {case.grid.step:.4g} s is stable "
            f"down to {case.plan.shortest[int(state.events[0, 0])]:.4g} m: go less far"
        )
    if code == OFF_THE_PULLEY:
        return f"the rope leaves {span.end.name} {when} (wrap {degrees(figure):.3g} deg): go less far"
    if code == NO_SPAN:
        return f"span {span.name} has no free length any more {when}: go less far"
    return f"diverged {when}: lower the input, or give a smaller step"


PARALLEL = 1e-3
"""Sine of the angle by which spans may turn without inertia of the ropes across them counting."""

_ASSUMPTIONS = (
    "ropes are straight between pulleys: no vibration across them, no sag",
    "ropes stick to pulleys (see the friction that needs) and have no mass on them; on a drum they stay in "
    "one layer and keep the tension of their span",
)
_ACROSS = "ropes have weight but no inertia across their spans"


def travel_result(case: TravelCase, records: Records, outcome: Outcome) -> NetworkResult:
    """Result of a run, as far as it went."""
    rows, state = loaded(records.arrays()[0][: outcome.records]), outcome.state
    columns = {channel.name: k for k, channel in enumerate(case.channels)}
    first, last = columns["rope_energy"], columns["balance"] - TALLIES
    # Strain and springs count from the start: at rest they are large, and nothing happens to them.
    moving = rows[:, first : first + 2].sum(axis=1)
    work = np.abs(rows[:, last]) if len(rows) else np.zeros(1)
    extremes = np.where(np.isfinite(state.extremes), state.extremes, 0.0)
    return NetworkResult(
        time=np.arange(len(rows), dtype=np.float64) * case.grid.interval,
        rows=rows,
        channels=case.channels,
        spans=case.spans,
        steps=int(state.counts[0]),
        step=case.grid.step,
        largest_step=case.grid.largest_step,
        energy_handled=max(float(np.max(moving, initial=0.0)), float(np.max(work, initial=0.0))),
        energy_at_rest=float(rows[0, columns["strain_energy"]]) if len(rows) else 0.0,
        extremes={
            name: (float(low), float(high)) for name, low, high in zip(case.names, *extremes, strict=True)
        },
        midpoint_peaks={},
        slack_events=(),
        largest_motion=0.0,
        assumptions=_assumptions(case),
        wraps=_wraps(case, state),
        doubts=_doubts(case, state) + _over_limits(case, rows),
        provenance={
            "cabledrive": __version__,
            "drive": case.network.drive.name,
            "drive_hash": content_hash(case.network.drive),
            "method": {
                "name": "verlet",
                "travels": True,
                "model": "exact",
                "compiled": why_plain() is None,
                "interpreted": why_plain(),
                "segments": case.scheme.segments,
                "step": case.grid.step,
                "largest_step": case.grid.largest_step,
                "motor": "free" if case.move is None else "prescribed",
                "friction": case.scheme.friction,
                "slack": case.scheme.slack,
            },
            "move": None if case.move is None else dict(case.move.moves),
            "rise": None if case.move is None else case.move.rise,
            "torque": [signal.fingerprint for signal in case.torques],
        },
        stopped=outcome.stopped,
        wall_time=outcome.wall_time,
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
