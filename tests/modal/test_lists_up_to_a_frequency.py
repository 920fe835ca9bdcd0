"""Lists that end at a frequency: what stands below it, also at a mode, and of thousands."""

from pathlib import Path

import numpy as np

from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal import longitudinal_modes
from cabledrive.modal.resting_modes import MOST_COUNTED, transverse_band
from cabledrive.parameters import load_drive

PRINTER = load_drive(Path(__file__).parent.parent / "parameters" / "routes" / "printer.toml")


def test_longitudinal_modes_of_a_route_below_a_frequency_are_the_first_of_its_list():
    """Between two modes, and at a mode, where the count would depend on the last digit: just below it."""
    listed = [mode.frequency for mode in longitudinal_modes(PRINTER, count=5)]
    between = longitudinal_modes(PRINTER, below=0.5 * (listed[2] + listed[3]))
    np.testing.assert_allclose([mode.frequency for mode in between], listed[:3], rtol=1e-12)
    at = longitudinal_modes(PRINTER, below=listed[2])
    assert len(at) == 2 + (listed[1] == listed[2])


def test_a_count_of_thousands_of_heavy_strings_is_exact_up_to_the_largest_that_is_counted():
    """n pi / t of each span and plane, less than one mode each apart; an even estimate above."""
    drive = load_drive("elevator")
    band = transverse_band(drive, longitudinal_chains(drive))
    turns = [string.travel_time / np.pi for string in band._strings.values()]
    omega = 0.2 * MOST_COUNTED / sum(turns)
    assert abs(band.count(omega) - 2 * sum(int(omega * turn) for turn in turns)) <= 2 * len(turns)
    omega = 1.1 * MOST_COUNTED / sum(turns)
    assert band.count(omega) == 2 * int(omega * sum(turns))
