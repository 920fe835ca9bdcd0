"""Counts and modes of chains, of random networks and of single ropes, straight from the search."""

import numpy as np
from scipy.optimize import brentq

from cabledrive.mechanics.chain import own_chain
from cabledrive.modal.component import Component
from cabledrive.modal.elements import Rope
from cabledrive.modal.networks import network_of_chain
from cabledrive.modal.spectrum import Spectrum
from oracles.network_fem import String, matrices
from oracles.rope_fem import frequencies


def below(chain, omega):
    """Modes of a chain below a frequency [rad/s], its rigid-body mode included."""
    spectrum = Spectrum(network_of_chain(own_chain(chain)))
    return spectrum.count(omega) + spectrum.rigid_body_modes


def chain_modes(chain, top):
    """Modes of a chain below a frequency [rad/s]."""
    return Spectrum(network_of_chain(own_chain(chain))).below(top)


def by_multiplicity(modes):
    """Frequencies of a list of modes [Hz], each by its multiplicity."""
    return np.repeat([mode.frequency for mode in modes], [mode.multiplicity for mode in modes])


def listed(found):
    """Frequencies of what a component's search has found, each by its multiplicity, all proven [rad/s]."""
    assert all(own.enclosure is not None for _, own in found)
    return np.repeat([own.omega for _, own in found], [own.multiplicity for _, own in found])


def held(rope, top):
    """Frequencies of a rope between ends at rest, clamped if it bends, below one [rad/s]."""
    return listed(alone(rope).modes(0.0, top))


def alone(rope):
    """One rope between ends at rest."""
    none = ((),) * len(rope.start)
    own = {
        key: getattr(rope, key) for key in ("length", "hold", "density", "tags", "direction", "pull", "bend")
    }
    return Component((), [Rope(none, none, **own)])


def finite_elements(chain, top, held=(), degree=46):
    """Natural frequencies [rad/s] up to about one by the p-version, no wave formula; rigid modes near 0.

    ``held``: joints that are held besides the chain's own ends.
    """
    n = chain.masses.size
    total = n + len(chain.pendants)
    fixed = {joint for joint, is_held in zip((0, n - 1), chain.fixed, strict=True) if is_held}
    kept = [joint for joint in range(total) if joint not in fixed | set(held)]
    rows, stiffness = np.eye(total), np.zeros((total, total))
    mass = np.diag([*chain.masses, *(pendant.mass for pendant in chain.pendants)])
    stiffness[range(n), range(n)] = 0.0 if chain.grounds is None else chain.grounds
    for number, pendant in enumerate(chain.pendants, n):
        twist = rows[number] - rows[pendant.joint]
        stiffness += pendant.stiffness * np.outer(twist, twist)
        stiffness[number, number] += pendant.ground
    cables = (np.broadcast_to(value, chain.lengths.shape) for value in (chain.rigidity, chain.density))
    strings = [
        String(rows[i, kept], rows[(i + 1) % n, kept], rho * length, np.sqrt(force / rho) / length)
        for i, (length, force, rho) in enumerate(zip(chain.lengths, *cables, strict=True))
    ]
    square = np.ix_(kept, kept)
    mass, _, stiffness = matrices(strings, mass[square], stiffness[square], degree)
    return frequencies(mass, stiffness, top)


def irvine_roots(parameter):
    """Symmetric modes in the plane of a level span, x = omega L sqrt(rho/T), by Irvine and Caughey.

    tan(x/2) = x/2 - 4/lambda^2 (x/2)^3; The linear theory of free vibrations of a suspended cable (1974).
    """

    def miss(x):
        return np.sin(x / 2) - (x / 2 - 4 / parameter * (x / 2) ** 3) * np.cos(x / 2)

    x = np.linspace(0.5, 40.0, 80_001)
    return [brentq(miss, x[i], x[i + 1]) for i in np.flatnonzero(np.diff(np.sign(miss(x))))]
