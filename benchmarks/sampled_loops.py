"""The closed loop of Model 4 in plain C, in plain numpy and in python-control: what the rig is measured with."""

import ctypes
import subprocess
import tempfile
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.linalg import expm

from cabledrive.control.numbers import NOMINAL, LawNumbers
from cabledrive.rig.closed_loop.chain_plant import linear_rates
from cabledrive.rig.closed_loop.loop import Loop

SOURCE = Path(__file__).with_name("closed_loop.c")
COMPILE = ["gcc", "-O3", "-march=native", "-ffast-math", "-fPIC", "-c"]


def compiled() -> ctypes.CDLL:
    """The C loop as a library."""
    folder = Path(tempfile.mkdtemp(prefix="closed-loop-"))
    subprocess.run([*COMPILE, str(SOURCE), "-o", str(folder / "loop.o")], check=True)
    # linked without -ffast-math, which would change the arithmetic of the whole process
    subprocess.run(
        ["gcc", "-shared", str(folder / "loop.o"), "-o", str(folder / "loop.so"), "-lm"], check=True
    )
    return ctypes.CDLL(str(folder / "loop.so"))


class InC:
    """The C loop on the numbers of a loop of the rig; a call runs it from rest and gives its largest error."""

    def __init__(self, library: ctypes.CDLL, loop: Loop):
        law, plant = loop.controller.law, np.array(friction(loop))
        tables = (law.matrix, law.rows, law.learning, law.scalars, loop.controller.reference, loop.target)
        self.inputs = [np.ascontiguousarray(table) for table in (*tables, transitions(loop), plant)]
        self.run, self.loop = library.closed_loop, loop

    def __call__(self) -> float:
        x, p, score = np.zeros(7), self.loop.controller.law.learning[NOMINAL].copy(), np.zeros(3)
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in self.inputs]
        outputs = [ctypes.c_void_p(array.ctypes.data) for array in (x, p, score)]
        limit = ctypes.c_double(self.loop.rig.torque_limit)
        self.run(ctypes.c_long(len(self.loop.target)), *pointers, limit, *outputs)
        return float(score[0])


@lru_cache(maxsize=8)
def transitions(loop: Loop) -> np.ndarray:
    """States after a sample from states, command, torques on motor and load, and a torque that rises."""
    interval, rates = loop.rig.interval, np.hstack(linear_rates(loop.chain, loop.plant.current_rate))
    m, size = rates.shape
    block = np.zeros((size + 1, size + 1))
    block[:m, :size] = rates
    block[m + 1, size] = 1.0 / interval
    return np.ascontiguousarray(expm(block * interval)[:m])


def friction(loop: Loop) -> tuple[float, float, float]:
    """Of the motor: Coulomb friction and offset [N m], slope of the smoothed friction [s/rad]."""
    plant = loop.plant
    return float(plant.coulomb[0]), float(plant.offset[0]), plant.smooth


def plant_step(loop: Loop, x: np.ndarray, u: float) -> np.ndarray:
    """States of the plant a sample on."""
    move, (coulomb, offset, slope) = transitions(loop), friction(loop)
    before = coulomb * np.tanh(slope * x[3])
    fresh = move @ np.concatenate((x, [u, offset - before, 0.0, 0.0]))
    return fresh + move[:, 10] * (before - coulomb * np.tanh(slope * fresh[3]))


def darc_step(
    law: LawNumbers, estimate: np.ndarray, states: np.ndarray, row: np.ndarray
) -> tuple[float, np.ndarray]:
    """Command [N m] of the law of Model 4 in numpy, adapting by its own motion, and the next estimates."""
    count, (surface, elastic, inertial) = len(states), law.rows
    nominal, low, high, gain, limit = law.learning
    interval, k_sigma, slope, by_reference, desired = law.scalars[:5]
    z = law.matrix @ states
    error = z - row[:count]
    sigma = surface[:count] @ error
    rate = inertial @ np.append(z, row[count] - surface[: count - 1] @ error[1:])
    friction = np.tanh(slope * (row[count + 1] if by_reference else states[count // 2]))
    regressor = np.array([-rate, -states[count // 2], -friction, 1.0])
    acting = -regressor @ estimate
    if desired:
        own, regressor = regressor, np.array([-row[count + 2], -row[count + 1], -friction, 1.0])
        acting = -nominal @ (own - regressor) - regressor @ estimate
    moved = interval * np.clip(gain * regressor * sigma, -limit, limit)
    return elastic[:count] @ z + acting - k_sigma * sigma, np.clip(estimate + moved, low, high)


class InNumpy:
    """The same loop in numpy, sample after sample."""

    def __init__(self, loop: Loop):
        self.loop = loop

    def __call__(self) -> float:
        loop, law = self.loop, self.loop.controller.law
        x, p, largest = np.zeros(7), law.learning[NOMINAL].copy(), 0.0
        for k, wanted in enumerate(loop.target):
            largest = max(largest, abs(x[2] - wanted))
            command, p = darc_step(law, p, x[:6], loop.controller.reference[k])
            x = plant_step(loop, x, np.clip(command, -loop.rig.torque_limit, loop.rig.torque_limit))
        return float(largest)


class InPythonControl:
    """The same loop as two sampled systems of python-control, connected; for a given number of samples."""

    def __init__(self, loop: Loop, samples: int):
        import control

        self.control, self.loop, self.samples = control, loop, samples
        law, interval = loop.controller.law, loop.rig.interval
        limit, n = loop.rig.torque_limit, law.matrix.shape[0]

        def decided(estimate, inputs):
            return darc_step(law, estimate, inputs[:n], inputs[n:])

        def estimates(t, estimate, inputs, params):
            return decided(estimate, inputs)[1]

        def command(t, estimate, inputs, params):
            return np.clip(decided(estimate, inputs)[0], -limit, limit)

        wanted = [f"r{i}" for i in range(n + 3)]
        plant = control.nlsys(
            lambda t, x, u, params: plant_step(loop, x, u[0]),
            lambda t, x, u, params: x[:n],
            states=7,
            inputs=["u"],
            outputs=[f"x{i}" for i in range(n)],
            dt=interval,
            name="plant",
        )
        made = control.nlsys(
            estimates,
            command,
            states=4,
            inputs=[*(f"x{i}" for i in range(n)), *wanted],
            outputs=["u"],
            dt=interval,
            name="law",
        )
        self.system = control.interconnect([plant, made], inputs=wanted, outputs=["x2"])

    def __call__(self) -> float:
        loop, count = self.loop, self.samples
        time = np.arange(count) * loop.rig.interval
        start = np.concatenate((np.zeros(7), loop.controller.law.learning[NOMINAL]))
        inputs = loop.controller.reference[:count].T
        found = self.control.input_output_response(self.system, time, inputs, start)
        return float(np.abs(np.ravel(found.outputs) - loop.target[:count]).max())
