"""The distributed cable in modes as an FMU: the kernel to the bit, the exact machine nearly."""

import shutil
from functools import cache

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.export.fmu import cable_fmu
from cabledrive.export.translation.source import interpreted
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.assembly import rotor_turn
from cabledrive.mechanics.network.response import network_response
from cabledrive.reduction.modal_cable import modal_cable
from cabledrive.reduction.modal_cable_kernels import (
    cable_motion,
    cable_step,
    new_modal_cable_state,
    start_cable,
)
from export.test_fmu import Slave

fmpy = pytest.importorskip("fmpy", reason="needs fmpy")
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
DRIVES = {"loop": "dissertation-1", "network": "corexy"}


@cache
def package(name: str, version: int):
    files, notes, cable = cable_fmu(cd.load_drive(name), version)
    return next(iter(files.values())), notes, cable


def slave(folder, name: str, version: int) -> Slave:
    return Slave(folder, version, "cable", content=package(name, version)[0])


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", DRIVES.values())
def test_the_cable_steps_as_the_interpreted_kernel_to_the_bit(name, version, tmp_path, measured):
    from fmpy.validation import validate_fmu

    cable, samples = package(name, version)[2], 120
    one = slave(tmp_path, name, version)
    assert validate_fmu(str(tmp_path / "one.fmu")) == []
    listed = [v.name for v in one.described.modelVariables]
    torques = listed[: len(cable.inputs)]
    n = len(cable.inputs) + (len(cable.spans) if cable.sine else 0)
    state, step = new_modal_cable_state(cable.numbers), interpreted(cable_step)
    plucks = np.array([1e-3, -4e-4]) if cable.sine else np.zeros(0)
    one.start(**{f"pluck_{span}": value for span, value in zip(cable.spans, plucks.tolist(), strict=False)})
    interpreted(start_cable)(plucks, state)
    tensions, places, speeds = np.zeros(len(cable.spans)), *np.zeros((2, len(cable.motions)))
    generator = np.random.default_rng(4)
    for k in range(samples):
        given = 1e-3 * generator.standard_normal(len(torques))
        one.set(**dict(zip(torques, given.tolist(), strict=True)))
        one.step(k, cable.interval)
        step(cable.numbers, state, given, tensions)
        interpreted(cable_motion)(cable.numbers, state, places, speeds)
        expected = [*places.tolist(), *speeds.tolist(), *tensions.tolist()]
        assert one.get(*listed[n : n + len(expected)]) == expected, f"sample {k}"
    assert one.get("holds") == [1.0]
    assert np.abs(places).max() > 0.0
    measured(f"{name}, FMI {version}: {samples} samples equal to the bit")


def test_a_slack_span_is_said(tmp_path):
    one, cable = slave(tmp_path, "dissertation-1", 2), package("dissertation-1", 2)[2]
    one.start()
    one.set(motor_torque=50.0)
    for k in range(20):
        one.step(k, cable.interval)
    assert one.get("holds") == [0.0]
    one.set(motor_torque=0.0)
    one.step(20, cable.interval)
    assert one.get("holds") == [0.0]


@pytest.mark.kernel  # cabledrive.reduction.modal_cable_kernels
@pytest.mark.parametrize("name", ["corexy", "lift-2-to-1"])
def test_a_network_in_modes_responds_as_its_exact_waves(name, measured):
    """The response to sampled inputs against the dynamic stiffness with its damping."""
    drive = cd.load_drive(name)
    cable, network = modal_cable(drive), network_of(drive)
    numbers = cable.numbers
    rows = numbers.motions
    k = rows.shape[1]
    gaps = []
    for hertz in np.array([0.06, 0.13, 0.21]) * cable.highest:
        omega = 2.0 * np.pi * hertz
        z = np.exp(1j * omega * cable.interval)
        modes = np.linalg.solve(z * np.eye(2 * k) - numbers.along, numbers.push[:, 0])
        hold = (1.0 - np.exp(-1j * omega * cable.interval)) / (1j * omega * cable.interval)
        found = rows @ modes[:k] / hold
        turn = rotor_turn(network, network.drive.driven[0])
        exact = network_response(network, np.array([omega]), turn, np.eye(rows.shape[0]))[0]
        gaps.append(float(np.abs(found - exact).max() / np.abs(exact).max()))
    measured(f"{name}: {100 * max(gaps):.2g} % of the largest motion up to a fifth of the highest mode")
    assert max(gaps) < 0.06, f"observed {gaps}"  # the modes left out give way as well
