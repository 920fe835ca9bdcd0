"""A loop read as a machine with routes has the modes of the loop."""

import pytest

import cabledrive as cd
from cabledrive.parameters.route.two_pulleys import as_machine


@pytest.mark.parametrize("name", ["printer-belt", "dissertation-3"])
def test_the_first_longitudinal_mode_of_a_loop_as_a_machine_is_that_of_the_loop(name):
    loop = cd.load_drive(name, overrides=["layout.gravity=0"])
    first = cd.modes(loop, count=1).longitudinal[0].frequency
    assert cd.modes(as_machine(loop), count=1).longitudinal[0].frequency == pytest.approx(first, rel=1e-9)
