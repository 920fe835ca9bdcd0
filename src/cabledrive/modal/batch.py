"""Certified longitudinal spectra of many drives of one build in one search."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import Chain, Pendant, own_chain
from cabledrive.modal.cuts import Cut
from cabledrive.modal.networks import network_of_chain
from cabledrive.modal.rows import Table, counted, lanes_at
from cabledrive.modal.search import ENCLOSURE, searched

Array = NDArray[np.float64]

MOST_TOGETHER = 4096
"""Drives that are searched together."""
MOST_DOUBLINGS = 40


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ChainBatch:
    """Chains of one build with numbers of their own, as `cabledrive.mechanics.chain.Chain` describes one."""

    times: Array  # (n, m): travel times of the segments [s]
    # masses, grounds: (n, j): masses of the joints [kg] and their springs to the ground [N/m]
    masses: Array
    grounds: Array
    impedance: Array  # (n,): wave impedance [kg/s]
    # (n, 3): stiffness [N/m], mass [kg] and stiffness to the ground [N/m] of the motor behind a flexible
    # joint, on the first joint; zeros where there is none
    pendant: Array


def batch_of(chains: Sequence[Chain]) -> ChainBatch:
    """Chains of one build as one batch."""
    pendants = [chain.pendant or Pendant(stiffness=0.0, mass=0.0) for chain in chains]
    return ChainBatch(
        times=np.array([chain.travel_times for chain in chains]),
        masses=np.array([chain.masses for chain in chains]),
        grounds=np.array([chain.ground_springs for chain in chains]),
        impedance=np.array([chain.impedance for chain in chains]),
        pendant=np.array([[own.stiffness, own.mass, own.ground] for own in pendants]),
    )


def many_spectra(chains: ChainBatch, wanted: int) -> tuple[Array, NDArray[np.bool_]]:
    """The first natural frequencies of each chain, proven by counts.

    Returns ``omega``, shape (n, wanted) [rad/s]; ``done``, shape (n,): false where a mode is multiple or
    round-off clouds a count, which the search of one chain settles.
    """
    n = chains.times.shape[0]
    omegas, done = np.full((n, wanted), np.nan), np.zeros(n, dtype=bool)
    for first in range(0, n, MOST_TOGETHER):
        here = slice(first, first + MOST_TOGETHER)
        omegas[here], done[here] = _spectra(chains, here, wanted)
    return omegas, done


def _spectra(chains: ChainBatch, here: slice, wanted: int) -> tuple[Array, NDArray[np.bool_]]:
    times = chains.times[here]
    n = times.shape[0]
    table = _table(chains, here)
    held = (chains.pendant[here, 2] > 0.0) | np.any(chains.grounds[here] > 0.0, axis=1)
    rigid = np.where(held, 0, 1)
    machine = np.arange(n)
    top = wanted * pi / times.sum(axis=1)
    count = counted(table, lanes_at(top, machine)) - rigid
    for _ in range(MOST_DOUBLINGS):
        short = np.flatnonzero(count < wanted)
        if not short.size:
            break
        top[short] *= 1.5
        count[short] = counted(table, lanes_at(top[short], short)) - rigid[short]
    omegas = np.full((n, wanted), np.nan)
    found = searched(
        table,
        (np.zeros(n), top),
        (rigid, np.maximum(count, 0).astype(np.intp) + rigid),
        times.max(axis=1),
        wanted=wanted,
    )
    for own in found:  # multiple ones, and those that round-off clouds, are left to the search of one chain
        number = own.number - rigid[own.machine]
        if own.multiplicity == 1 and own.enclosure == ENCLOSURE and number < wanted:
            omegas[own.machine, number] = own.omega
    return omegas, np.isfinite(omegas).all(axis=1)


def _table(chains: ChainBatch, here: slice) -> Table:
    """The rows of one chain, every segment cut, with the numbers of all."""
    times, masses, pendant = chains.times[here], chains.masses[here], chains.pendant[here]
    joints, segments, hung = masses.shape[1], times.shape[1], bool(pendant.any())
    z, heavy = float(chains.impedance[here].mean()), masses.mean(axis=0)
    nominal = Chain(
        rigidity=z,
        density=z,
        lengths=times.mean(axis=0),
        masses=np.where(heavy > 0.0, heavy, 1e-12 * heavy.max()),
        closed=joints == segments,
        pendants=(Pendant(stiffness=1.0, mass=float(pendant[:, 1].max()), ground=1.0),) if hung else (),
        grounds=np.ones(joints),
    )
    (own,), _ = network_of_chain(own_chain(nominal)).components()
    cut, factors = Cut(own, 1.0, np.ones(segments, dtype=bool)), [masses.T, chains.grounds[here].T]
    if hung:
        factors.append(pendant.T[[1, 0, 2]])  # in the order of the network's rows
    many = np.tile(chains.impedance[here], (segments, 1))
    return cut.table._replace(z=many[cut.wave], time=times.T[cut.wave], a=np.vstack(factors))
