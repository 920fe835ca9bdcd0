"""A motion repeated: a torque is learnt between repetitions on top of a law, until learning ends itself."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cabledrive.control.iterative_learning import (
    RepetitionLearning,
    lifted,
    repetition_learning,
    torque_along,
)
from cabledrive.control.numbers import GAIN, LEARNING, LINEAR
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.rig.closed_loop.loop import Loop, Run, run, with_plant
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.margins import closed_loop, response, sampled_controller, sampled_plant
from cabledrive.rig.plant_samples import corners
from cabledrive.rig.setting import DEGREE
from cabledrive.rig.tuning import ripple_limit

NODE_TIME = 4e-3
"""From node to node of the torque [s]."""
RIPPLE_SHARE = 0.2
"""Of the torque ripple that a comparison allows, for what rounding makes of the learnt torque."""
MOST_REPETITIONS = 100
PATIENCE, LEAST_GAIN = 2, 0.02
"""Repetitions without a smaller error by so much after which learning stops."""
ASSUMED = (
    "each repetition starts from rest at the same place",
    "motor and load slip: where they stick the loop is not the linear one of the proof",
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Repeated:
    """A motion repeated."""

    loop: Loop  # with the torque of the best repetition
    done: Run  # the best repetition
    words: dict[str, Any]  # errors of each repetition and the proof of convergence, for people and JSON


def repeat_motion(loop: Loop, spec: DesignSpec, repetitions: int) -> Repeated:
    """Run a motion several times and learn the torque that is missing along it.

    Learning goes by the load's encoder, which is all that a machine sees. It stops when the root mean square
    of its error has not fallen by 2 % for two repetitions; the best repetition is kept.
    """
    check_repeatable(loop, repetitions)
    done = run(loop)
    width = max(1, round(NODE_TIME / loop.rig.interval))
    nodes = len(loop.target) // width
    learning = design_learning(loop, spec, width, nodes)
    frozen, made = loop, loop.controller
    if made.law.kind == LEARNING:  # with the estimates of the first repetition: the proof is of a fixed loop
        count = made.law.learning.shape[1]
        start, table = np.zeros_like(made.start), made.law.learning.copy()
        start[:count], table[GAIN] = done.state.controller.parameters[:count], 0.0
        frozen = replace(loop, controller=replace(made, start=start, law=made.law._replace(learning=table)))
    place, best, errors = np.zeros(learning.directions.shape[1]), (loop, done), [_errors(loop, done)]
    radius = learning.radius(_mean_error(loop, done, width, nodes))
    waited, stopped = 0, f"{repetitions} repetitions, as asked"
    while len(errors) < repetitions:
        if done.failed:
            stopped = "a repetition ended before its time"
            break
        place = learning.corrected(place, _mean_error(loop, done, width, nodes), radius)
        torque, made = torque_along(learning.directions @ place, width, len(loop.target)), frozen.controller
        table = made.reference.copy()
        table[: len(torque), 2 * len(made.shafts)] += torque
        tried = replace(frozen, controller=replace(made, reference=table))
        done = run(tried)
        errors.append(_errors(tried, done))
        least = min(one["encoder_rms_deg"] for one in errors[:-1])
        waited = 0 if errors[-1]["encoder_rms_deg"] < (1.0 - LEAST_GAIN) * least else waited + 1
        if not done.failed and errors[-1]["encoder_rms_deg"] < least:
            best = tried, done
        if waited == PATIENCE:
            stopped = f"the error fell by less than {100 * LEAST_GAIN:g} % for {PATIENCE} repetitions"
            break
    words = {
        "repetitions": errors,
        "best": errors.index(min(errors, key=lambda one: one["encoder_rms_deg"])) + 1,
        "stopped": stopped,
        "contraction": learning.contraction,
        "directions": int(learning.directions.shape[1]),
        "assumed": list(ASSUMED),
    }
    return Repeated(loop=best[0], done=best[1], words=words)


def check_repeatable(loop: Loop, repetitions: int) -> None:
    """Refuse what cannot be repeated."""
    made = loop.controller
    if not 2 <= repetitions <= MOST_REPETITIONS:
        raise InputRefused(f"repeat = {repetitions} must be from 2 to {MOST_REPETITIONS}")
    if made.own is not None or loop.own_plant is not None:
        raise InputRefused("repeat needs a packaged law and plant, whose equations are known: leave it out")
    if made.law.kind not in (LINEAR, LEARNING):
        raise InputRefused(
            f"repeat adds a torque along the motion, and {made.name} takes none: take lqg, lqi, "
            "lqi-learning, pd or another law with a feedforward torque"
        )


def design_learning(loop: Loop, spec: DesignSpec, width: int, nodes: int) -> RepetitionLearning:
    """What is learnt between repetitions, with its contraction on the nominal plant and at eight corners."""
    believed = replace(loop, cable=None)
    chains = [spec.model(loop.controller.model), *corners(spec.model(loop.controller.model))]
    maps = [_lifted(with_plant(believed, chain), width, nodes) for chain in chains]
    noise, ripple = float(loop.rig.counts[-1]) / np.sqrt(12.0), RIPPLE_SHARE * ripple_limit(spec)
    found = repetition_learning(maps[0][0], [error for error, _ in maps[1:]], maps[0][1], noise, ripple)
    if found is None:
        raise NotComputed(
            "repeat: not one direction of the torque converges on every plant within the intervals: raise "
            "the bandwidth, or leave repeat out"
        )
    return found


def _lifted(loop: Loop, width: int, nodes: int) -> tuple[Array, Array]:
    """From torque at the nodes to the load's error, and to the whole command, in the linear loop."""
    controller, plant = sampled_controller(loop), sampled_plant(loop)
    matrix, _, command = closed_loop(controller, plant)
    push = np.concatenate((plant.b, controller.b[:, -1:]))
    push[-1] = 1.0  # the last command that the law remembers holds the added torque as well
    load = np.zeros(len(matrix))
    load[loop.chain.size - 1] = 1.0
    later = response(matrix, push, np.array((load, command)), nodes * width - 1)[:, :, 0]
    both = np.vstack(([0.0, 1.0], later))  # the added torque itself comes at once
    return lifted(both[:, 0], nodes, width), lifted(both[:, 1], nodes, width)


def _readings(loop: Loop, done: Run) -> Array:
    """What the load's encoder says of the error, shape (samples,) [rad at the first shaft]."""
    last = 2 * loop.chain.size + len(loop.rig.encoders)
    return np.asarray(done.log[: done.ended, last] - loop.target[: done.ended])


def _mean_error(loop: Loop, done: Run, width: int, nodes: int) -> Array:
    error = np.nan_to_num(_readings(loop, done))
    return np.asarray(error[: nodes * width].reshape(nodes, width).mean(axis=1))


def _errors(loop: Loop, done: Run) -> dict[str, Any]:
    """Root mean square by the load's encoder, and the largest true error [deg]."""
    seen, true = _readings(loop, done) / loop.gear / DEGREE, loop.load_error(done.log)[: done.ended] / DEGREE
    return {
        "encoder_rms_deg": float(np.sqrt(np.nanmean(seen**2))) if not done.failed else float("inf"),
        "peak_error_deg": float(np.abs(true).max()),
    }
