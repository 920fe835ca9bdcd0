"""Order of convergence in space and time, of every chain method, on smooth data."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.drive_parts import Carriage
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, damped, simulate
from resonance_samples import envelope

DURATION = 1e-3  # s; longitudinal waves cross a span one and a half times
SEGMENTS, REFERENCE = np.array([128, 256, 512]), 4096
COARSER = {"both dampings": 4, "energy-conserving, exact": 2, "energy-conserving, weak-consistent": 2}
"""Smooth enough with fewer segments, and costly: a linear system or an iteration per step."""
LOOP = load_drive("dissertation-2").listed
MOTORED = load_drive("dissertation-3").listed
PLUCKED = load_drive(
    "dissertation-2", overrides=["cable.pretension=3.26", "cable.transverse_damping=2"]
).listed
DAMPED = replace(LOOP, cable=replace(LOOP.cable, transverse_damping=50.0, axial_damping=0.05))
CARRIED = replace(
    LOOP,
    carriage=(
        Carriage(mass=2e-3, position=0.25),
        Carriage(mass=1e-3, position=0.5, span="lower", guided=False),
    ),
)
FRICTIONLESS = replace(MOTORED, motor=replace(MOTORED.motor, coulomb_friction=0.0))
RUBBED = replace(LOOP, pulley=tuple(replace(p, coulomb_friction=0.01) for p in LOOP.pulley))

CASES = {
    "exact": (LOOP, {}),
    "weak": (LOOP, {"model": "weak"}),
    "weak-consistent": (LOOP, {"model": "weak-consistent"}),
    "linear": (LOOP, {"model": "linear"}),
    "node-centred, exact": (LOOP, {"method": "node-centred"}),
    "node-centred, weak": (LOOP, {"method": "node-centred", "model": "weak"}),
    "energy-conserving, exact": (LOOP, {"method": "energy-conserving"}),
    "energy-conserving, weak-consistent": (LOOP, {"method": "energy-conserving", "model": "weak-consistent"}),
    "both dampings": (DAMPED, {}),
    "carriages": (CARRIED, {}),
    "motor joint": (FRICTIONLESS, {}),
    "line": (replace(LOOP, kind="line"), {}),
    "smoothed friction": (RUBBED, {"friction": "smoothed", "smoothing_speed": 5.0}),
}


def bump(length, held):
    """Vanishes at both ends of the part of the span behind a carriage, with three derivatives."""
    return lambda x: np.where(x > held, np.sin(np.pi * (x - held) / (length - held)) ** 4, 0.0)


def end_of_run(drive, segments, options):
    length = drive.pulley_distance
    upper, lower = (0.25 * length, 0.5 * length) if drive.carriage else (0.0, 0.0)
    plucks = [Pluck(height=5e-3, shape=bump(length, upper))]
    if drive.kind == "loop":
        plucks.append(Pluck(height=-2.5e-3, span="lower", plane="v", shape=bump(length, lower)))
    result = simulate(
        drive,
        DURATION,
        torque=lambda time: 0.3 * np.sin(2.0 * np.pi * 125.0 * time) ** 4,
        start=Start(plucks=tuple(plucks)),
        scheme=Scheme(segments=segments, cfl=0.8, **options),
        recording=Recording(rate=1.0 / DURATION, fields=1),
    )
    return result.fields[-1].reshape(3, len(result.spans), -1)


@pytest.mark.parametrize("case", CASES)
def test_space_and_time_converge_with_order_two(case, measured):
    """All n doubled at a fixed CFL number: errors of u, v and w fall fourfold."""
    drive, options = CASES[case]
    segments, reference = SEGMENTS // COARSER.get(case, 1), REFERENCE // COARSER.get(case, 1)
    fine = end_of_run(drive, reference, {key: value for key, value in options.items() if key != "method"})
    found = [(end_of_run(drive, int(n), options), fine[:, :, :: reference // n]) for n in segments]
    off = [np.abs(own - exact).max((1, 2)) for own, exact in found]
    errors = np.array(off)[:, np.abs(fine).max((1, 2)) > 0.0]
    orders = np.log2(errors[:-1] / errors[1:])
    measured("order " + ", ".join(f"{order:.3f}" for order in orders[-1]))
    assert orders[-1] == pytest.approx(2.0, abs=0.1), f"observed orders\n{orders}\nof errors\n{errors}"


def test_stick_slip_converges_with_order_one_at_least(measured):
    """Friction set-valued at the speed after the step: a change to or from rest costs one order in time."""
    errors = []
    fine = stuck_and_slipping(2048)
    for n in SEGMENTS:
        errors.append(np.max(np.abs(stuck_and_slipping(int(n)) - fine)) / np.max(np.abs(fine)))
    order = -np.polyfit(np.log(SEGMENTS), np.log(errors), 1)[0]
    measured(f"order {order:.2f}, relative error {errors[-1]:.1e} of {SEGMENTS[-1]} segments")
    assert 0.9 < order < 2.1, f"observed order {order:.3f}, errors {errors}"
    assert errors[-1] < 1e-3


def stuck_and_slipping(segments):
    """Load angle of a drive whose pulleys stick, slip and turn back under a torque above their friction."""
    drive_pulley, load_pulley = LOOP.pulley
    pulleys = replace(drive_pulley, coulomb_friction=0.02), replace(load_pulley, coulomb_friction=5e-4)
    result = simulate(
        replace(LOOP, pulley=pulleys),
        0.02,
        torque=lambda time: 0.2 * np.sin(2.0 * np.pi * 100.0 * time),
        scheme=Scheme(segments=segments, cfl=0.8),
        recording=Recording(rate=2000.0),
    )
    assert np.any(result.channel("load_speed")[1:] == 0.0), "the load pulley never sticks"
    assert np.any(result.channel("load_speed") != 0.0), "the load pulley never slips"
    return result.load_angle


@pytest.mark.verify
@pytest.mark.parametrize("shape", ["half-sine", "triangle"])
def test_the_default_resolution_reaches_one_per_cent(shape, measured):
    """Envelopes of load angle and midpoint over 1 s at 81.6 Hz after plucks of 1 mm, 3.26 N, Gamma 2 1/s."""
    plucks = tuple(Pluck(height=1e-3, span=span, shape=shape) for span in ("upper", "lower"))
    found = [
        simulate(
            PLUCKED,
            1.0,
            torque=Sine(amplitude=0.02, frequency=81.6),
            start=Start(plucks=plucks),
            scheme=scheme,
        )
        for scheme in (Scheme(), Scheme(segments=800))
    ]
    errors = []
    for signals in zip(*((r.load_angle, r.midpoint("upper")[:, 2]) for r in found), strict=True):
        ours, fine = (envelope(signal[:10_000]) for signal in signals)
        errors.append(np.max(np.abs(ours - fine)) / np.max(fine))
    measured("envelope of load angle {:.2g} %, of midpoint {:.2g} %".format(*(100 * e for e in errors)))
    for error in errors:
        assert error < 0.01, f"{100 * error:.2g} %"


# --- Axial dampers with the matrix of a straight rope beside the bent one's
SHAPES = {
    "half-sine": (Pluck(height=5e-3, shape="half-sine"), Pluck(height=5e-3, shape="half-sine", plane="v")),
    "kink": (Pluck(height=5e-3, shape="triangle", place=0.15),),
}


@pytest.mark.parametrize(("shape", "most"), [("half-sine", 5e-6), ("kink", 2e-4)])
@pytest.mark.parametrize("damping", [0.003, 0.3])
def test_slopes_of_a_hundredth_hardly_change_the_dampers(shape, most, damping, monkeypatch, measured):
    """20 ms of 5 mm on half a metre; what the dampers take differs as little, and the budgets close alike."""
    drive = replace(PLUCKED, cable=replace(PLUCKED.cable, axial_damping=damping))
    runs = []
    for stiffest in (damped.STIFFEST, 0.0):
        monkeypatch.setattr(damped, "STIFFEST", stiffest)
        run = simulate(
            drive,
            0.02,
            torque=Sine(amplitude=0.02, frequency=60.0),
            start=Start(plucks=SHAPES[shape]),
            scheme=Scheme(segments=40),
            recording=Recording(rate=5000.0),
        )
        runs.append(run)
    ours, theirs = runs
    pairs = [(one.midpoint(), one.load_angle, one.channel("axial_loss")) for one in (ours, theirs)]
    errors = [np.abs(a - b).max() / np.abs(b).max() for a, b in zip(*pairs, strict=True)]
    measured(f"midpoint, load, axial loss differ by {errors[0]:.0e}, {errors[1]:.0e}, {errors[2]:.0e}")
    assert max(errors) < most, errors
    assert max(errors) > 0.0, "one and the same was computed twice"
    assert ours.energy_budget_error == pytest.approx(theirs.energy_budget_error, rel=1e-3)
