"""Models of few inertias beside the distributed cable."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.modal import natural_frequencies
from cabledrive.parameters import load_drive
from cabledrive.reduction.lumped_chain import LumpedChain, speed_response
from cabledrive.reduction.models import lumped_model
from cabledrive.reduction.quality import (
    distributed_response,
    model_quality,
    model_response,
    with_measured_stiffness,
)
from cabledrive.reduction.reflected import reflected

DRIVE = load_drive("dissertation-3")
OMEGA = 2 * np.pi * np.geomspace(0.3, 150.0, 40)


def test_a_cable_without_mass_is_model_4():
    light = replace(DRIVE, cable=replace(DRIVE.cable, mass_per_length=1e-9))
    error = np.abs(distributed_response(light, OMEGA) / model_response(light, 4, OMEGA) - 1.0).max()
    assert error < 1e-5, f"observed {error:.2e}"


def test_distributed_response_peaks_at_the_certified_modes():
    """Undamped, the response has its poles where the count of modes puts them."""
    bare = replace(
        DRIVE,
        motor=replace(DRIVE.motor, joint_damping=0.0, viscous_friction=0.0),
        lumped=replace(DRIVE.lumped, cable_damping=0.0),
    )
    for mode in natural_frequencies(with_measured_stiffness(bare), count=2):
        beside = distributed_response(bare, 2 * np.pi * mode * np.array([1 - 1e-7, 1 + 1e-7]))
        assert beside[0].real * beside[1].real < 0.0, f"no pole at {mode:.4f} Hz"


def test_each_model_holds_up_to_the_mode_it_leaves_out(measured):
    """Models 1 and 2 fail well below the cable's mode, Model 3 below the joint's, Model 4 far beyond both."""
    quality = {q.model: q for q in model_quality(DRIVE)}
    for q in quality.values():
        measured(f"Model {q.model}: 1 % up to {q.holds_1:.3g} Hz, 5 % up to {q.holds_5:.3g} Hz")
    assert quality[1].holds_5 < 3.0
    assert quality[2].holds_5 < 3.0
    assert 3.0 < quality[3].holds_1 < quality[3].holds_5 < 92.0
    assert quality[4].holds_1 > quality[3].holds_1
    np.testing.assert_allclose(quality[4].frequencies, quality[4].exact, rtol=2e-2)


def test_reflection_keeps_frequencies_and_responses():
    chain = LumpedChain(
        names=("drive", "load"),
        inertias=(1e-3, 4e-3),
        viscous=(1e-3, 2e-3),
        coulomb=(0.0, 0.0),
        offsets=(0.0, 0.0),
        stiffness=(900.0,),
        damping=(0.5,),
        ratios=((0.03, 0.05),),
    )
    plain, gears = reflected(chain)
    from cabledrive.reduction.lumped_chain import natural_frequencies_of, speed_response

    assert gears[1] == pytest.approx(5 / 3)
    np.testing.assert_allclose(natural_frequencies_of(plain), natural_frequencies_of(chain), rtol=1e-12)
    found = speed_response(plain, OMEGA, speed_of=1) / gears[1]
    np.testing.assert_allclose(found, speed_response(chain, OMEGA, speed_of=1), rtol=1e-10)


def test_distributed_drive_turns_its_motor_as_model_4_does_up_to_the_joints_mode():
    """Motor speed per torque, the curve of Fig. 6.3: within 1 % up to 120 Hz."""
    omega = 2.0 * np.pi * np.geomspace(1.0, 120.0, 200)
    exact = 1j * omega * distributed_response(DRIVE, omega, angle_of="motor")
    worst = np.abs(speed_response(lumped_model(DRIVE, 4), omega) / exact - 1.0).max()
    assert worst < 0.01, f"observed {worst:.4f}"
    rigid = replace(DRIVE, motor=replace(DRIVE.motor, joint_stiffness=None))
    exact = 1j * omega[:50] * distributed_response(rigid, omega[:50], angle_of="motor")
    np.testing.assert_allclose(speed_response(lumped_model(rigid, 3), omega[:50]), exact, rtol=0.01)
