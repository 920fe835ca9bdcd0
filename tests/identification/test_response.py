"""Frequency responses: exact on exact signals, with their noise, and enough to distinguish Models 1 to 4."""

import numpy as np
import pytest

from cabledrive.identification.excitation import (
    crest_factor,
    low_crest_multisine,
    multisine_lines,
    random_multisine,
)
from cabledrive.identification.frequency_response import response_by_periods, response_by_segments
from cabledrive.identification.model_choice import choose_model
from cabledrive.identification.response_models import chain_for, fit_response
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import speed_response

RATE, PERIOD = 2000.0, 2000
LINES = multisine_lines(PERIOD, RATE, 1.0, 250.0, odd=True)
TRUE = {
    "motor_inertia": 0.0011,
    "drive_inertia": 0.000642,
    "load_inertia": 0.00235,
    "viscous_friction": 0.0031,
    "joint_stiffness": 135.0,
    "joint_damping": 0.075,
    "cable_stiffness": 850.0,
    "cable_damping": 0.18,
}
ROUGH = {
    name: value * factor
    for (name, value), factor in zip(TRUE.items(), [0.8, 1.2, 0.9, 1.4, 0.7, 0.6, 1.3, 0.7], strict=True)
}
RADIUS = 0.04


def through(values, response):
    """Periodic signal through a system, exactly."""
    spectrum = np.fft.rfft(values)
    spectrum[1:] *= response(np.fft.rfftfreq(values.size, 1 / RATE)[1:])
    return np.fft.irfft(spectrum, values.size)


def drive(frequency):
    return speed_response(chain_for(4, TRUE, RADIUS), 2 * np.pi * frequency)


def periodic(periods, noise, seed, response=drive):
    rng = np.random.default_rng(seed)
    u = low_crest_multisine(PERIOD, RATE, LINES).values
    y = np.tile(through(u, response), periods)
    return np.tile(u, periods), y + noise * rng.normal(size=y.size)


def test_crest_reduction_beats_the_best_of_ten_draws():
    low = low_crest_multisine(PERIOD, RATE, LINES)
    drawn = random_multisine(PERIOD, RATE, LINES, 10, np.random.default_rng(0))
    assert low.crest < 1.6 < drawn.crest, f"{low.crest:.3f}, {drawn.crest:.3f}"
    spectrum = np.abs(np.fft.rfft(low.values))
    silent = np.setdiff1d(np.arange(spectrum.size), LINES)
    assert spectrum[silent].max() < 1e-9 * spectrum[LINES].min()
    assert crest_factor(np.ones(3)) == 1.0


def test_a_noise_free_period_gives_the_response_exactly():
    u, y = periodic(4, 0.0, 0)
    found = response_by_periods(u, y, 1 / RATE, PERIOD, LINES)
    np.testing.assert_allclose(found.response, drive(found.frequency), rtol=1e-9)
    np.testing.assert_allclose(found.frequency, LINES * RATE / PERIOD)


def test_the_stated_deviation_is_the_deviation():
    """Over 40 repeats and all lines, errors in units of their deviation have unit mean square."""
    ratios = []
    for seed in range(40):
        u, y = periodic(9, 2.0, seed)
        found = response_by_periods(u, y, 1 / RATE, PERIOD, LINES, skipped=0)
        off = np.abs(found.response - drive(found.frequency)) / found.deviation
        ratios.append(np.median(off**2))
    # Student's t with 16 degrees of freedom for the complex value: the median of F(2, 16).
    assert np.mean(ratios) == pytest.approx(0.723, rel=0.05), f"{np.mean(ratios):.3f}"


def test_distortion_is_found_at_silent_lines_and_not_without():
    u, y = periodic(6, 0.001, 1)
    clean = response_by_periods(u, y, 1 / RATE, PERIOD, LINES)
    bent = response_by_periods(u, y + 0.02 * y**2, 1 / RATE, PERIOD, LINES)
    assert np.median(bent.nonlinear) > 10 * np.median(clean.nonlinear)


def first_order(frequency):
    return 1.0 / (1.0 + 2j * np.pi * frequency * 0.02)


def noisy(noise_in, noise_out, seed=3, seconds=200):
    rng = np.random.default_rng(seed)
    u = rng.normal(size=int(seconds * RATE))
    y = through(u, first_order)
    return u + noise_in * rng.normal(size=u.size), y + noise_out * rng.normal(size=y.size)


@pytest.mark.parametrize("estimator, noise_in, noise_out", [("H1", 0.0, 0.05), ("H2", 0.5, 0.0)])
def test_each_estimator_is_unbiased_under_the_noise_it_is_made_for(estimator, noise_in, noise_out):
    u, y = noisy(noise_in, noise_out)
    found = response_by_segments(u, y, 1 / RATE, estimator=estimator).between(2.0, 40.0)
    ratio = np.mean(found.response / first_order(found.frequency))
    assert abs(ratio - 1) < 0.02, f"{ratio:.4f}"


def noisy_response(noise, seed=0, periods=10):
    u, y = periodic(periods, noise, seed)
    return response_by_periods(u, y, 1 / RATE, PERIOD, LINES, skipped=0)


def test_model_4_is_recovered_from_its_own_response(measured):
    fit = fit_response(noisy_response(1e-9), 4, ROUGH, radius=RADIUS)
    measured(f"worst {max(abs(fit[name] / value - 1.0) for name, value in TRUE.items()):.1e} relative")
    for name, value in TRUE.items():
        assert fit[name] == pytest.approx(value, rel=1e-5), name


def test_intervals_of_the_fit_cover_as_they_say():
    """95 % of 20 noisy responses, eight parameters each."""
    inside = []
    for seed in range(20):
        fit = fit_response(noisy_response(0.5, seed), 4, ROUGH, radius=RADIUS)
        inside += [low < TRUE[n] < high for n, low, high in zip(fit.names, fit.low, fit.high, strict=True)]
    assert 0.89 < np.mean(inside) < 0.995, f"observed {np.mean(inside):.3f}"


def lumped(model):
    stiff = dict(TRUE)
    total = sum(TRUE[f"{n}_inertia"] for n in ("motor", "drive", "load"))
    return {
        1: {"inertia": total, "viscous_friction": TRUE["viscous_friction"]},
        2: stiff | {"load_inertia": TRUE["drive_inertia"] + TRUE["load_inertia"]},
        3: stiff | {"drive_inertia": TRUE["motor_inertia"] + TRUE["drive_inertia"]},
        4: stiff,
    }[model]


@pytest.mark.parametrize("model", [1, 2, 3, 4])
def test_the_model_that_made_the_response_is_chosen(model, measured):
    chain = chain_for(model, lumped(model), RADIUS)
    u, y = periodic(8, 0.3, model, response=lambda f: speed_response(chain, 2 * np.pi * f))
    response = response_by_periods(u, y, 1 / RATE, PERIOD, LINES)
    known = ROUGH | {name: TRUE[name] for name in TRUE if name.endswith("inertia")}
    choice = choose_model(response, known, radius=RADIUS, inertias_known=True)
    measured(f"Model {choice.chosen} chosen")
    assert choice.chosen == model, choice.reason


def test_models_2_and_3_are_alike_from_the_motor_and_that_is_said():
    chain = chain_for(3, lumped(3), RADIUS)
    u, y = periodic(8, 0.3, 3, response=lambda f: speed_response(chain, 2 * np.pi * f))
    choice = choose_model(response_by_periods(u, y, 1 / RATE, PERIOD, LINES), ROUGH, radius=RADIUS, folds=2)
    assert choice.chosen in (2, 3)
    assert "Models 2 and 3 are equivalent" in choice.reason


def resonance(seconds, frequency=9.8, damping=0.02, rate=500.0):
    """A swept input, and the output of a resonance by the impulse response of its differential equation."""
    t = np.arange(0.0, seconds, 1.0 / rate)
    u = np.sin(2 * np.pi * (0.5 * t + 0.5 * (40.0 - 0.5) / seconds * t**2))
    w = 2 * np.pi * frequency
    swing = w * np.sqrt(1.0 - damping**2)
    kernel = w**2 / swing * np.exp(-damping * w * t) * np.sin(swing * t) / rate
    return u, lambda force: np.convolve(force, kernel)[: t.size]


@pytest.mark.parametrize("noise", [1e-4, 0.05, 1.0])
def test_a_sweep_keeps_the_records_in_which_it_passes_the_resonance(noise, measured):
    """Peak of 25 at 9.8 Hz: within a line of 0.125 Hz and what windows of 8 s can show of it."""
    u, move = resonance(120.0)
    y = move(u) + noise * np.random.default_rng(3).normal(size=u.size)
    found = response_by_segments(u, y, 0.002, segment=8.0, overlap=6.0).between(0.5, 40.0)
    peak = int(np.argmax(found.magnitude))
    message = (
        f"{found.magnitude[peak]:.2f} at {found.frequency[peak]:.3f} Hz, {found.left_out} records left out"
    )
    measured(message)
    assert found.left_out == 0, message
    assert found.frequency[peak] == pytest.approx(9.8, abs=0.125), message
    assert found.magnitude[peak] == pytest.approx(25.0, rel=0.15), message


def test_a_blow_beside_a_sweep_is_left_out_with_its_time_and_kept_on_request():
    """At 70 s, where the sweep is at 23.5 Hz, twice the largest motion of the sweep."""
    u, move = resonance(120.0)
    blow = np.zeros(u.size)
    blow[35_000:35_010] = np.hanning(10)
    blow *= 2.0 * np.abs(move(u)).max() / np.abs(move(blow)).max()
    y = move(u + blow) + 0.01 * np.random.default_rng(3).normal(size=u.size)
    found = response_by_segments(u, y, 0.002, segment=2.0, overlap=1.0)
    assert 1 <= found.left_out <= 3, found.blows
    for record in found.blows:
        assert record.start <= 70.02, found.blows
        assert record.end >= 70.0, found.blows
    assert response_by_segments(u, y, 0.002, segment=2.0, overlap=1.0, robust=False).left_out == 0


def test_a_response_from_a_file_is_averaged_without_its_outliers(tmp_path):
    """Seven repeats at twelve frequencies in rad/s, one of each a hundred times too large."""
    from cabledrive.identification.response_file import read_response

    rng = np.random.default_rng(5)
    omega = np.repeat(np.linspace(5.0, 60.0, 12), 7)
    true = 1.0 / (1.0 + 0.05j * omega)
    values = true * (1.0 + 0.01 * (rng.normal(size=84) + 1j * rng.normal(size=84)))
    values[3::7] *= 100.0
    rows = np.column_stack([omega, np.abs(values), np.degrees(np.angle(values))])
    text = "\n".join(",".join(repr(float(x)) for x in row) for row in rng.permutation(rows))
    (tmp_path / "r.csv").write_text("omega [rad/s],magnitude,phase [deg]\n" + text + "\n")
    found = read_response(tmp_path / "r.csv")
    assert found.left_out >= 12
    np.testing.assert_allclose(2 * np.pi * found.frequency, np.linspace(5.0, 60.0, 12), rtol=1e-9)
    off = np.abs(found.response / true[::7] - 1)
    assert off.max() < 0.02, off
    assert (off < 4 * found.deviation / np.abs(found.response)).all(), (off, found.deviation)
    (tmp_path / "x.csv").write_text("a,b\n1,2\n")
    with pytest.raises(InputRefused, match="no columns omega or frequency"):
        read_response(tmp_path / "x.csv")
