"""Chains that motors of machines with routes drive, against finite elements of their belts."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.response import network_response
from cabledrive.reduction.lumped_chain import natural_frequencies_of
from cabledrive.reduction.models import lumped_model
from cabledrive.reduction.network_axis import as_axis, slack_torque
from cabledrive.reduction.network_chain import LOSS_FACTOR, network_chains
from network_samples import as_route, without_gravity

TESTS = Path(__file__).parent.parent
ROUTES = TESTS / "parameters" / "routes"
MIDDLE = "head.x=0.21"


def route(name, *overrides):
    return cd.load_drive(ROUTES / f"{name}.toml", overrides=overrides)


def printer_elements(parts):
    """Mass and stiffness of the belt of `printer.toml`, each span of so many elements, by hand.

    The belt is a ring: head, motor, lower idler, upper idler; its coordinate is the motion of the belt.
    """
    rigidity, density, tension = 19.4e3, 8.3e-3, 30.0
    lengths = np.array([0.18, 0.40, 4.732e-3, 0.18]) / (1.0 + tension / rigidity)
    n = 4 * parts
    mass, stiffness = np.zeros((n, n)), np.zeros((n, n))
    for span, length in enumerate(lengths):
        for k in range(parts):
            pair = np.ix_(*[[span * parts + k, (span * parts + k + 1) % n]] * 2)
            stiffness[pair] += rigidity * parts / length * np.array([[1, -1], [-1, 1]])
            mass[pair] += density * length / parts / 6.0 * np.array([[2, 1], [1, 2]])
    radius = 6.366e-3
    joints = [0.35, (1.6e-7 + 54e-7) / radius**2, 3e-8 / 4e-3**2, 3e-8 / 4e-3**2]
    for joint, own in enumerate(joints):
        mass[joint * parts, joint * parts] += own
    return mass, stiffness, radius


def printer_response(omega, parts):
    """Motor angle and head place per torque, from those elements; shape (frequencies, 2)."""
    mass, stiffness, radius = printer_elements(parts)
    force = np.zeros(len(mass))
    force[parts] = 1.0 / radius
    found = [np.linalg.solve(stiffness * (1 + 1j * LOSS_FACTOR) - w**2 * mass, force) for w in omega]
    return np.array([[x[parts] / radius, -x[0]] for x in found])


def test_the_response_of_a_network_is_that_of_finite_elements():
    """Elements of order two in the belt's waves: the difference falls four times for twice as many."""
    network = network_of(route("printer"))
    omega = 2 * np.pi * np.array([20.0, 150.0, 189.0, 400.0, 840.0, 1500.0])
    rows = np.array([network.motion.unit("motor"), network.motion.unit("head.x")])
    found = network_response(network, omega, rows[0], rows, loss_factor=LOSS_FACTOR)
    errors = [np.abs(found / printer_response(omega, parts) - 1.0).max() for parts in (10, 20)]
    assert errors[1] < 5e-3, errors
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.1), errors


def test_the_printer_is_a_chain_of_two_inertias_up_to_twice_its_mode(measured):
    (chain,) = network_chains(route("printer"))
    assert chain.load == "head.x"
    assert chain.refusal is None
    omega = 2 * np.pi * chain.frequencies[0] * np.linspace(0.05, 2.0, 60)
    truth = printer_response(omega, 30)
    stiffness = chain.stiffness[0] * (1 + 1j * LOSS_FACTOR) * np.array([[1, -1], [-1, 1]])
    own = np.array([np.linalg.solve(stiffness - w**2 * np.diag(chain.inertias), [1.0, 0.0]) for w in omega])
    rigid = 1.0 / chain.inertias.sum() / omega**2
    motor, head = own[:, 0], own @ chain.load_row
    error = max(
        np.max(np.abs(motor - truth[:, 0]) / (np.abs(motor) + rigid)),
        np.max(np.abs(head - truth[:, 1]) / (np.abs(head) + rigid * abs(chain.gain))),
    )
    measured(f"printer as a chain of two inertias against finite elements: {100 * error:.2f} %")
    assert error < 0.01, error
    assert chain.gain == pytest.approx(-6.366e-3, rel=1e-9)


def test_a_symmetric_corexy_splits_into_sum_and_difference(measured):
    chains = network_chains(route("corexy", MIDDLE))
    assert [chain.load for chain in chains] == ["head.x", "beam.y"]
    for chain in chains:
        assert chain.refusal is None
        assert chain.cross < 1e-9
        assert chain.neglected < 0.01, chain.neglected
        assert abs(chain.gain) == pytest.approx(6.366e-3, rel=1e-6)
        measured(f"CoreXY, {chain.load}: chain against the network {100 * chain.neglected:.2f} %, "
                 f"strings {100 * chain.strings:.1f} %")  # fmt: skip


@pytest.mark.parametrize(
    ("name", "overrides", "reason"),
    [
        ("corexy", (), "do not split into sum and difference"),
        ("elevator", (), "leaves out"),
        ("ropeway", (), "is not the end of the chain"),
    ],
)
def test_what_is_no_chain_is_refused_with_the_reason(name, overrides, reason):
    assert reason in network_chains(route(name, *overrides))[0].refusal


def test_a_loop_as_a_route_reduces_to_its_own_model():
    """The chain has the certified frequencies; its numbers are those of Model 4 but for the cable's mass."""
    drive = without_gravity(cd.load_drive("dissertation-3"))
    machine = as_route(drive)
    (chain,) = network_chains(machine)
    assert chain.refusal is None
    model = lumped_model(replace(drive, lumped=None), 4)
    np.testing.assert_allclose(chain.inertias, model.inertias, rtol=0.05)
    np.testing.assert_allclose(chain.stiffness, np.array(model.stiffness) * [1.0, 0.0] + [
        0.0, model.stiffness[1] * drive.drive_pulley.radius**2], rtol=0.05)  # fmt: skip
    exact = cd.natural_frequencies(machine, count=2, motor="free")
    axis = as_axis(machine)
    np.testing.assert_allclose(natural_frequencies_of(lumped_model(axis)) / (2 * np.pi), exact, rtol=1e-9)
    assert slack_torque(chain) == pytest.approx(
        2 * drive.drive_pulley.radius * drive.cable.pretension, rel=1e-6
    )


def test_the_lumped_model_of_an_axis_is_its_chain():
    """Also of two motors, whose inertias and torque limits add, and of friction at the head."""
    overrides = ("motor.0.torque_limit=0.3", "motor.1.torque_limit=0.25", "body.head.coulomb_friction=2.0")
    machine = route("corexy", MIDDLE, *overrides)
    chain, axis = network_chains(machine)[0], as_axis(machine, "head.x")
    model = lumped_model(axis)
    np.testing.assert_allclose(model.inertias, chain.inertias, rtol=1e-12)
    rim = axis.drive_pulley.radius
    np.testing.assert_allclose(np.array(model.stiffness) * rim**2, chain.stiffness, rtol=1e-12)
    assert axis.motor.torque_limit == pytest.approx(0.5)
    assert model.coulomb[-1] == pytest.approx(2.0 * 6.366e-3)
    assert as_axis(machine, "beam.y").load == "beam.y"
