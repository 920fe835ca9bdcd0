"""Which kernels a controller is on a target: of a packaged law, or around an own step."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cabledrive.control.numbers import start_estimates
from cabledrive.control.own_controller import stepped
from cabledrive.control.own_target_kernels import new_own_target_state, own_target_step, start_own
from cabledrive.control.target_kernels import new_target_state, start_target, target_step
from cabledrive.parameters import InputRefused
from cabledrive.rig.laws.controller_file import ControllerFile

Array = np.ndarray
GAINS = "numbers, arrays, or a tuple or NamedTuple of them"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TargetKernel:
    """Kernels of a controller, frozen numbers by name, a state before the start, values to begin with."""

    start: Callable[..., None]
    step: Callable[..., tuple[float, bool]]
    numbers: dict[str, Any]
    state: Any
    begin: Array


def target_kernel(law: ControllerFile) -> TargetKernel:
    """The kernels of a controller; refused: a user's gains that are no numbers, a step that returns none."""
    if law.own is None:
        return TargetKernel(
            start=start_target,
            step=target_step,
            numbers={"observer": law.observer, "law": law.law},
            state=new_target_state(law.observer, law.law, law.late_samples),
            begin=start_estimates(law.law),
        )
    begin, filtered = np.array(law.own.initial_state, dtype=np.float64), law.own.measures == "states"
    gains = as_numbers(law.own.gains, law.name)
    seen = len(law.observer.chosen if filtered else law.observer.output)
    tried = replace(law.own, gains=gains)
    stepped(tried, begin.copy(), np.zeros(seen), np.zeros(len(law.columns)), "when it was tried on zeros")
    return TargetKernel(
        start=start_own,
        step=own_target_step(law.own.step, filtered),
        numbers={"observer": law.observer, "own_numbers": gains},
        state=new_own_target_state(
            law.observer, law.law, law.late_samples, begin, len(law.columns), filtered
        ),
        begin=begin,
    )


def as_numbers(gains: Any, name: str) -> Any:
    """Gains of a controller of the user's own as a number, an array, or a NamedTuple of them."""
    if hasattr(gains, "_asdict"):
        return gains._replace(**{key: as_numbers(part, name) for key, part in gains._asdict().items()})
    if isinstance(gains, bool | int):
        return gains
    try:
        array = np.array(gains)
    except (TypeError, ValueError):
        array = np.array(None)
    if array.dtype.kind not in "iuf":
        raise InputRefused(f'controller "{name}": its gains cannot be exported: give {GAINS}')
    if array.dtype.kind == "f" and array.ndim == 0:
        return float(array)
    return array.astype(np.float64) if isinstance(gains, tuple | list) or array.dtype.kind == "f" else array
