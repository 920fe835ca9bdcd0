"""Figures of a machine are found again from the frequencies of its modes."""

import pytest

import cabledrive as cd
from cabledrive.studies.peak_fit import fit_to_peaks

MOTORS = ("motor.0.holding_stiffness", "motor.1.holding_stiffness")
SOFT = ("cable.axial_rigidity=16 kN", *(f"{key}=23 N m/rad" for key in MOTORS))


def peaks_of(settings, error):
    found = cd.modes(cd.load_drive("corexy", overrides=settings), count=2).longitudinal
    return {name: (mode.frequency, error) for name, mode in zip(("beam.y", "head.x"), found, strict=True)}


def test_belt_and_motor_stiffness_are_found_from_two_peaks():
    fit = fit_to_peaks(cd.load_drive("corexy"), peaks_of(SOFT, 0.3), ["cable.axial_rigidity", MOTORS])
    belt, motors = fit.figures
    assert belt.value == pytest.approx(16e3, rel=1e-7)
    assert motors.value == pytest.approx(23.0, rel=1e-7)
    assert motors.high / motors.low > belt.high / belt.low > 1.1  # the motors' stiffness is hardly seen
    assert fit.after["head.x"] == pytest.approx(fit.measured["head.x"], rel=1e-9)


def test_figures_that_the_peaks_do_not_determine_are_refused():
    drive = cd.load_drive("corexy")
    peaks = peaks_of(SOFT, 0.3)
    with pytest.raises(cd.InputRefused, match="2 peaks for 3 figures"):
        fit_to_peaks(drive, peaks, ["cable.axial_rigidity", *MOTORS])
    with pytest.raises(cd.NotComputed, match="do not determine"):
        fit_to_peaks(drive, peaks, ["cable.axial_rigidity", "motor.0.speed_limit"])
    with pytest.raises(cd.InputRefused, match="no coordinate"):
        fit_to_peaks(drive, {"bed.z": (50.0, 1.0)}, ["cable.axial_rigidity"])
