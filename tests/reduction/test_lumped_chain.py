"""The lumped chain is Models 1 to 4; beside the distributed cable, python-control, a holding stiffness."""

from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.response import network_response
from cabledrive.parameters.keys import varied_together
from cabledrive.reduction import lumped_chain
from cabledrive.reduction.network_axis import as_axis, slack_torque
from cabledrive.reduction.network_chain import LOSS_FACTOR, network_chains
from cabledrive.reduction.quality import model_quality, model_response
from cabledrive.reduction.two_motors import line_at, winched_machine
from cabledrive.rig import Motion, RigOptions
from command import refused
from network_samples import as_route, printer_belt, route, routed, without_gravity

DRIVE = cd.load_drive("dissertation-3").listed
J11, J12, J2, B1 = 0.0011, 0.000642, 0.00235, 0.0031
K_M, B_M, KK, BB = 135.0, 0.075, 2 * 850 * 0.04**2, 2 * 0.18 * 0.04
OMEGA = 2 * np.pi * np.geomspace(0.3, 400.0, 60)


def test_model_2_is_the_first_line_of_4_19_with_the_load_on_the_pulley():
    s, j = 1j * OMEGA, J12 + J2
    pulley = j * s**2 + B_M * s + K_M
    printed = pulley * s / ((J11 * s**2 + (B1 + B_M) * s + K_M) * pulley - (K_M + B_M * s) ** 2)
    found = lumped_chain.speed_response(lumped_chain.lumped_model(DRIVE, 2), OMEGA)
    np.testing.assert_allclose(found, printed, rtol=1e-10)


def test_model_3_has_the_coefficients_of_6_12():
    s, j1 = 1j * OMEGA, J11 + J12
    numerator = [1 / j1, BB / (j1 * J2), KK / (j1 * J2)]
    below = [1.0, (B1 + BB) / j1 + BB / J2, KK / j1 + KK / J2 + B1 * BB / (j1 * J2), KK * B1 / (j1 * J2)]
    found = lumped_chain.speed_response(lumped_chain.lumped_model(DRIVE, 3), OMEGA)
    np.testing.assert_allclose(found, np.polyval(numerator, s) / np.polyval(below, s), rtol=1e-10)


def test_model_4_is_6_14_with_its_first_line_mended():
    s = 1j * OMEGA
    cable = s**2 + BB / J2 * s + KK / J2
    quartic = (
        s**4
        + (BB / J2 + BB / J12 + B_M / J12) * s**3
        + (KK / J2 + KK / J12 + K_M / J12 + BB * B_M / (J12 * J2)) * s**2
        + (BB * K_M + B_M * KK) / (J12 * J2) * s
        + KK * K_M / (J12 * J2)
    )
    transmitted = B_M / J12 * (s + K_M / B_M) * cable / quartic
    mended = (s / J11) / (s**2 + (B1 + B_M) / J11 * s + K_M / J11 - transmitted * B_M / J11 * (s + K_M / B_M))
    chain = lumped_chain.lumped_model(DRIVE, 4)
    np.testing.assert_allclose(lumped_chain.speed_response(chain, OMEGA), mended, rtol=1e-10)


FAR = 2 * np.pi * np.geomspace(0.3, 150.0, 40)


def test_each_model_holds_up_to_the_mode_it_leaves_out(measured):
    """Models 1 and 2 fail well below the cable's mode, Model 3 below the joint's, Model 4 far beyond both."""
    quality = {q.model: q for q in model_quality(DRIVE)}
    for q in quality.values():
        measured(f"Model {q.model}: 1 % up to {q.holds_1:.3g} Hz, 5 % up to {q.holds_5:.3g} Hz")
        assert len(q.exact) == len(q.frequencies)
    assert quality[1].holds_5 < 3.0
    assert quality[2].holds_5 < 3.0
    assert 3.0 < quality[3].holds_1 < quality[3].holds_5 < 92.0
    assert quality[4].holds_1 > quality[3].holds_1
    np.testing.assert_allclose(quality[4].frequencies, quality[4].exact, rtol=2e-2)


def test_reflection_keeps_frequencies_and_responses():
    chain = lumped_chain.LumpedChain(
        names=("drive", "load"),
        inertias=(1e-3, 4e-3),
        viscous=(1e-3, 2e-3),
        coulomb=(0.0, 0.0),
        offsets=(0.0, 0.0),
        stiffness=(900.0,),
        damping=(0.5,),
        ratios=((0.03, 0.05),),
    )
    plain, gears = lumped_chain.reflected(chain)
    assert gears[1] == pytest.approx(5 / 3)
    np.testing.assert_allclose(
        lumped_chain.natural_frequencies_of(plain), lumped_chain.natural_frequencies_of(chain), rtol=1e-12
    )
    found = lumped_chain.speed_response(plain, FAR, speed_of=1) / gears[1]
    np.testing.assert_allclose(found, lumped_chain.speed_response(chain, FAR, speed_of=1), rtol=1e-10)


FEW = 2.0 * np.pi * np.array([0.3, 3.0, 8.0, 90.0, 300.0])


@pytest.mark.parametrize("model", [1, 2, 3, 4])
def test_state_space_answers_as_the_model_does(model, measured):
    control = pytest.importorskip("control")
    chain = lumped_chain.lumped_model(DRIVE, model)
    a, b = lumped_chain.state_space(chain)
    system = control.ss(a, b[:, :1], np.eye(chain.size, 2 * chain.size), 0)
    found = np.atleast_2d(np.squeeze(control.frequency_response(system, FEW).frdata))[-1]
    expected = np.abs(model_response(DRIVE, model, FEW))
    measured(f"Model {model}: response within {np.max(np.abs(np.abs(found) / expected - 1.0)):.1e}")
    np.testing.assert_allclose(np.abs(found), expected, rtol=1e-8)


# --- Chains that motors of machines with routes drive, against finite elements of their belts
MIDDLE = "head.x=0.21"


def printer_response(omega, parts):
    """Motor angle and head place per torque, from those elements; shape (frequencies, 2)."""
    (mass, stiffness, _), radius = printer_belt([parts] * 4), 6.366e-3
    force = np.zeros(len(mass))
    force[parts] = 1.0 / radius
    found = [np.linalg.solve(stiffness * (1 + 1j * LOSS_FACTOR) - w**2 * mass, force) for w in omega]
    return np.array([[x[parts] / radius, -x[0]] for x in found])


def test_the_response_of_a_network_is_that_of_finite_elements():
    """Elements of order two in the belt's waves: the difference falls four times for twice as many."""
    network = network_of(route("printer"))
    omega = 2 * np.pi * np.array([20.0, 150.0, 189.0, 400.0, 840.0, 1500.0])
    rows = network.motion.dense("motor", "head.x")
    found = network_response(network, omega, rows[0], rows, loss_factor=LOSS_FACTOR)
    errors = [np.abs(found / printer_response(omega, parts) - 1.0).max() for parts in (10, 20)]
    assert errors[1] < 5e-3, errors
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.1), errors


CAMERA = """
layout = { gravity = "9.81 m/s^2" }
cable = { axial_rigidity = "20 kN", mass_per_length = "50 g/m", pretension = "400 N" }
pulley = [
    { name = "drum", at = ["0 m", "0 m"], radius = "0.1 m", inertia = "0.05 kg m^2" },
    { name = "far", at = ["30 m", "0 m"], radius = "0.1 m", inertia = "0.1 g m^2" },
]
body = [{ name = "camera", at = ["15 m", "0.1 m"], moves = "x", mass = "200 kg" }]
anchor = [
    { name = "left", on = "camera", at = ["14.9 m", "0.1 m"] },
    { name = "right", on = "camera", at = ["15.1 m", "0.1 m"] },
]
motor = { inertia = "0.05 kg m^2" }
route = [{ name = "line", path = ["left", "+drum", "+far", "right"] }]
"""


STEEP = CAMERA.replace('m/s^2" }', 'm/s^2", inclination = "37 deg" }').replace("400 N", "28 N")
STEEP = STEEP.replace('motor = { inertia = "0.05', 'motor = { inertia = "0.5')


@pytest.mark.parametrize(
    ("machine", "across"),
    [(route("printer"), 0.0), (routed(CAMERA), 0.03), (routed(STEEP), 0.03)],
    ids=["printer", "a camera", "a camera that sag pulls up or down its line"],
)
def test_what_a_chain_leaves_out_is_what_the_response_of_the_machine_has_more(machine, across, measured):
    """At each of four hundred frequencies, where the chain takes four and the modes that it knows."""
    (chain,) = network_chains(machine)
    omega = 4 * np.pi * chain.frequencies[0] * np.linspace(0.025, 1.0, 400)
    turn, load = chain.network.motion.dense(machine.pulley[0].name, chain.load)
    exact = network_response(chain.network, omega, turn, np.array([turn, load]), loss_factor=LOSS_FACTOR)
    squares = (2 * np.pi * np.append(0.0, chain.frequencies)) ** 2 * (1 + 1j * LOSS_FACTOR)
    weights = np.array([turn, load]) @ chain.shapes * (turn @ chain.shapes)
    kept = weights / (squares - omega[:, None, None] ** 2)
    more = np.max(np.abs(exact - kept.sum(axis=2)) / np.abs(kept).sum(axis=2))
    measured(f"left out {more:.4g}, along {chain.neglected:.4g} and across {chain.strings:.4g}")
    assert chain.strings >= across
    assert abs(chain.strings - chain.neglected) * 0.999 < more < (chain.strings + chain.neglected) * 1.001


def test_a_gram_that_hangs_on_a_span_changes_no_chain():
    """It also moves out of the plane, on springs that no chain knows."""
    gram = 'carriage = [{ mass = "1 g", position = "16 m", guided = false }]'
    (chain,), (other,) = network_chains(routed(CAMERA)), network_chains(routed(CAMERA + gram))
    assert other.load == chain.load
    np.testing.assert_allclose(other.inertias, chain.inertias, rtol=1e-3)
    assert other.neglected == pytest.approx(chain.neglected, rel=1e-3)


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


@pytest.mark.parametrize("share", [0.0353, 0.382, 0.9, 1.2, 2.0])
def test_an_axis_whose_rigid_motion_a_rope_askew_makes_a_slow_mode_is_refused(share):
    """A pulley of another radius at the front of a corexy: its belt runs askew; `check` had a defect."""
    machine = varied_together(cd.load_drive("corexy"), {"pulley.front right a.radius": 6e-3 * share})
    refused(lambda: network_chains(machine), "askew")


def test_a_symmetric_corexy_splits_into_sum_and_difference(measured):
    chains = network_chains(route("corexy", MIDDLE))
    assert [chain.load for chain in chains] == ["head.x", "beam.y"]
    for chain in chains:
        assert chain.refusal is None
        assert chain.cross < 1e-9
        assert chain.neglected < 0.01, chain.neglected
        assert abs(chain.gain) == pytest.approx(6.366e-3, rel=1e-6)
        neglected, strings = f"{100 * chain.neglected:.2f} %", f"{100 * chain.strings:.1f} %"
        measured(f"CoreXY, {chain.load}: chain against the network {neglected}, strings {strings}")


def test_what_a_head_off_the_middle_moves_across_is_that_of_finite_elements(measured):
    """The run's torque on both motors of the free machine with its belts as elements: nothing reduced."""
    free = {"holding_stiffness": None}
    rigid = ("body.head.coulomb_friction=0", "body.beam.coulomb_friction=0")
    for place in ("0.17", "0.06"):
        drive = cd.load_drive("corexy", overrides=[f"head.x={place}", *rigid])
        drive = replace(drive, motor=tuple(replace(motor, **free) for motor in drive.motor))
        motion, true = Motion(angle=30.0, rise=0.04, dwell=0.01), RigOptions(ideal_sensors=True)
        run = cd.track(drive, axis="head.x", bandwidth=20.0, motion=motion, options=true)
        half = lambda t, run=run: 0.5 * run.torque[np.searchsorted(run.time, t + 1e-9) - 1]  # noqa: E731
        truth = cd.simulate(drive, 0.05, torque={"motor a": half, "motor b": half})
        across, head = truth.channel("beam.y"), truth.channel("head.x")
        time = np.asarray(truth.to_xarray().time)
        chain = run.summary["axis"]["gain"] * np.interp(time, run.time, run.load_angle)
        said = run.summary["axis"]["cross_motion"]
        moved, off = np.abs(across - across[0]).max(), np.abs(head - head[0] - chain).max()
        measured(
            f"head at {place} m: beam {1e6 * moved:.2f} um, said {1e6 * said['motion'][0]:.2f}; head off by "
            f"{1e6 * off:.2f} um, said {1e6 * said['load'][0]:.2f} beside the chain's own error"
        )
        assert said["other"] == "beam.y"
        assert said["motion"][0] == pytest.approx(moved, rel=0.1)
        assert off < said["load"][0] + 0.003 * abs(chain[-1])


@pytest.mark.parametrize(
    ("name", "reason"), [("elevator", "leaves out"), ("ropeway", "is not the end of the chain")]
)
def test_what_is_no_chain_is_refused_with_the_reason(name, reason):
    assert reason in network_chains(route(name))[0].refusal


def test_a_loop_as_a_route_reduces_to_its_own_model():
    """The chain has the certified frequencies; its numbers are those of Model 4 but for the cable's mass."""
    drive = without_gravity(cd.load_drive("dissertation-3").listed)
    machine = as_route(drive)
    (chain,) = network_chains(machine)
    assert chain.refusal is None
    model = lumped_chain.lumped_model(replace(drive, lumped=None), 4)
    np.testing.assert_allclose(chain.inertias, model.inertias, rtol=0.05)
    stiffness = np.array(model.stiffness) * [1.0, drive.drive_pulley.radius**2]
    np.testing.assert_allclose(chain.stiffness, stiffness, rtol=0.05)
    exact = cd.natural_frequencies(machine, count=2, motor="free")
    axis = as_axis(machine)
    np.testing.assert_allclose(
        lumped_chain.natural_frequencies_of(lumped_chain.lumped_model(axis)) / (2 * np.pi), exact, rtol=1e-9
    )
    assert slack_torque(chain) == pytest.approx(
        2 * drive.drive_pulley.radius * drive.cable.pretension, rel=1e-6
    )


def test_what_an_axis_has_no_spans_for_is_answered_by_its_machine():
    """Modes, resonance and machine with routes of the chain of an axis are those of its machine."""
    drive = cd.load_drive("printer-idlers")
    axis = as_axis(drive)
    assert axis.machine is drive
    assert cd.modes(axis, count=2).modes[0].frequency == cd.modes(drive, count=2).modes[0].frequency
    one, other = cd.resonance(axis, torque=0.1), cd.resonance(drive, torque=0.1)
    assert (one.verdict, one.threshold_torque) == (other.verdict, other.threshold_torque)


def test_the_lumped_model_of_an_axis_is_its_chain():
    """Also of two motors, whose inertias and torque limits add, and of friction at the head."""
    overrides = ("motor.0.torque_limit=0.3", "motor.1.torque_limit=0.25", "body.head.coulomb_friction=2.0")
    machine = route("corexy", MIDDLE, *overrides)
    chain, axis = network_chains(machine)[0], as_axis(machine, "head.x")
    model = lumped_chain.lumped_model(axis)
    np.testing.assert_allclose(model.inertias, chain.inertias, rtol=1e-12)
    rim = axis.drive_pulley.radius
    np.testing.assert_allclose(np.array(model.stiffness) * rim**2, chain.stiffness, rtol=1e-12)
    assert axis.motor.torque_limit == pytest.approx(0.5)
    assert model.coulomb[-1] == pytest.approx(2.0 * 6.366e-3)
    assert as_axis(machine, "beam.y").axis.load == "beam.y"


@pytest.mark.parametrize("motor", ["held", "free"])
def test_small_motions_have_the_certified_frequencies(motor):
    """Two springs that hold it, and their tension about rest, against the exact modes of the network."""
    camera = cd.load_drive("camera-winches")
    machine = winched_machine(camera)
    n, h = machine.numbers, 1e-5

    def forces(x):
        along, pull = np.zeros((2, 2)), np.zeros(2)
        for i in range(2):
            length, free, _ = line_at(n, i, x[:2].copy(), along[i])
            pull[i] = n.rigidity[i] / free * (length + n.drum[i] * x[2 + i] - n.unwound[i])
        return np.concatenate([n.force - pull @ along, n.drum * (machine.tension - pull)])

    at_rest = forces(np.zeros(4))
    assert np.abs(at_rest).max() < 1e-6 * np.abs(n.force).max(), at_rest
    stiffness = -np.array([(forces(h * e) - forces(-h * e)) / (2.0 * h) for e in np.eye(4)]).T
    mass, kept = np.concatenate([n.mass, n.inertia]), slice(0, 2 if motor == "held" else 4)
    squares = np.linalg.eigvals(stiffness[kept, kept] / mass[kept, None]).real
    found = np.sqrt(np.sort(squares[squares > 1.0])) / (2.0 * np.pi)
    exact = [mode.frequency for mode in cd.modes(camera, below=8.0, motor=motor).modes]
    assert len(found) >= 2
    for frequency in found:
        off = np.abs(np.array(exact) / frequency - 1.0).min()
        assert off < 0.01, (frequency, exact)
