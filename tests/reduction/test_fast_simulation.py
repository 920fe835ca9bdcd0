"""The fast model behind the door of the exact one: agreement, energy, many runs at once; refusals."""

from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.fast_members import fast_ensemble
from cabledrive.reduction.fast_simulation import FastScheme, simulate_fast
from cabledrive.reduction.friction_integration import direction, integrate_chain
from cabledrive.reduction.lumped_chain import lumped_model
from cabledrive.reduction.network_axis import as_axis
from cabledrive.reduction.threshold import growth_torque
from cabledrive.reduction.uniform_tension import uniform_tension_model
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate
from command import refused
from network_samples import route
from resonance_samples import TUNED, envelope

DRIVE = cd.load_drive(
    "dissertation-2", overrides=["cable.pretension=3.26", "cable.transverse_damping=2"]
).listed
LOSSES = ["cable.transverse_damping=2", "pulley.1.viscous_friction=2e-5", "motor.coulomb_friction=0"]
JOINTED = cd.load_drive("dissertation-3", overrides=LOSSES).listed
SEGMENTS = 400  # the corners of a triangle want a fine chain as referee
TORQUE = Sine(amplitude=0.02, frequency=81.6)


def plucked(shape, height=1e-3):
    return Start(plucks=tuple(Pluck(height=height, span=span, shape=shape) for span in ("upper", "lower")))


@pytest.mark.parametrize(("shape", "sines", "bound"), [("half-sine", 1, 0.01), ("triangle", 48, 0.015)])
def test_envelopes_follow_the_exact_loop(shape, sines, bound, measured):
    """Forced at 81.6 Hz, plucks of 1 mm: load angle and midpoint within one per cent of their largest."""
    recording = Recording(rate=10_000.0)
    exact = simulate(
        DRIVE, 0.5, torque=TORQUE, start=plucked(shape), scheme=Scheme(segments=SEGMENTS), recording=recording
    )
    fast = simulate_fast(
        DRIVE,
        0.5,
        torque=TORQUE,
        start=plucked(shape),
        scheme=FastScheme(sines=sines, step=1e-4),
        recording=recording,
    )
    t, errors = np.arange(0.0, 0.4999, 1e-4), {}
    for name, of in (("load", lambda r: r.load_angle), ("midpoint", lambda r: r.midpoint()[:, 2])):
        curves = [envelope(np.interp(t, run.time, of(run))) for run in (exact, fast)]
        errors[name] = np.max(np.abs(curves[0] - curves[1])) / np.max(curves[0])
    worst = ", ".join(f"{name} {100 * error:.3g} %" for name, error in errors.items())
    measured(f"envelopes, {shape}, sines {sines}: {worst}")
    for name, error in errors.items():
        assert error < bound, f"{name}: envelope error {error:.2e}"


def test_midpoints_move_along_the_cable_as_in_the_exact_loop(measured):
    torque, recording, off = Sine(amplitude=0.01, frequency=60.0), Recording(rate=2000.0), 0.0
    fast, exact = (own(JOINTED, 0.3, torque=torque, recording=recording) for own in (simulate_fast, simulate))
    for name in ("u at the middle of upper", "u at the middle of lower"):
        one, other = (
            run.rows[:, [channel.name for channel in run.channels].index(name)] for run in (fast, exact)
        )
        truth = np.interp(fast.time, exact.time, other)
        off = max(off, float(np.abs(one - truth).max() / np.abs(truth).max()))
    measured(f"{off:.1e}")
    assert off < 5e-3


@pytest.mark.parametrize("drive", [DRIVE, JOINTED], ids=["loop", "motor joint"])
def test_energy_budget_closes_with_order_two(drive, measured):
    """Halving the step divides the error of the budget by four: the splitting's own order."""
    errors = [
        simulate_fast(
            drive, 0.3, torque=TORQUE, start=plucked("half-sine"), scheme=FastScheme(sines=2, step=h)
        ).energy_budget_error
        for h in (4e-4, 2e-4, 1e-4)
    ]
    order = np.log2(errors[1] / errors[2])
    usual = simulate_fast(drive, 1.0, torque=TORQUE, start=plucked("half-sine")).energy_budget_error
    measured(f"budget: order {order:.2f}, {usual:.1e} of the energy handled at the default step, 1 s")
    assert errors[-1] < 1e-4
    assert order == pytest.approx(2.0, abs=0.2), f"errors {errors}"


FORCED = cd.load_drive("dissertation-2", overrides=["cable.transverse_damping=2"]).listed
SCHEME = FastScheme(sines=3, step=2e-4)
COMMON = {"torque_frequency": 81.6, "pluck_upper": 1e-3, "pluck_lower": -5e-4}


def test_members_are_single_runs(measured):
    axes = {"torque_amplitude": [0.0, 0.01], "pretension": [3.2, 3.3, 4.0]}
    found = fast_ensemble(
        FORCED, 0.1, axes, common=COMMON, pluck_shape="triangle", scheme=SCHEME, rate=1000.0
    )
    assert found.load_angle.dims == ("torque_amplitude", "pretension", "time")
    worst = 0.0
    plucks = tuple(Pluck(height=h, span=s, shape="triangle") for s, h in (("upper", 1e-3), ("lower", -5e-4)))
    for amplitude in axes["torque_amplitude"]:
        for pretension in axes["pretension"]:
            single = simulate_fast(
                cd.load_drive(
                    "dissertation-2",
                    overrides=["cable.transverse_damping=2", f"cable.pretension={pretension}"],
                ).listed,
                0.1,
                torque=Sine(amplitude=amplitude, frequency=81.6),
                start=Start(plucks=plucks),
                scheme=SCHEME,
                recording=Recording(rate=1000.0),
            )
            member = found.sel(torque_amplitude=amplitude, pretension=pretension)
            for name, expected in (
                ("load_angle", single.load_angle),
                ("drive_angle", single.drive_angle),
                ("upper_midpoint", single.midpoint("upper")[:, 2]),
                ("lower_midpoint", single.midpoint("lower")[:, 2]),
            ):
                scale = np.max(np.abs(single.load_angle)) + np.max(np.abs(expected))
                worst = max(worst, float(np.max(np.abs(member[name] - expected)) / scale))
                np.testing.assert_allclose(member[name], expected, atol=1e-9 * scale, err_msg=name)
    measured(f"members within {worst:.1e} of single runs, relative to the largest motion")


def test_members_for_which_the_model_does_not_hold_say_so_and_show_no_motion():
    found = fast_ensemble(
        FORCED, 0.2, {"torque_amplitude": [0.01, 1.0], "pluck_upper": [1e-3, 3e-2]}, common=COMMON
    )
    reasons = found.stopped.values
    assert reasons[0, 0] == ""
    assert "slack" in reasons[1, 0], reasons
    assert "slope" in reasons[0, 1] or "slack" in reasons[0, 1]
    assert np.isfinite(found.load_angle[0, 0]).all()
    assert np.isnan(found.load_angle.values[reasons != ""]).all()
    assert found.least_tension_upper[1, 0] < 0.0


def test_a_plucked_span_is_as_much_tauter_as_its_sine_is_longer():
    """Ends at rest: EA (pi h / 2 L)^2 of a half-sine of height h, and nothing in the other span."""
    found = simulate_fast(DRIVE, 1e-3, start=Start(plucks=(Pluck(height=2e-3, shape="half-sine"),)))
    raised = DRIVE.cable.axial_rigidity * (np.pi * 1e-3 / DRIVE.pulley_distance) ** 2
    assert found.channel("mean tension, upper")[0] == pytest.approx(3.26 + raised, rel=1e-12)
    assert found.channel("mean tension, lower")[0] == 3.26


# --- What the reduced models refuse, and runs that they end: each row a call, and what is named
SENSORS = ("sensors.sample_rate=5000", "sensors.motor_encoder=4000", "sensors.load_encoder=4000")
RIG = cd.load_drive("dissertation-3").listed
HELD = replace(RIG, motor=replace(RIG.motor, holding_stiffness=25.0))


def over(axes):
    return lambda: fast_ensemble(DRIVE, 0.05, axes, common={"torque_amplitude": 0.01})


def without_fit(*overrides):
    return lambda: uniform_tension_model(cd.load_drive("dissertation-2", overrides=overrides).listed)


ROWS = [
    (lambda: autoparametric_model(TUNED, load_torque=1.0), ["lower span"]),
    (over({"pretention": [1.0]}), ["pretention", "pretension"]),
    (over({"torque_frequency": [80.0, 900.0]}), ["torque", "676.6 Hz"]),
    (over({"pretension": [np.nan]}), ["pretension", "finite", "N"]),
    (lambda: simulate_fast(DRIVE, 5000.0), ["GB", "4 GB", "rate"]),
    (lambda: simulate_fast(DRIVE, 0.1, torque=Sine(amplitude=0.01, frequency=900.0)), ["torque", "676.6 Hz"]),
    (lambda: growth_torque(autoparametric_model(TUNED), 1.0, 1.0), ["factor"]),
    (lambda: growth_torque(autoparametric_model(TUNED), 10.0, 0.0), ["duration"]),
    (without_fit("pulley.0.coulomb_friction=0.01"), ["coulomb_friction"]),
    (without_fit("pulley.1.fixed=true"), ["fixed"]),
    (without_fit("kind=line"), ["loop"]),
    (lambda: integrate_chain(lumped_model(HELD), np.zeros(5), 1e-3), ["holding stiffness = 25 N m/rad"]),
    (lambda: direction(2, "mass"), ["mass", "inertia"]),
    (lambda: lumped_model(cd.load_drive("dissertation-2").listed, 4), ["model", "4"]),
    (lambda: lumped_model(cd.load_drive("dissertation-transporter").listed, 3), ["model", "carriages", "1"]),
    (lambda: lumped_model(RIG, 5), ["model", "5"]),
    (lambda: as_axis(route("finger")), ["springs or ropes hold"]),
    (lambda: as_axis(route("serpentine")), ["0 given"]),
]


@pytest.mark.parametrize("call, named", ROWS)
def test_what_cannot_be_reduced_is_refused_in_one_line_that_names_it(call, named):
    refused(call, *named)


STEEP = Start(plucks=tuple(Pluck(height=0.02, span=span) for span in ("upper", "lower")))


@pytest.mark.parametrize(
    "choices, cause",
    [
        ({"torque": Sine(amplitude=2.0, frequency=81.7)}, "slack at t ="),
        ({"start": STEEP, "scheme": FastScheme(sines=1)}, "slope"),
        ({"start": Start(plucks=(Pluck(height=0.1),))}, "at t ="),  # it diverges
    ],
)
def test_a_motion_beyond_the_model_ends_with_its_cause_and_keeps_what_came_before(choices, cause):
    result = simulate_fast(DRIVE, 0.2, **choices)
    assert cause in result.stopped
    assert bool(result.slack_events) == ("slack" in result.stopped)
    assert 0 < result.time.size < 0.2 * 5000
    assert np.all(np.isfinite(result.rows))
    assert result.steps * result.step == pytest.approx(result.time[-1])
