"""A compiled controller of the user's own on a lumped chain: its compiled loop, checked at both ends."""

from typing import Any

import numpy as np

from cabledrive.control.own_controller import OwnController, stepped
from cabledrive.parameters import InputRefused
from cabledrive.rig.closed_loop.loop_numbers import Array, LoopState


def run_own(loop: Any, first: int, last: int, state: LoopState, log: Array) -> int | None:
    """Run samples ``first`` to ``last`` - 1; returns the sample at which the run ended.

    ``state``: moved on; ``log``: gets a row per sample, if it has rows.
    Returns none where numba cannot compile the loop around this controller; nothing has been run then.
    Raises `InputRefused` if the step cannot be compiled, or returns what it must not.
    """
    from numba.core.errors import NumbaError

    from cabledrive.rig.closed_loop.own_kernels import NOT_FINITE, own_loop

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
