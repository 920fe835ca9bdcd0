"""Machines and helpers that the tests of the control laws share."""

from typing import NamedTuple

import numpy as np

from cabledrive.control.numbers import ESTIMATES, ControllerState
from cabledrive.control.reference import carried_terms, flat_map
from cabledrive.identification.signals import lagged
from cabledrive.parameters import load_drive
from cabledrive.reduction.lumped_chain import LumpedChain, lumped_model, reflected
from cabledrive.rig.closed_loop.chain_kernels import move

DRIVE = load_drive("dissertation-3").listed
INTERVAL = 1.0 / 5000.0


def model(number):
    """Model of dissertation-3, in angles of the motor's shaft."""
    return reflected(lumped_model(DRIVE, number))[0]


def row_of(n, rng):
    """A damped lumped chain of n inertias with random, plausible numbers."""
    return LumpedChain(
        names=tuple(f"shaft {i}" for i in range(n)),
        inertias=tuple(rng.uniform(5e-4, 3e-3, n)),
        viscous=(0.003, *rng.uniform(0.0, 1e-3, n - 1)),
        coulomb=(0.04, *(0.0,) * (n - 1)),
        offsets=(0.001, *(0.0,) * (n - 1)),
        stiffness=tuple(rng.uniform(2.0, 200.0, n - 1)),
        damping=tuple(rng.uniform(0.005, 0.05, n - 1)),
        ratios=((1.0, 1.0),) * (n - 1),
    )


def flat_rows(flat, wanted, interval):
    """Rows of `flat_generator` from whole arrays of the wanted load angle and its derivatives."""
    for time in flat.time_constants:
        wanted = lagged(wanted, float(time), interval)
    return np.ascontiguousarray(wanted.T @ flat_map(flat))


def carried(chain, torque, interval):
    """Angles, then speeds, and motor torque that keep the load still under a torque with derivatives."""
    times, sources, output = carried_terms(chain)
    stages = [torque]
    for time, source in zip(times, sources, strict=True):
        stages.append(lagged(stages[source], time, interval))
    found = output @ np.concatenate(stages)
    return found[:-1].T, found[-1]


def state_of(states, estimate=(), memory=(), table=(0, 0), last=0.0):
    """What a law keeps, without a filter: angles and speeds, estimates, memory, last command."""
    parameters, held = np.zeros(ESTIMATES + 1), np.array([0.0, last])
    parameters[: len(estimate)] = estimate
    none = np.zeros(0)
    return ControllerState(
        sample=np.zeros(1, dtype=np.int64),
        estimate=none,
        held=held,
        parameters=parameters,
        memory=np.array(memory, dtype=float),
        commands=np.zeros(2),
        states=np.array(states, dtype=float),
        regressor=np.zeros(ESTIMATES + 1),
        work=np.zeros(20),
        table=np.zeros(table),
    )


# --- A lumped plant of the rig moved without a loop
class Moving(NamedTuple):
    x: np.ndarray
    terms: np.ndarray


def states_of(plant, commands, start=None):
    """States after each command, from rest or a state."""
    x = np.zeros(2 * len(plant.inertia) + 1) if start is None else np.array(start, dtype=float)
    s, found = Moving(x, np.zeros((5, len(x)))), []
    for u in commands:
        move(plant, s, float(u), 0.0, 0.0, 0.0, 0.0, 0.0, INTERVAL)
        found.append(x.copy())
    return np.array(found)
