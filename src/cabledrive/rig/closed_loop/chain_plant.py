"""The lumped plant of the rig as its kernel takes it, and the linear motion of a chain."""

from math import inf
from typing import Any

import numpy as np

from cabledrive.reduction.lumped_chain import LumpedChain, state_space
from cabledrive.rig.closed_loop.chain_kernels import ChainPlant
from cabledrive.rig.closed_loop.loop_numbers import Array

PER_RADIAN, SLOPE = 12.0, 50.0
"""Internal steps per radian of the fastest mode; K of smoothed friction c tanh(K w) [s/rad]."""


def chain_numbers(
    chain: LumpedChain,
    interval: float,
    *,
    current_rate: float = 0.0,
    substeps: int = 1,
    smooth: bool = False,
    play: float = 0.0,
    slack: float = inf,
    twist_limit: float = inf,
    **more: Any,
) -> ChainPlant:
    """A chain in links between equal angles.

    ``interval``: sample time [s]; ``current_rate``: bandwidth of the torque loop [rad/s]; 0: none;
    ``substeps``: least number of internal steps per sample; ``play``: backlash of the first link, from end to
    end; ``slack``: twist of the last link beyond which one span of two is slack; ``more``: other fields of
    `ChainPlant`.
    """
    links = np.arange(chain.size - 1)
    plays, slacks = np.zeros(len(links)), np.full(len(links), inf)
    if len(links):
        plays[0], slacks[-1] = 0.5 * play, slack
    numbers = ChainPlant(
        inertia=np.array(chain.inertias),
        viscous=np.array(chain.viscous),
        coulomb=np.array(chain.coulomb),
        offset=np.array(chain.offsets),
        ends=np.column_stack((links, links + 1)).astype(np.int64),
        stiffness=np.array(chain.stiffness, dtype=np.float64),
        damping=np.array(chain.damping, dtype=np.float64),
        play=plays,
        slack=slacks,
        phases=np.zeros(3),
        motors=1,
        current_rate=float(current_rate),
        step=interval / substeps,
        twist_limit=float(twist_limit),
        smooth=SLOPE if smooth else 0.0,
    )._replace(**more)
    return in_steps(numbers, interval, substeps)


def in_steps(p: ChainPlant, interval: float, substeps: int) -> ChainPlant:
    """The plant with internal steps that resolve its fastest mode and its strongest damper."""
    springs, dampers = np.zeros(len(p.inertia)), p.viscous + p.smooth * p.coulomb
    for end in p.ends.T:
        np.add.at(springs, end, p.stiffness)
        np.add.at(dampers, end, p.damping)
    fastest = max(np.sqrt(2.0 * (springs / p.inertia).max()), (dampers / p.inertia).max() / 4.0)
    steps = max(substeps, int(np.ceil(interval * PER_RADIAN * fastest)))
    return p._replace(step=interval / steps)


def linear_rates(chain: LumpedChain, current_rate: float) -> Array:
    """Rates of angles, speeds and shaft torque from these, the command, torques on motor and load."""
    n = chain.size
    a, b = state_space(chain)
    rates = np.zeros((2 * n + 1, 2 * n + 4))
    rates[: 2 * n, : 2 * n], rates[: 2 * n, 2 * n] = a, b[:, 0]
    rates[2 * n, 2 * n : 2 * n + 2] = -current_rate, current_rate
    rates[: 2 * n, 2 * n + 2], rates[: 2 * n, 2 * n + 3] = b[:, 0], b[:, -1]
    return rates


def linear_step(chain: LumpedChain, interval: float, current_rate: float) -> Array:
    """The same after a sample instead of per second, motor slipping, shape (m, m + 3)."""
    from scipy.linalg import expm

    rates = linear_rates(chain, current_rate)
    block = np.zeros((rates.shape[1], rates.shape[1]))
    block[: len(rates)] = rates * interval
    return np.asarray(expm(block)[: len(rates)])
