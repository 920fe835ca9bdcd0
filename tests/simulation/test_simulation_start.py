"""How runs start, which grids of time they take, what is refused, and what comes out."""

import re
from dataclasses import replace
from math import pi

import numpy as np
import pytest
import xarray
from hypothesis import given
from hypothesis import strategies as st
from kernel_cases import chain_matrices
from scipy.linalg import eigh

from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.mesh import mesh_of
from cabledrive.mechanics.rest import rest_state
from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.drive_parts import Carriage
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.schema import content_hash
from cabledrive.reduction import simulate_fast
from cabledrive.simulation import (
    CarriageForce,
    Constant,
    Multisine,
    Pluck,
    Recording,
    Sampled,
    Scheme,
    Sine,
    Start,
    Sweep,
    simulate,
)
from cabledrive.simulation.case import case_of
from cabledrive.simulation.methods import largest_stable_step
from cabledrive.simulation.network.mesh import rest_of
from cabledrive.simulation.signals import checked_signal, signal_of
from cabledrive.simulation.start import at_start

DRIVE, STIFF = load_drive("dissertation-2").listed, load_drive("dissertation-3").listed
LENGTH = DRIVE.pulley_distance
GUIDED = replace(DRIVE, carriage=(Carriage(mass=1e-3, position=0.25),))
MOTORED = load_drive("dissertation-3").listed


def displaced(*plucks, drive=DRIVE, segments=40, **start):
    drive = replace(drive, layout=replace(drive.layout, gravity=0.0))
    mesh = mesh_of(drive.machine, segments)
    law = cable_law(drive.cable)
    rest = rest_of(mesh, [law] * len(mesh.pieces), np.zeros(2))
    return mesh, at_start(mesh, [law], rest, Start(plucks=plucks, **start))[0]


@pytest.mark.parametrize(("shape", "waves"), [("half-sine", 1), ("sine-2", 2), ("sine-5", 5)])
def test_sines_are_the_modes_of_a_string(shape, waves):
    mesh, x = displaced(Pluck(height=2e-3, span="lower", plane="v", shape=shape))
    np.testing.assert_allclose(x[1, 41:], 2e-3 * np.sin(waves * pi * mesh.positions[1] / LENGTH), atol=1e-17)


def test_a_named_pluck_ends_at_a_guided_carriage():
    """The carriage at a quarter of the span holds it: the triangle reaches from there to the load pulley."""
    mesh, x = displaced(Pluck(height=1e-3), drive=GUIDED)
    expected = np.interp(mesh.positions[0] / LENGTH, [0, 0.25, 0.5, 1], [0, 0, 1, 0])
    np.testing.assert_allclose(x[2, :41], 1e-3 * expected, atol=1e-17)


@given(
    segments=st.integers(3, 40),
    places=st.lists(st.floats(0.01, 0.99), max_size=3, unique_by=lambda x: round(x, 2)),
    masses=st.lists(st.floats(1e-6, 1.0), min_size=3, max_size=3),
    kind=st.sampled_from(["loop", "line"]),
    motored=st.booleans(),
    holding=st.sampled_from([None, 1.0, 100.0, 1e4]),
)
def test_the_largest_step_is_stable_and_not_far_below_the_limit(
    segments, places, masses, kind, motored, holding
):
    """Any drive: highest frequency of the chain times step at most 2, and at least 1.4 without a motor."""
    motor = replace(MOTORED.motor, holding_stiffness=holding) if motored else None
    drive = replace(MOTORED if motored else DRIVE, motor=motor)
    carriages = tuple(Carriage(mass=m, position=p) for m, p in zip(masses, places, strict=False))
    mesh, law = (
        mesh_of(replace(drive, kind=kind, carriage=carriages).machine, segments),
        cable_law(drive.cable),
    )
    springs, mass = chain_matrices(mesh, np.full(2, law.stiffness))
    highest = np.sqrt(eigh(springs, mass, eigvals_only=True)[-1])
    product = highest * largest_stable_step(mesh, [law] * len(mesh.pieces))
    assert (1.3 if motored else 1.4) < product < 2.0 * (1.0 + 1e-12), f"{product:.3f}"


@pytest.mark.parametrize("segments", [3, 12])
@pytest.mark.parametrize(
    "name", ["camera-winches", "corexy", "lift-2-to-1", "printer-idlers", "ropeway-towers"]
)
def test_the_largest_step_of_a_machine_with_routes_is_stable_and_near_the_limit(name, segments):
    """Bodies that several ropes hold, short spans between idlers, springs: all axes of all ropes together."""
    case = case_of(load_drive(name), 1e-3, scheme=Scheme(segments=segments))
    stiffness = [law.largest_stiffness() for law in case.laws]
    springs, mass = chain_matrices(case.mesh, stiffness, axes=(0, 1, 2))
    product = np.sqrt(eigh(springs, mass, eigvals_only=True)[-1]) * case.grid.largest_step
    assert 1.7 < product < 2.0 * (1.0 + 1e-12), f"{product:.3f}"


HELD = replace(DRIVE, pulley=(DRIVE.pulley[0], replace(DRIVE.pulley[1], fixed=True)))


def asked(scheme=None, pluck=None, start=None, recording=None, **others):
    """What `simulate` is asked for; its parts are made here, where some are refused."""
    parts = {"scheme": scheme and Scheme(**scheme), "recording": recording and Recording(**recording)}
    parts["start"] = Start(plucks=(Pluck(**pluck),)) if pluck else start and Start(**start)
    return {name: part for name, part in parts.items() if part} | others


PUSH = CarriageForce(signal=1.0)
SQUEEZED = {"height": -0.02, "plane": "u", "shape": "sine-2"}
BRIEF = CarriageForce(signal=Sampled(values=[0.0, 1.0], rate=1e3))
LINE = replace(DRIVE, kind="line")


@pytest.mark.parametrize(
    ("words", "parts"),
    [  # what the command refuses as well is in its own table
        ("cfl = 1.2: the method is stable above 0 and up to 1", {"scheme": {"cfl": 1.2}}),
        ("cfl = nan", {"scheme": {"cfl": np.nan}}),
        ("step = -1e-06 s must be above 0", {"scheme": {"step": -1e-6}}),
        ('method = "euler" is not one of its values', {"scheme": {"method": "euler"}}),
        ('slack = "stopp" is not one of its values .did you mean "stop"', {"scheme": {"slack": "stopp"}}),
        ("smoothing_speed = 0 rad/s", {"scheme": {"friction": "smoothed", "smoothing_speed": 0}}),
        (
            "torque on drive pulley ends at 0.009 s, before the run",
            {"torque": Sampled(values=np.zeros(10), rate=1e3)},
        ),
        ("height = nan m must be finite", {"pluck": {"height": np.nan}}),
        ('plane = "x" is not one', {"pluck": {"plane": "x"}}),
        ("place = 1.5 must lie between 0 and 1", {"pluck": {"place": 1.5}}),
        ('shape = "square" is not one', {"pluck": {"height": 1e-3, "shape": "square"}}),
        ("needs 3 or more finite numbers", {"pluck": {"shape": [0.0, np.nan, 0.0]}}),
        ("where a pulley or a carriage holds it", {"pluck": {"shape": [0, 1e-3, 1e-3]}}),
        ("drive_speed = nan rad/s must be finite", {"start": {"drive_speed": np.nan}}),
        (
            'speeds of "load pulley" = -1.0: take one of drive pulley',
            {"drive": HELD, "start": {"load_speed": 1.0}},
        ),
        ('"lower" is no span: take one of upper', {"drive": LINE, "pluck": {"span": "lower"}}),
        ("is held by a guided carriage", {"drive": GUIDED, "pluck": {"place": 0.25}}),
        ("force on carriage 0, but the drive has 0", {"forces": [PUSH]}),
        ("which is guided: push along u", {"drive": GUIDED, "forces": [replace(PUSH, plane="w")]}),
        ("force on carriage 0 ends at", {"drive": GUIDED, "forces": [BRIEF]}),
        ("probe at 3.0 m of upper", {"recording": {"probes": (("upper", 3.0),)}}),
        ("fields = -1 must be a whole number", {"recording": {"fields": -1}}),
        ("records of this run take .* GB", {"duration": 1e4, "recording": {"rate": 1e5}}),
        ("does not know carriages", {"drive": GUIDED, "scheme": {"method": "node-centred"}}),
        ("11: an error estimate halves", {"scheme": {"segments": 11}, "error_estimate": True}),
        ("does not know slack", {"scheme": {"method": "node-centred", "slack": "tension-only"}}),
        ("weak-consistent", {"scheme": {"method": "energy-conserving", "model": "weak"}}),
        ("verlet", {"scheme": {"method": "energy-conserving", "slack": "tension-only"}}),
        ("upper span is slack at x = .* lower the pluck", {"pluck": SQUEEZED}),
    ],
)
def test_a_run_that_makes_no_sense_is_refused_in_one_line(words, parts):
    with pytest.raises(InputRefused, match=words) as caught:
        simulate(**{"drive": DRIVE, "duration": 0.01, **asked(**parts)})
    assert "\n" not in str(caught.value)


def test_a_run_that_diverges_stops_at_the_first_energy_that_is_not_finite():
    """A torque beyond all bounds: the line says when and where, and the record before it is finite."""
    result = simulate(
        DRIVE,
        0.1,
        torque=lambda t: 1e150 * t,
        scheme=Scheme(segments=10, slack="record", model="weak-consistent"),
    )
    assert re.search(r"diverged: the energy is not finite from t = .* s on", result.stopped)
    assert np.isfinite(result.rows).all()


@pytest.mark.parametrize("joint", [135.0, 2.0, None])
def test_a_motor_that_holds_the_weights_lets_nothing_move(joint, measured):
    """The joint starts with the twist of the torque; else the carriage would swing on joint and cable."""
    motor = replace(MOTORED.motor, joint_stiffness=joint, offset_torque=0.0, coulomb_friction=0.0)
    steep = replace(MOTORED.layout, inclination=pi / 6)
    drive = replace(MOTORED, motor=motor, layout=steep, carriage=(Carriage(mass=2e-2, position=0.3),))
    held = rest_state(drive).holding_torque
    run = simulate(
        drive,
        0.3,
        torque=Sampled(values=np.full(4, held), rate=10.0),
        start=Start(from_equilibrium=True, hold="drive"),
        scheme=Scheme(segments=20),
        recording=Recording(fields=1),
    )
    moved = float(np.abs(run.fields - run.fields[0]).max())
    measured(f"joint {joint} N m/rad: {moved:.1e} m under {held:.3g} N m")
    assert moved < 1e-9, f"{moved}"


# --- Torques and forces: their values, and which are refused
TIME = np.linspace(0.0, 2.0, 4001)


@pytest.mark.parametrize("logarithmic", [False, True])
def test_a_sweep_runs_through_its_frequencies_and_stays_at_the_last(logarithmic):
    """Frequency of a unit sine by its value and derivative."""
    sweep = Sweep(amplitude=1.0, start=20.0, end=80.0, duration=1.5, logarithmic=logarithmic)
    time = TIME[1:][np.abs(sweep.at(TIME[1:])) < 0.5]
    slope = (sweep.at(time + 1e-6) - sweep.at(time - 1e-6)) / 2e-6
    frequency = np.abs(slope) / np.sqrt(1.0 - sweep.at(time) ** 2) / (2.0 * np.pi)
    share = np.minimum(time / 1.5, 1.0)
    expected = 20.0 * 4.0**share if logarithmic else 20.0 + 60.0 * share
    np.testing.assert_allclose(frequency, expected, rtol=1e-4)


def test_a_multisine_is_the_sum_of_its_sines():
    sines = [Sine(amplitude=a, frequency=f, phase=p) for a, f, p in ((1.0, 3.0, 0.1), (0.5, 7.0, 0.0))]
    both = Multisine(amplitudes=(1.0, 0.5), frequencies=(3.0, 7.0), phases=(0.1, 0.0))
    np.testing.assert_allclose(both.at(TIME), sum(s.at(TIME) for s in sines), atol=1e-15)


def test_samples_are_met_exactly_and_joined_by_lines_or_held():
    values = np.random.default_rng(0).standard_normal(11)
    at_samples = np.arange(11) / 5.0
    np.testing.assert_array_equal(Sampled(values=values, rate=5.0).at(at_samples), values)
    between = Sampled(values=values, rate=5.0).at(at_samples[:-1] + 0.05)
    np.testing.assert_allclose(between, 0.75 * values[:-1] + 0.25 * values[1:])
    held = Sampled(values=values, rate=5.0, hold=True)
    np.testing.assert_array_equal(held.at(at_samples[:-1] + 0.199), values[:-1])
    assert (held.lasts, Sampled(values=values, rate=5.0).lasts) == (2.2, 2.0)


def test_a_held_sample_begins_at_its_time_whatever_the_rounding():
    """Times computed as step * j meet the samples of a controller, never the one before."""
    held = Sampled(values=np.arange(5001.0), rate=5000.0, hold=True)
    for steps in (3, 7, 17, 34):
        time = np.arange(0, 1000) * steps * (1.0 / 5000.0 / steps)
        np.testing.assert_array_equal(held.at(time), np.arange(1000.0))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Constant(np.nan), "value = nan must be finite"),
        (lambda: Sine(amplitude=1.0, frequency=np.inf), "frequency = inf must be finite"),
        (lambda: Sampled(values=[0.0, np.nan], rate=1.0), "sample 1 is nan"),
        (lambda: Sampled(values=[], rate=1.0), "not a row of samples"),
        (lambda: Sampled(values=[0.0, 1.0], rate=0.0), "rate = 0.0 Hz must be above 0"),
        (lambda: Sweep(amplitude=1.0, start=0.0, end=1.0, duration=1.0, logarithmic=True), "above 0 Hz"),
        (lambda: Sweep(amplitude=1.0, start=0.0, end=1.0, duration=0.0), "duration = 0 s"),
        (lambda: Multisine(amplitudes=(1.0,), frequencies=(1.0, 2.0)), "1 amplitudes, 2 frequencies"),
        (lambda: Multisine(amplitudes=(1.0,), frequencies=(np.nan,)), "not finite"),
        (lambda: signal_of("much", "torque"), "torque is a str"),
        (
            lambda: checked_signal(Sampled(values=np.zeros(10), rate=10.0), "torque", 1.0, 0.01),
            "torque ends at 0.9 s",
        ),
    ],
)
def test_a_signal_that_makes_no_sense_is_refused(make, words):
    with pytest.raises(InputRefused, match=words):
        make()


# --- What comes out of runs: labelled data, files, error estimates
OPTIONS = {
    "torque": Sine(amplitude=0.02, frequency=81.7),
    "start": Start(plucks=(Pluck(height=1e-3, shape="half-sine"),)),
    "scheme": Scheme(segments=20),
}
RECORDING = Recording(rate=2000.0, fields=5, probes=(("lower", 0.3), ("upper", 0.9)))


def test_a_file_holds_the_dataset_with_units_for_everything(tmp_path):
    path = tmp_path / "run.nc"
    result = simulate(DRIVE, 0.05, **OPTIONS | {"recording": RECORDING, "output": path})
    with xarray.open_dataset(path, engine="h5netcdf") as stored:
        xarray.testing.assert_identical(stored.drop_attrs(), result.to_xarray().drop_attrs())
        assert dict(stored.attrs) == result.to_xarray().attrs
        for name, variable in result.to_xarray().variables.items():
            assert stored[name].attrs == variable.attrs, name
    assert {own.name for own in result.channels if " at " not in own.name} < set(result.to_xarray().data_vars)
    for name, variable in result.to_xarray().data_vars.items():
        assert variable.attrs["units"], name
        assert variable.attrs["long_name"], name
    np.testing.assert_allclose(result.to_xarray()["probe_position"][2:], [0.3, 0.9])
    assert result.to_xarray().attrs["drive_hash"] == content_hash(DRIVE)


@pytest.mark.parametrize(("shape", "order"), [("half-sine", 2.0), ("triangle", 1.0)])
def test_the_error_estimate_covers_the_error_and_sees_its_order(shape, order):
    """Against n = 640: the estimate at n = 80 is not below half the error, nor above five times it."""
    options = {"torque": OPTIONS["torque"], "start": Start(plucks=(Pluck(height=1e-3, shape=shape),))}
    coarse, fine = (
        simulate(DRIVE, 0.1, **options, scheme=Scheme(segments=n), error_estimate=n == 80) for n in (80, 640)
    )
    estimate = coarse.error_estimate
    assert estimate["segments"] == [80, 40, 20]
    true = {
        "load_angle": np.max(np.abs(coarse.load_angle - fine.load_angle)),
        "w at the middle of upper": np.max(np.abs(coarse.midpoint()[:, 2] - fine.midpoint()[:, 2])),
    }
    for name, error in true.items():
        found = estimate[name]["error"]
        assert 0.5 * error < found < 5.0 * error, f"{name}: estimated {found:.2e}, true {error:.2e}"
    assert estimate["w at the middle of upper"]["order"] == pytest.approx(order, abs=0.5)


@pytest.mark.parametrize("run", [simulate, simulate_fast])
def test_a_run_says_what_the_file_states_and_it_leaves_out(run):
    motor = replace(STIFF.motor, coulomb_friction=0.0)
    smooth = replace(STIFF, motor=motor, pulley=[replace(own, coulomb_friction=0.0) for own in STIFF.pulley])
    plain = run(smooth, 1e-3).assumptions
    bent = replace(STIFF.cable, bending_stiffness=1e-4)
    stated = run(replace(smooth, cable=bent, motor=replace(motor, backlash=1e-3)), 1e-3)
    bends, play = (own for own in stated.assumptions if own not in plain)
    assert ["0.0001 N m^2" in bends, "backlash" in play] == [True, True]


def test_the_fast_model_says_that_its_cable_does_not_slip():
    wrapped = [replace(own, coulomb_friction=0.0, capstan_friction=0.1) for own in STIFF.pulley]
    drive = replace(STIFF, motor=replace(STIFF.motor, coulomb_friction=0.0), pulley=wrapped)
    said = [" ".join(run(drive, 1e-3).assumptions) for run in (simulate_fast, simulate)]
    assert ["does not slip" in words for words in said] == [True, False]
