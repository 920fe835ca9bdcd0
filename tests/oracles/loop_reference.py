"""The loop of the rig for the reader: the compiled run, a sample at a time, for laws of the chain.

The plant is that of `oracles.readable_plant`, the law that of the benchmark's numpy loop, encoders and filter
stand here; no kernel is run.
"""

import numpy as np
from benchmarks.sampled_loops import darc_step

from cabledrive.control.numbers import KALMAN, NOMINAL
from oracles.readable_plant import ReadablePlant


def run_reference(loop, samples):
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
            scalars = observer.scalars
            torques = [held, older, newest]  # of the shaft, commands before and after the delay has passed
            friction = scalars[5] * np.tanh(scalars[6] * believed[n])
            believed = observer.model @ np.concatenate((believed, torques, [scalars[7] - friction]))
            held = float(scalars[2:5] @ torques)
        commands[k] = newest
        moving, slip = plant.moved(moving, slip, float(newest), rig.interval)
    return commands, angles
