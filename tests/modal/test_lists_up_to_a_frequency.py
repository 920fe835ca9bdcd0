"""Lists that end at a frequency: what stands below it, also at a mode, and of thousands."""

from pathlib import Path

import numpy as np

from cabledrive.mechanics import rest_state
from cabledrive.modal import longitudinal_modes
from cabledrive.modal.networks import network_of_drive
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters import load_drive

PRINTER = load_drive(Path(__file__).parent.parent / "parameters" / "routes" / "printer.toml")


def test_longitudinal_modes_of_a_route_below_a_frequency_are_the_first_of_its_list():
    """Between two modes, and at a mode, where the count would depend on the last digit: just below it."""
    listed = [mode.frequency for mode in longitudinal_modes(PRINTER, count=5)]
    between = longitudinal_modes(PRINTER, below=0.5 * (listed[2] + listed[3]))
    np.testing.assert_allclose([mode.frequency for mode in between], listed[:3], rtol=1e-12)
    at = longitudinal_modes(PRINTER, below=listed[2])
    assert len(at) == 2 + (listed[1] == listed[2])


def test_a_count_of_thousands_of_heavy_strings_is_that_of_their_travel_times():
    """n pi / t of each span and plane, less than one mode each apart."""
    drive = load_drive("elevator")
    spectrum = Spectrum(network_of_drive(drive))
    turns = [
        np.sqrt(drive.cable.mass_per_length) * sum(own.travel_time for own in section.stretches) / np.pi
        for section in rest_state(drive).sections
    ]
    omega = 4000.0 / sum(turns)
    across = sum(part.count(omega) for part in spectrum._windows[0].parts if part.kinds == {"transverse"})
    assert abs(across - 2 * sum(int(omega * turn) for turn in turns)) <= 2 * len(turns)
