"""The loop of the rig around parts of the user's own: sample by sample from Python, or compiled.

Encoders, filter, limit, delay and the packaged plants are the compiled parts of the other loops; only what
the user gives runs as it is given.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from cabledrive.control.controller_kernels import controller_step, issue, observe
from cabledrive.control.own_controller import OwnController, stepped
from cabledrive.parameters import InputRefused
from cabledrive.rig.closed_loop.cable_kernels import cable_ends, move_cable
from cabledrive.rig.closed_loop.cable_plant import cable_parts
from cabledrive.rig.closed_loop.chain_kernels import VIEW, move_chain, see_chain
from cabledrive.rig.closed_loop.loop_numbers import DIVERGED, Array, LoopState, farthest, finish_sample, sense
from cabledrive.rig.closed_loop.own_plant import moved

Decide = Callable[[int], tuple[float, float, float]]
Ends = Callable[[], int]
Moves = Callable[[int], int]


def run_by_sample(loop: Any, first: int, last: int, state: LoopState, log: Array, tensions: Array) -> int:
    """Run samples ``first`` to ``last`` - 1 of a loop; returns the sample at which the run ended."""
    ends, moves = _plant(loop, state, tensions)
    lumped = loop.cable is None and loop.own_plant is None
    decides = _controller(loop, state)
    shafts = (state.terms[VIEW] if lumped else state.x)[: 2 * loop.chain.size + 1]
    for k in range(first, last):
        state.discrete[1] = ends()
        if state.discrete[1]:
            return k
        wanted, command, sigma = decides(k)
        slip = int(state.discrete[0]) if loop.cable is None else int(shafts[loop.chain.size] != 0.0)
        finish_sample(loop.rig, loop.target, k, state, log, shafts, wanted, command, sigma, slip)
        state.discrete[1] = moves(k)
        if state.discrete[1]:
            return k + 1
    return last


def _when(loop: Any, k: int) -> str:
    return f"at t = {k * loop.rig.interval:.6g} s (sample {k})"


def _controller(loop: Any, s: LoopState) -> Decide:
    """One sample of the controller: command wanted, limited command, sigma."""
    made, rig, observer, c = loop.controller, loop.rig, loop.observer, s.controller
    seen = s.work if loop.cable is None and loop.own_plant is None else s.x
    own: OwnController | None = made.own

    def packaged(k: int) -> tuple[float, float, float]:
        sense(observer, rig, k, seen, s)
        wanted, command, sigma, valid = controller_step(
            observer, made.law, rig.torque_limit, c, s.readings, made.reference, k
        )
        s.summary[6] += not valid
        return wanted, command, sigma

    def users(k: int) -> tuple[float, float, float]:
        assert own is not None
        sense(observer, rig, k, seen, s)
        valid, torque = observe(observer, c, s.readings), 0.0
        measurement = s.readings if own.measures == "readings" else c.states
        valid = valid and bool(np.all(np.isfinite(s.readings)))
        if valid:
            given = (c.memory.copy(), measurement.copy(), made.reference[k].copy())
            c.memory[:], torque = stepped(own, *given, _when(loop, k))
        s.summary[6] += not valid
        wanted, command = issue(observer, rig.torque_limit, c, torque, valid)
        return wanted, command, 0.0

    return packaged if own is None else users


def _plant(loop: Any, s: LoopState, tensions: Array) -> tuple[Ends, Moves]:
    """Why the plant ends the run at a sample, 0 where it goes on; and its motion to the next."""
    rig, gone = loop.rig, farthest(loop.target)
    if loop.own_plant is not None:
        return _own_plant(loop, s, gone)
    if loop.cable is not None:
        cable = loop.cable
        moving, work, space = cable_parts(cable, s)
        parts = (cable.case.plan, moving)
        return (
            lambda: cable_ends(*parts, cable.numbers, gone, s),
            lambda k: move_cable(*parts, work, cable.numbers, rig, k, s, tensions, *space),
        )

    plant = loop.plant

    def moves(k: int) -> int:
        move_chain(plant, rig, k, s, 0.0, 0.0)
        return 0

    return lambda: see_chain(plant, gone, s), moves


def _own_plant(loop: Any, s: LoopState, gone: float) -> tuple[Ends, Moves]:
    rig, n, rate = loop.rig, loop.chain.size, loop.plant.current_rate
    kept = s.x[2 * n + 1 :]

    def ends() -> int:
        s.x[: 2 * n] = kept[: 2 * n]
        if n > 1:
            s.summary[7] = max(s.summary[7], abs(s.x[n - 2] - s.x[n - 1]))
        return DIVERGED if abs(s.x[n - 1]) > gone else 0

    def moves(k: int) -> int:
        span = rig.interval + (rig.jitter[k + 1] - rig.jitter[k] if rig.jitter.size else 0.0)
        push, shaft = (float(rig.forces[k, 0]), float(rig.forces[k, 1])), float(s.x[2 * n])
        state, place = kept.copy(), _when(loop, k)
        for command, time in zip(s.controller.commands, (rig.late_part, span - rig.late_part), strict=False):
            if time > 0.0:
                asked = (shaft, float(command))
                state, shaft = moved(loop.own_plant, state, asked, push, time, rate, loop.pieces, place)
        kept[:], s.x[2 * n] = state, shaft
        return 0

    return ends, moves


def run_own(loop: Any, first: int, last: int, state: LoopState, log: Array) -> int | None:
    """Run samples ``first`` to ``last`` - 1; returns where it ended, None where numba cannot compile it."""
    from numba.core.errors import NumbaError

    from cabledrive.rig.closed_loop.loop_kernels import NOT_FINITE, own_loop

    made, own = loop.controller, loop.controller.own
    try:
        _check_once(own, state, made.reference[first])
    except NumbaError as error:
        line = str(error).strip().splitlines()[0]
        raise InputRefused(
            f'controller "{own.name}" cannot be compiled: {line}: give it as plain Python'
        ) from None
    run = own_loop(own.step, own.measures == "states")
    try:
        ended = run(
            loop.plant, loop.observer, own.gains, loop.rig, made.reference, loop.target, first, last,
            state, log,
        )  # fmt: skip
    except NumbaError:
        return None
    if state.discrete[1] == NOT_FINITE:
        raise InputRefused(
            f'controller "{own.name}" returned a command or a state that is not finite, or of another size, '
            f"at t = {ended * loop.rig.interval:.6g} s (sample {ended}): a command must be a finite torque"
        )
    return int(ended)


def _check_once(own: OwnController, state: LoopState, reference: Array) -> None:
    """Step once on zeros, for the shapes of what is returned; a number need not be finite there."""
    size = len(state.readings) if own.measures == "readings" else len(state.controller.states)
    stepped(
        own, state.controller.memory.copy(), np.zeros(size), reference.copy(), "when it was tried on zeros"
    )
