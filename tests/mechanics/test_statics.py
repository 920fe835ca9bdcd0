"""Sag under gravity and carriages: closed forms, order of convergence, balance of the pulleys."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.mesh import cable_forces, mesh_of
from cabledrive.mechanics.statics import equilibrium
from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.drive_parts import Carriage
from cabledrive.parameters.errors import InputRefused, NotComputed
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


def test_a_free_load_pulley_levels_the_tensions_and_held_ones_do_not():
    """A carriage that hangs on the upper span stretches it; a free pulley shares that with the lower span."""
    drive = replace(DRIVE, carriage=(Carriage(mass=0.05, position=0.3, guided=False),))
    law, mesh = cable_law(drive.cable), mesh_of(drive, 40)
    free, held = equilibrium(mesh, law, hold="drive"), equilibrium(mesh, law, hold="both")
    assert free.holding_torque[1] == 0.0
    assert abs(cable_forces(mesh, law, free.displacement)[0, mesh.segments]) < 1e-12
    radius = drive.load_pulley.radius
    assert held.holding_torque[1] == pytest.approx(
        -radius * cable_forces(mesh, law, held.displacement)[0, 40]
    )
    assert abs(held.holding_torque[1]) > 1e-3
    assert np.max(np.abs(free.displacement[2])) > np.max(np.abs(held.displacement[2]))


def test_gravity_on_a_slope_asks_for_a_held_pulley():
    """A carriage at 30 deg pulls m g sin(30 deg) along the loop: refused free, held with that torque."""
    layout = replace(DRIVE.layout, inclination=pi / 6)
    drive = replace(DRIVE, layout=layout, carriage=(Carriage(mass=1e-2, position=0.5),))
    with pytest.raises(InputRefused, match="N m would hold them; hold the drive pulley"):
        rest(drive)
    torque = rest(drive, hold="drive").holding_torque[0]
    assert torque == pytest.approx(1e-2 * 9.81 * 0.5 * drive.drive_pulley.radius, rel=1e-9)


def test_a_loop_that_hangs_slack_at_rest_has_no_equilibrium_of_a_cable_that_cannot_push():
    """Below half the weights the lower ends go slack: nothing holds the nodes there across."""
    lift = load_drive("elevator")
    slack = with_cable(lift, pretension=0.8 * lift.cable.pretension)
    with pytest.raises(NotComputed, match=r"hangs slack; raise cable\.pretension"):
        equilibrium(mesh_of(slack, 12), cable_law(slack.cable, tension_only=True))
