"""The compiled loop of the rig around a compiled controller of the user's own, on a lumped chain."""

from collections.abc import Callable
from functools import lru_cache
from math import isfinite
from typing import Any

from cabledrive.control.controller_kernels import issue, observe
from cabledrive.control.numbers import ObserverNumbers
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.rig.closed_loop.chain_kernels import VIEW, ChainPlant, move_chain, see_chain
from cabledrive.rig.closed_loop.loop_numbers import Array, LoopState, RigNumbers
from cabledrive.rig.closed_loop.sample_kernels import farthest, finish_sample, sense

NOT_FINITE = 9
"""Why a run ended: the command or the state of the user's controller is not finite, or of another size."""


HELD = -1
"""No end: a reading is missing, and the last command is held."""


@njit_in_place
def before_step(
    plant: ChainPlant, observer: ObserverNumbers, rig: RigNumbers, k: int, gone: float, s: LoopState
) -> int:
    """A sample up to the user's step: why the run ends here, `HELD` where a reading is missing, else 0."""
    code = see_chain(plant, gone, s)
    if code != 0:
        return code
    sense(observer, rig, k, s.work, s)
    seen = observe(observer, s.controller, s.readings)
    for j in range(s.readings.size):
        seen = seen and isfinite(s.readings[j])
    return 0 if seen else HELD


@njit_in_place
def after_step(
    plant: ChainPlant, observer: ObserverNumbers, rig: RigNumbers, target: Array, k: int, torque: float,
    valid: bool, s: LoopState, log: Array,
) -> None:  # fmt: skip
    """A sample from the user's torque on: limit, filter, score, log, plant."""
    if not valid:
        s.summary[6] += 1.0
    wanted, command = issue(observer, rig.torque_limit, s.controller, torque, valid)
    seen = s.terms[VIEW, : s.x.size]
    finish_sample(rig, target, k, s, log, seen, wanted, command, 0.0, s.discrete[0])
    move_chain(plant, rig, k, s, 0.0, 0.0)


@lru_cache(maxsize=16)
def own_loop(step: Any, filtered: bool) -> Callable[..., int]:
    """The loop for a compiled step; it is compiled when it is first run, in each process.

    ``step``: compiled by numba; ``filtered``: whether it takes the filter's states, or the encoders'
    readings.
    """
    import numba

    def run_own_loop(  # arrays may be made here: numba counts their references
        plant: Any, observer: Any, gains: Any, rig: Any, reference: Array, target: Array, first: int,
        last: int, s: Any, log: Array,
    ) -> int:  # fmt: skip
        gone, memory = farthest(target), s.controller.memory
        for k in range(first, last):
            code, torque = before_step(plant, observer, rig, k, gone, s), 0.0
            if code > 0:
                s.discrete[1] = code
                return k
            if code == 0:
                measurement = s.controller.states.copy() if filtered else s.readings.copy()
                state, torque = step(gains, memory.copy(), measurement, reference[k].copy())
                good = isfinite(torque) and len(state) == memory.size
                for i in range(memory.size):
                    if good:
                        memory[i] = state[i]
                        good = isfinite(memory[i])
                if not good:
                    s.discrete[1] = NOT_FINITE
                    return k
            after_step(plant, observer, rig, target, k, torque, code == 0, s, log)
        return last

    compiled: Callable[..., int] = numba.njit(error_model="numpy", nogil=True)(run_own_loop)
    return compiled
