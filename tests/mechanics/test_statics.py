"""Sag under gravity and carriages: closed forms, order of convergence, balance of the pulleys."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.mesh import mesh_of
from cabledrive.mechanics.statics import equilibrium
from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.errors import NotComputed
from oracles.catenary import catenary_sag, parabola_sag

DRIVE = load_drive("dissertation-2")


def with_cable(drive, **changes):
    return replace(drive, cable=replace(drive.cable, **changes))


def rest(drive, segments=40, model="exact", hold="none"):
    return equilibrium(mesh_of(drive, segments), cable_law(drive.cable, model), hold=hold)


@pytest.mark.parametrize("pretension", [5.0, 0.05, 0.001])
@pytest.mark.parametrize(
    ("model", "closed_form"), [("exact", catenary_sag), ("weak-consistent", parabola_sag)]
)
def test_sag_converges_to_the_closed_form_with_order_two(model, closed_form, pretension, measured):
    """Exact law: elastic catenary; consistent weak law: parabola with its stretch."""
    drive = with_cable(DRIVE, pretension=pretension)
    expected = closed_form(drive).midpoint
    n = np.array([20, 40, 80])
    at_rest = [rest(drive, int(k), model) for k in n]
    error = [abs(np.max(np.abs(one.displacement[2])) - expected) for one in at_rest]
    order = -np.polyfit(np.log(n), np.log(error), 1)[0]
    measured(f"order {order:.3f}; {max(one.iterations for one in at_rest)} Newton steps at most")
    assert order == pytest.approx(2.0, abs=0.05), f"observed order {order:.3f}, errors {error}"
    assert error[-1] < 1e-3 * expected


def test_a_loop_that_hangs_slack_at_rest_has_no_equilibrium_of_a_cable_that_cannot_push():
    """Below half the weights the lower ends go slack: nothing holds the nodes there across."""
    lift = load_drive("elevator")
    slack = with_cable(lift, pretension=0.8 * lift.cable.pretension)
    with pytest.raises(NotComputed, match=r"hangs slack; raise cable\.pretension"):
        equilibrium(mesh_of(slack, 12), cable_law(slack.cable, tension_only=True))
