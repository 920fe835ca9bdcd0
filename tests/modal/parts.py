"""Counts and modes of chains, of random networks and of single ropes, straight from the search."""

import numpy as np

from cabledrive.mechanics.chain import own_chain
from cabledrive.modal.component import Component
from cabledrive.modal.elements import Rope
from cabledrive.modal.networks import network_of_chain
from cabledrive.modal.spectrum import Spectrum


def below(chain, omega):
    """Modes of a chain below a frequency [rad/s], its rigid-body mode included."""
    spectrum = Spectrum(network_of_chain(own_chain(chain)))
    return spectrum.count(omega) + spectrum.rigid_body_modes


def chain_modes(chain, top):
    """Modes of a chain below a frequency [rad/s]."""
    return Spectrum(network_of_chain(own_chain(chain))).below(top)


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
    return Component((), [], [Rope(none, none, **own)], [])
