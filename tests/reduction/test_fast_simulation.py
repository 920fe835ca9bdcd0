"""The fast model behind the door of the exact one: agreement, energy, and where it must refuse."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.reduction.fast_simulation import FastScheme, simulate_fast
from cabledrive.simulation import Pluck, Recording, Scheme, SimulationStopped, Sine, Start, simulate

DRIVE = cd.load_drive("dissertation-2", overrides=["cable.pretension=3.26", "cable.transverse_damping=2"])
SEGMENTS = 400  # the corners of a triangle want a fine chain as referee
TORQUE = Sine(amplitude=0.02, frequency=81.6)


def plucked(shape, height=1e-3):
    return Start(plucks=tuple(Pluck(height=height, span=span, shape=shape) for span in ("upper", "lower")))


def envelope(signal, window=250):
    """Peaks of windows of two forcing periods, linear trend removed."""
    x = np.linspace(-1.0, 1.0, signal.size)
    flat = np.abs(signal - np.polyval(np.polyfit(x, signal, 1), x))
    return flat[: flat.size // window * window].reshape(-1, window).max(axis=1)


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


def test_energy_budget_closes_with_order_two(measured):
    """Halving the step divides the error of the budget by four: the splitting's own order."""
    errors = [
        simulate_fast(
            DRIVE, 0.3, torque=TORQUE, start=plucked("half-sine"), scheme=FastScheme(sines=2, step=h)
        ).energy_budget_error
        for h in (4e-4, 2e-4, 1e-4)
    ]
    order = np.log2(errors[1] / errors[2])
    usual = simulate_fast(DRIVE, 1.0, torque=TORQUE, start=plucked("half-sine")).energy_budget_error
    measured(f"budget: order {order:.2f}, {usual:.1e} of the energy handled at the default step, 1 s")
    assert errors[-1] < 1e-4
    assert order == pytest.approx(2.0, abs=0.2), f"errors {errors}"


def test_a_motion_that_outgrows_everything_ends_there_and_keeps_what_came_before():
    """A pluck of a tenth of the span makes the motion diverge; finite records are kept, without warnings."""
    with pytest.raises(SimulationStopped, match=r"slack at t =|exceeds the span") as stop:
        simulate_fast(DRIVE, 0.1, start=Start(plucks=(Pluck(height=0.1),)))
    result = stop.value.result
    assert 0 < result.time.size < 0.1 * 5000
    assert np.all(np.isfinite(result.rows))
    assert result.steps * result.step == pytest.approx(result.time[-1])


def test_a_run_that_does_not_fit_into_memory_is_refused():
    with pytest.raises(cd.InputRefused, match="GB of memory, at most 4 GB are used: lower rate"):
        simulate_fast(DRIVE, 5000.0)


def test_slack_ends_the_run_with_the_span_and_time():
    with pytest.raises(SimulationStopped, match="slack at t =") as stop:
        simulate_fast(DRIVE, 0.2, torque=Sine(amplitude=2.0, frequency=81.7))
    assert stop.value.result.slack_events


def test_torque_above_the_models_frequencies_is_refused():
    with pytest.raises(cd.InputRefused, match="where the fast model ends"):
        simulate_fast(DRIVE, 0.1, torque=Sine(amplitude=0.01, frequency=900.0))


def test_a_steep_pluck_is_reported():
    with pytest.raises(SimulationStopped, match="slope"):
        simulate_fast(DRIVE, 0.05, start=plucked("half-sine", 0.02), scheme=FastScheme(sines=1))


def test_result_file_appears_whole_and_is_not_overwritten(tmp_path):
    path = tmp_path / "run.nc"
    result = simulate_fast(DRIVE, 0.02, torque=TORQUE, output=path)
    assert path.stat().st_size > 0
    assert result.path == path
    with pytest.raises(cd.InputRefused, match="exists"):
        simulate_fast(DRIVE, 0.02, torque=TORQUE, output=path)
