"""The loop of the rig for the reader: the compiled run, a sample at a time, for laws of the chain.

The plant is that of `oracles.readable_plant`, the law that of the benchmark's numpy loop, encoders and filter
stand here; no kernel is run.
"""

import numpy as np
from benchmarks.sampled_loops import darc_step

from cabledrive.control.numbers import KALMAN, NOMINAL
from cabledrive.parameters.arrays import Array
from cabledrive.rig.closed_loop.loop import Loop
from oracles.readable_plant import ReadablePlant


def run_reference(loop: Loop, samples: int) -> tuple[Array, Array]:
    """Commands and load angles of a run with Kalman filter or ideal states, without delay and jitter.

    Returns ``commands, load_angles``, shape (samples,) [N m], [rad] at the first shaft.
    """
    rig, observer, law, n = loop.rig, loop.observer, loop.controller.law, loop.chain.size
    plant = ReadablePlant(chain=loop.chain, rate=loop.plant.current_rate)
    moving, slip, held, newest = [0.0] * (2 * n + 1), 0, 0.0, 0.0
    believed, estimate = np.zeros(observer.model.shape[0]), law.learning[NOMINAL].copy()
    commands, angles = np.zeros(samples), np.zeros(samples)
    for k in range(samples):
        x = np.array(moving)
        angles[k] = x[n - 1]
        if observer.kind == KALMAN:
            counts = np.rint(x[rig.encoders] / rig.counts + rig.phases)
            gain = observer.gains[min(k, len(observer.gains) - 1)]
            believed += gain @ (rig.counts * counts - observer.output @ believed)
            states = believed[observer.chosen]
        else:
            states = x[observer.chosen]
        command, estimate = darc_step(law, estimate, states, loop.controller.reference[k])
        older, newest = newest, np.clip(command, -rig.torque_limit, rig.torque_limit)
        if observer.kind == KALMAN:
            believed, held = predicted(observer.model, observer.scalars, n, believed, held, older, newest)
        commands[k] = newest
        moving, slip = plant.moved(moving, slip, float(newest), rig.interval)
    return commands, angles


def predicted(
    model: Array, scalars: Array, size: int, believed: Array, held: float, older: float, newest: float
) -> tuple[Array, float]:
    """The filter's states and its shaft torque one sample on.

    ``model``, shape (states, states + 4); ``scalars``, shape (9,); ``size``: number of inertias of the
    filter's model; ``believed``, shape (states,); ``held``: shaft torque [N m]; ``older``, ``newest``:
    commands before and after the delay has passed [N m].
    Returns ``believed``, shape (states,).
    """
    friction = scalars[5] * np.tanh(scalars[6] * believed[size])
    fresh = model @ np.concatenate((believed, [held, older, newest, scalars[7] - friction]))
    return fresh, float(scalars[2:5] @ [held, older, newest])
