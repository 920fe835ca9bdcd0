"""A plant of the user's own in the rig's loop: its checks, a step between samples."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from math import exp
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.control.controller_kernels import issue, observe
from cabledrive.control.own_controller import is_compiled, stepped
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import described, meaning
from cabledrive.reduction.lumped_chain import LumpedChain, highest_model, reflected
from cabledrive.rig.closed_loop import chain_kernels as kernels
from cabledrive.rig.closed_loop.cable_plant import cable_ends, move_cable
from cabledrive.rig.closed_loop.chain_kernels import LoopState
from cabledrive.rig.closed_loop.loop_kernels import NotFinite, loop_over, move_chain, own_loop, see_chain
from cabledrive.rig.laws.controllers import fitted_encoders, load_gear, plant_chain
from cabledrive.rig.setting import RigOptions

PIECE = 0.25
"""Longest time of a constant torque in a step of the plant, over the time constant of the torque loop."""


@described
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OwnPlant:
    """A plant of the user's own, for `cabledrive.track`, which takes any object with these attributes.

    All angles are at the first shaft: the load pulley's times r2 / r1; inertias there are divided by the
    square. Encoders, filter, controller, torque limit, delay and torque loop are the rig's.
    """

    step: Callable[[Any, Any, Any, float], Any] = meaning(
        "``step(parameters, state, torques, time) -> state``, plain Python or compiled: the state, (m,), "
        "after a time [s], any part of a sample, under constant torques on motor and load, (2,) [N m]"
    )
    initial_state: ArrayLike = meaning(
        "(m,): angles of the shafts [rad], their speeds [rad/s], then whatever else the plant keeps"
    )
    shafts: tuple[str, ...] = meaning(
        'what the first angles are: with a flexible joint ("motor", "drive", "load")',
        ("motor", "load"),
    )
    parameters: Any = meaning("handed to every step as they are", 0.0)
    name: str = meaning("how it is called", "own plant")


def checked_plant(given: Any) -> OwnPlant:
    """The user's plant as frozen data; ``given``: an object like `OwnPlant`; parameters may be absent."""
    words = " ".join(repr(given).split())
    if not callable(getattr(given, "step", None)) or isinstance(given, type):
        raise InputRefused(
            f"plant = {words[:60]} is no name, no LumpedChain and no plant: give an object with "
            "step(parameters, state, torques, time), such as cabledrive.OwnPlant"
        )
    own: dict[str, Any] = {one.name: getattr(given, one.name, one.default) for one in fields(OwnPlant)}
    name, shafts = str(own["name"]), tuple(own["shafts"])
    try:
        start = np.array(own["initial_state"], dtype=np.float64)
    except (TypeError, ValueError):
        start = np.zeros(0)
    if start.ndim != 1 or start.size < 2 * len(shafts) or not np.all(np.isfinite(start)):
        raise InputRefused(
            f'plant "{name}": initial_state must hold {len(shafts)} angles, then {len(shafts)} speeds, '
            f"all finite, and holds {start.size} numbers: give a list of numbers"
        )
    return OwnPlant(**own | {"initial_state": start, "shafts": shafts, "name": name})


def moved(
    loop: Any, state: Array, asked: tuple[float, float], push: tuple[float, float], time: float, place: str
) -> tuple[Array, float]:
    """The state after a time [s] under a constant command, and the torque of the loop behind which it acts.

    ``asked``: torque at the motor's shaft and the one asked for, ``push``: further torque on motor and load
    [N m]. Each piece gets the mean torque of the loop: its momentum is exact.
    """
    plant, rate, pieces = loop.own_plant, loop.plant.current_rate, loop.spec.options.substeps
    count = max(pieces, int(np.ceil(rate * time / PIECE)))
    part, (shaft, command) = time / count, asked
    for _ in range(count):
        mean = command
        if rate > 0.0:
            keep = exp(-rate * part)
            mean = command + (shaft - command) * (1.0 - keep) / (rate * part)
            shaft = command + (shaft - command) * keep
        else:
            shaft = command
        torques = np.array([mean + push[0], push[1]])
        try:
            fresh = np.array(plant.step(plant.parameters, state, torques, part), dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputRefused(f'plant "{plant.name}" failed {place}: {error}') from error
        if fresh.shape != state.shape or not np.all(np.isfinite(fresh)):
            what = "a state that is not finite" if fresh.shape == state.shape else f"shape {fresh.shape}"
            raise InputRefused(
                f'plant "{plant.name}" returned {what} {place}: return {state.size} finite numbers'
            )
        state = fresh
    return state, shaft


def models_of(drive: Drive) -> tuple[LumpedChain, ...]:
    """The lumped models of a drive under torque control, in angles of its first shaft."""
    numbers = (1, 2, 3, 4) if highest_model(drive) == 4 else (1, 3)
    return tuple(plant_chain(drive, number) for number in numbers)


def user_plant(drive: Drive, given: Any, options: RigOptions) -> tuple[LumpedChain, OwnPlant | None, str]:
    """The lumped chain that names the shafts, the plant where it is no lumped chain, and its name."""
    if isinstance(given, LumpedChain):
        chain = _at_first_shaft(drive, given)
        return chain, None, f"lumped chain of {chain.size} inertias: {', '.join(chain.names)}"
    plant = checked_plant(given)
    if options.smooth_friction:
        raise InputRefused(
            f'smooth_friction is about the packaged plants; "{plant.name}" has its own friction: leave it out'
        )
    for chain in models_of(drive):
        if chain.names == plant.shafts:
            return chain, plant, plant.name
    known = " or ".join(str(chain.names) for chain in models_of(drive) if chain.size > 1)
    raise InputRefused(
        f'plant "{plant.name}": shafts = {plant.shafts} are those of no model of {drive.name}: take {known}'
    )


def _at_first_shaft(drive: Drive, given: LumpedChain) -> LumpedChain:
    """The chain in angles of its first shaft; as given where it is so already."""
    if given.holding > 0.0:
        raise InputRefused(
            f"plant.holding = {given.holding:.4g} N m/rad: under torque control the motor turns freely: set 0"
        )
    chain, gears = reflected(given)
    gear = load_gear(drive)
    if not (np.isclose(gears[-1], 1.0, rtol=1e-9) or np.isclose(gears[-1], gear, rtol=1e-9)):
        raise InputRefused(
            f"plant.ratios make {gears[-1]:.6g} turns of the first shaft a turn of the load, r2 / r1 of the "
            f"drive is {gear:.6g}: give that, or all in angles of the first shaft"
        )
    of_a_model = chain.names in [one.names for one in models_of(drive)]
    if not of_a_model and (chain.names[-1] != "load" or chain.names[0] not in ("motor", "drive")):
        raise InputRefused(
            f"plant.names = {chain.names} must begin with motor and end with load: name them so"
        )
    if chain.size > 2 and "drive" in fitted_encoders(drive) and "drive" not in chain.names:
        raise InputRefused(
            f"plant.names = {chain.names} lack the drive pulley, whose encoder is read: name it drive"
        )
    return chain


def run_users(
    loop: Any, machine: Any, control: kernels.Control, span: tuple[int, int], state: LoopState, log: Array
) -> tuple[int, str | None]:
    """Run samples with a controller or a plant of the user's own, compiled where both can be.

    ``machine``: the packaged plant as it runs. Returns where the run ended, and what ran as plain Python.
    """
    own, plant = loop.controller.own, loop.own_plant
    if own is not None and is_compiled(own.step) and plant is None and loop.cable is None:
        done = run_own(loop, span, state, log)
        if done is not None:
            return done, None
    parts = {"controller": own, "plant": plant}
    named = [name for name, part in parts.items() if part is not None and not is_compiled(part.step)]
    plain = ", ".join(named) or "loop"
    see, move = (see_chain, move_chain) if loop.cable is None else (cable_ends, move_cable)
    if plant is not None:
        machine, see, move = loop, _see_own, _move_own  # type: ignore[assignment]  # each of its machine

    def decide(_: Any, control: kernels.Control, k: int, s: LoopState) -> tuple[float, float, float]:
        if own is None:
            return kernels.decide(None, control, k, s)
        kernels.sense(control.observer, control.rig, k, s)
        c, torque = s.controller, 0.0
        valid = observe(control.observer, c, s.readings) and bool(np.all(np.isfinite(s.readings)))
        if valid:
            measurement = s.readings if own.measures == "readings" else c.states
            given = (c.memory.copy(), measurement.copy(), control.reference[k].copy())
            c.memory[:], torque = stepped(own, *given, _when(loop, k))
        s.summary[6] += not valid
        wanted, command = issue(control.observer, control.rig.torque_limit, c, torque, valid)
        return wanted, command, 0.0

    return loop_over(see, decide, move)(machine, control, span, state, log), plain


def _when(loop: Any, k: int) -> str:
    return f"at t = {k * loop.rig.interval:.6g} s (sample {k})"


def _see_own(loop: Any, gone: float, s: LoopState) -> int:
    """Why the user's plant ends the run at a sample, 0 where it goes on."""
    n = loop.chain.size
    s.x[: 2 * n] = s.x[2 * n + 1 : 4 * n + 1]
    if n > 1:
        s.summary[7] = max(s.summary[7], abs(s.x[n - 2] - s.x[n - 1]))
    return kernels.DIVERGED if abs(s.x[n - 1]) > gone else 0


def _move_own(loop: Any, rig: kernels.RigNumbers, k: int, s: LoopState) -> int:
    """The user's plant to the next sample."""
    n = loop.chain.size
    span = rig.interval + (rig.jitter[k + 1] - rig.jitter[k] if rig.jitter.size else 0.0)
    push, shaft = (float(rig.forces[k, 0]), float(rig.forces[k, 1])), float(s.x[2 * n])
    state, place = s.x[2 * n + 1 :].copy(), _when(loop, k)
    for command, time in zip(s.controller.commands, (rig.late_part, span - rig.late_part), strict=False):
        if time > 0.0:
            state, shaft = moved(loop, state, (shaft, float(command)), push, time, place)
    s.x[2 * n + 1 :], s.x[2 * n] = state, shaft
    return 0


def run_own(loop: Any, span: tuple[int, int], state: LoopState, log: Array) -> int | None:
    """Run the samples of a span; returns where it ended, None where numba cannot compile it."""
    from numba.core.errors import NumbaError

    made, own = loop.controller, loop.controller.own
    try:
        # Once on zeros, for the shapes of what is returned; a number need not be finite there.
        size = len(state.readings) if own.measures == "readings" else len(state.controller.states)
        memory, row = state.controller.memory.copy(), made.reference[span[0]].copy()
        stepped(own, memory, np.zeros(size), row, "when it was tried on zeros")
    except NumbaError as error:
        line = str(error).strip().splitlines()[0]
        raise InputRefused(
            f'controller "{own.name}" cannot be compiled: {line}: give it as plain Python'
        ) from None
    asked, run = own_loop(own.step, own.measures == "states")
    try:
        asked(own.gains, memory, np.zeros(size), row)
        return int(run(loop.plant, loop.control._replace(law=own.gains), span, state, log))
    except NumbaError:
        return None
    except NotFinite:
        raise InputRefused(
            f'controller "{own.name}" returned a command or a state that is not finite, or of another size, '
            f"{_when(loop, int(state.discrete[0]))}: a command must be a finite torque"
        ) from None
