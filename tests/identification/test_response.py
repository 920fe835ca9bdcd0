"""Frequency responses: exact on exact signals, with their noise, and enough to distinguish Models 1 to 4."""

from dataclasses import replace

import numpy as np
import pytest
from reproduction.bench import BENCH_TESTS, TORQUE_PER_VOLT, bench_command, bench_rig, response_command
from scipy.linalg import expm
from scipy.signal import lfilter

from cabledrive.identification import log_response, planning, response_models, signals
from cabledrive.identification.axis.axis import AxisOptions, axis_of
from cabledrive.identification.logs.log import log_of
from cabledrive.parameters import InputRefused, load_drive
from cabledrive.reduction.lumped_chain import speed_response
from cabledrive.rig.experiment import Excitation, command_of, experiment, load_excitation, plan_experiment
from cabledrive.rig.virtual_rig import Imperfections, rig_of, run_rig
from command import answer, call, object_of

RATE, PERIOD = 2000.0, 2000
LINES = planning.multisine_lines(PERIOD, RATE, 1.0, 250.0, odd=True)
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
INERTIAS = {name: TRUE[name] for name in TRUE if name.endswith("inertia")}
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
    return speed_response(response_models.chain_for(4, TRUE, RADIUS), 2 * np.pi * frequency)


def periodic(periods, noise, seed, response=drive):
    rng = np.random.default_rng(seed)
    u = planning.low_crest_multisine(PERIOD, LINES)
    y = np.tile(through(u, response), periods)
    return np.tile(u, periods), y + noise * rng.normal(size=y.size)


def test_crest_reduction_beats_the_best_of_ten_draws():
    low = planning.low_crest_multisine(PERIOD, LINES)
    drawn = planning.random_multisine(PERIOD, LINES, 10, np.random.default_rng(0))
    crests = planning.crest_factor(low), planning.crest_factor(drawn)
    assert crests[0] < 1.6 < crests[1], crests
    spectrum = np.abs(np.fft.rfft(low))
    silent = np.setdiff1d(np.arange(spectrum.size), LINES)
    assert spectrum[silent].max() < 1e-9 * spectrum[LINES].min()
    assert planning.crest_factor(np.ones(3)) == 1.0


def by_periods(u, y, period=PERIOD, rate=RATE, lines=LINES, skipped=1):
    """Mean response over the periods of a multisine, and its deviation by their spread."""
    u, y = (np.fft.rfft(values.reshape(-1, period)[skipped:], axis=1)[:, lines] for values in (u, y))
    h = y.mean(axis=0) / u.mean(axis=0)
    deviation = (y - h * u).std(axis=0, ddof=1) / np.sqrt(len(y)) / np.abs(u.mean(axis=0))
    ones = np.ones(lines.size)
    return signals.FrequencyResponse(
        frequency=lines * rate / period, response=h, deviation=deviation, coherence=ones, averages=len(y)
    )


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
    found = signals.response_by_segments(u, y, 1 / RATE, estimator=estimator).between(2.0, 40.0)
    ratio = np.mean(found.response / first_order(found.frequency))
    assert abs(ratio - 1) < 0.02, f"{ratio:.4f}"


def noisy_response(noise, seed=0, periods=10):
    u, y = periodic(periods, noise, seed)
    return by_periods(u, y, skipped=0)


def test_model_4_is_recovered_from_its_own_response(measured):
    fit = response_models.fit_response(noisy_response(1e-9), 4, ROUGH, radius=RADIUS)
    measured(f"worst {max(abs(fit[name] / value - 1.0) for name, value in TRUE.items()):.1e} relative")
    for name, value in TRUE.items():
        assert fit[name] == pytest.approx(value, rel=1e-5), name


def test_intervals_of_the_fit_cover_as_they_say():
    """95 % of 20 noisy responses, eight parameters each."""
    inside = []
    for seed in range(20):
        fit = response_models.fit_response(noisy_response(0.5, seed), 4, ROUGH, radius=RADIUS)
        inside += [low < TRUE[n] < high for n, low, high in ((n, *fit.bounds(n)) for n in fit.names)]
    assert 0.89 < np.mean(inside) < 0.995, f"observed {np.mean(inside):.3f}"


@pytest.mark.parametrize("model", [1, 2, 3, 4])
def test_the_model_that_made_the_response_is_chosen(model, measured):
    values = {
        1: {"inertia": sum(INERTIAS.values()), "viscous_friction": TRUE["viscous_friction"]},
        2: TRUE | {"load_inertia": TRUE["drive_inertia"] + TRUE["load_inertia"]},
        3: TRUE | {"drive_inertia": TRUE["motor_inertia"] + TRUE["drive_inertia"]},
        4: TRUE,
    }[model]
    chain = response_models.chain_for(model, values, RADIUS)
    u, y = periodic(8, 0.3, model, response=lambda f: speed_response(chain, 2 * np.pi * f))
    response = by_periods(u, y)
    choice = response_models.choose_model(response, ROUGH | INERTIAS, radius=RADIUS, inertias_known=True)
    measured(f"Model {choice.model} chosen")
    assert choice.model == model


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
    found = signals.response_by_segments(u, y, 0.002, (8.0, 6.0)).between(0.5, 40.0)
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
    found = signals.response_by_segments(u, y, 0.002, (2.0, 1.0))
    assert 1 <= found.left_out <= 3, found.blows
    for record in found.blows:
        assert record.start <= 70.02, found.blows
        assert record.end >= 70.0, found.blows
    assert signals.response_by_segments(u, y, 0.002, (2.0, 1.0), robust=False).left_out == 0


PEAKS = 500.0
"""Rate of logs of narrow resonances [Hz]."""


def resonant(kind, rng, noise, seconds=60.0):
    """A log of a slow mode and two resonances of 0.2 to 2 % damping, its truth, and their frequencies."""
    t, damping = np.arange(round(seconds * PEAKS)) / PEAKS, np.exp(rng.uniform(np.log(0.002), np.log(0.02)))
    first = rng.uniform(6.0, 12.0)
    modes = np.array([1.0, first, first + rng.uniform(0.5, 15.0)])
    omega, share = 2 * np.pi * modes, np.array([0.7, damping, damping * rng.uniform(0.5, 2.0)])
    plant = np.zeros((6, 6))
    plant[[0, 2, 4], [1, 3, 5]] = 1.0
    plant[[1, 3, 5], [0, 2, 4]], plant[[1, 3, 5], [1, 3, 5]] = -(omega**2), -2.0 * share * omega
    b, c = np.zeros(6), np.zeros(6)
    b[1::2], c[::2] = omega**2, (1.0, 0.3, -0.1)
    whole = np.zeros((7, 7))
    whole[:6, :6], whole[:6, 6] = plant / PEAKS, b / PEAKS
    step = expm(whole)  # exact under a held input
    lengths = rng.integers(50, 300, t.size)
    u = {
        "noise": rng.normal(size=t.size),
        "steps": np.repeat(rng.uniform(0.5, 1.5, t.size) * np.resize([1, -1], t.size), lengths)[: t.size],
        "chirp": np.sin(2 * np.pi * (0.5 * t + 0.5 * 39.5 / seconds * t**2)),
    }[kind]
    poles, shapes = np.linalg.eig(step[:6, :6])  # each mode alone is a filter of the first order
    sizes = (c @ shapes) * np.linalg.solve(shapes, step[:6, 6])
    y = sum(lfilter([0.0, one], [1.0, -pole], u) for one, pole in zip(sizes, poles, strict=True)).real
    y += noise * y.std() * rng.normal(size=y.size)

    def true(frequency):
        z = np.exp(2j * np.pi * frequency / PEAKS)
        return np.array([c @ np.linalg.solve(one * np.eye(6) - step[:6, :6], step[:6, 6]) for one in z])

    return log_of(t, {"torque": u, "angle": y}, {"torque": "N m", "angle": "rad"}), true, modes[1:]


@pytest.mark.parametrize(
    "kind, estimator, most",
    [
        ("noise", "H1", 0.5),
        ("steps", "H1", 0.5),
        ("chirp", "H1", 0.5),
        ("noise", "H2", 0.003),
        ("steps", "Hv", 0.003),
    ],
)
def test_the_deviation_covers_what_windows_smooth_away_at_narrow_peaks(kind, estimator, most, measured):
    """At least 95 % of the lines at peaks, and of all others, lie within two deviations, none far outside."""
    near, far, before, wider = [], [], [], []
    for seed in range(910, 914):
        rng = np.random.default_rng([seed, len(kind)])
        segment, noise = rng.choice([1.0, 2.0, 6.0]), most * rng.choice([0.02, 0.2, 1.0])
        log, true, peaks = resonant(kind, rng, noise)
        found = log_response.response(log, "torque", "angle", segment=segment, estimator=estimator).between(
            1.0, 38.0
        )
        error = np.abs(found.response - true(found.frequency))
        inside = (np.abs(found.frequency[:, None] - peaks) < 2.0 / segment).any(axis=1)
        near += [*(error / found.deviation)[inside]]
        far += [*(error / found.deviation)[~inside]]
        before += [*(error / found.noise)[inside]]
        wider += [*(found.deviation / found.noise)[~inside]]
    words = (
        f"within two deviations {100 * np.mean(np.array(near) < 2):.0f} % of {len(near)} lines at peaks, "
        f"{100 * np.mean(np.array(far) < 2):.1f} % elsewhere; farthest {max(near):.1f}; by noise alone "
        f"{100 * np.mean(np.array(before) < 2):.0f} % and {max(before):.0f}"
    )
    measured(words)
    assert np.mean(np.array(near) < 2.0) >= 0.95, words
    assert np.mean(np.array(far) < 2.0) >= 0.95, words
    assert max(near) < 8.0, words
    assert np.mean(np.array(before) < 2.0) < 0.7, "the peaks must be narrow enough to need it"
    assert kind == "chirp" or np.median(wider) < 2.5, f"{np.median(wider):.2f} times as wide elsewhere"


def test_a_response_from_a_file_is_averaged_without_its_outliers(tmp_path):
    """Seven repeats at twelve frequencies in rad/s, one of each a hundred times too large."""
    from cabledrive.identification.log_response import read_response

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


def test_a_measured_response_is_read_at_the_door(tmp_path):
    (tmp_path / "r.csv").write_text(
        "frequency [Hz],magnitude [dB],phase [deg]\n1,0,0\n2,-20,-90\n2,-20,-90\n"
    )
    found = answer("response", tmp_path / "r.csv")
    assert found["magnitude"] == pytest.approx([1.0, 0.1])
    assert found["phase_deg"] == pytest.approx([0.0, -90.0])
    assert found["deviation"][0] is None
    assert found["coherence"] == [None, None]
    assert "does not say" in found["coherence_reason"]


# --- What `response` says of its coherence, against the textbook's value for a gain with noise added
def written(path, coherence):
    """White input through a gain of two, with as much white noise as makes this coherence."""
    rng = np.random.default_rng(1)
    torque = rng.standard_normal(40_000)
    noise = 2.0 * np.sqrt(1.0 / coherence - 1.0) * rng.standard_normal(torque.size)
    rows = np.column_stack([1e-3 * np.arange(torque.size), torque, 2.0 * torque + noise])
    np.savetxt(path, rows, delimiter=",", header="time [s],torque [N m],speed [rad/s]", comments="")
    return path


@pytest.mark.parametrize("coherence", [0.23, 0.95])
def test_the_median_coherence_is_printed_and_a_low_one_warned_of(coherence, tmp_path, measured):
    log = written(tmp_path / "log.csv", coherence)
    channels = ("--input", "torque [N m]", "--response", "speed [rad/s]")
    arguments = ("response", log, *channels, "--segment", "0.25s")
    said = call(*arguments).output
    printed = float(said.split("coherence ")[1].split()[0])
    measured(f"coherence {printed} for {coherence}")
    assert printed == pytest.approx(coherence, abs=0.03)
    warnings = object_of(call(*arguments, "--json").stdout)["warnings"]
    assert ("warning: coherence" in said) == (coherence < 0.8) == bool(warnings)


# --- The amplifier's gain and lag are in the response from command to torque, Eq. (4.20)
GAIN = 10 ** (4.2 / 20)


def test_a_lag_far_above_the_band_gets_no_number_but_a_bound():
    frequency, noise, whole = np.linspace(5.0, 500.0, 120), 0.02, np.ones(120)
    exact = response_models.amplifier_response(frequency, GAIN, 1e6, 1.5e-4)
    parts = np.random.default_rng(3).normal(size=(2, 120)) * noise / np.sqrt(2)
    response = {"response": exact + parts[0] + 1j * parts[1], "deviation": noise * whole, "averages": 10.0}
    found = signals.FrequencyResponse(frequency=frequency, coherence=whole, **response)
    fit = response_models.fit_amplifier(found)
    assert np.isnan(fit.bandwidth.value)
    assert fit.bandwidth.low > 500.0
    assert "constant gain" in fit.findings[0]
    assert fit.gain.low < GAIN < fit.gain.high


def test_the_amplifier_of_the_virtual_rig_is_found_in_its_log(measured):
    """4.2 dB and 1 kHz, from 4 s of 1,000 sines at 5 kHz."""
    rig, rng = rig_of(load_drive("dissertation-3").listed, 4), np.random.default_rng(2015)
    log = run_rig(rig, response_command(rng, duration=4.0), rng)
    fit = response_models.identify_amplifier(log)
    gain = fit.gain
    measured(
        f"{fit.decibels:.3f} dB, {gain.value:.4f} ({gain.low:.4f} to {gain.high:.4f}) N m/V, "
        f"{fit.bandwidth.value:.0f} Hz"
    )
    assert abs(fit.gain.value - GAIN) < 3.3 * fit.gain.standard_error, fit.gain  # 99.9 %
    assert 1.9 < np.log(gain.high / gain.value) * gain.value / gain.standard_error < 2.6  # of Student's t
    assert fit.decibels == pytest.approx(4.2, abs=0.01)
    assert fit.bandwidth.value == pytest.approx(1000.0, rel=0.05), fit.bandwidth
    slower = replace(rig, imperfections=replace(rig.imperfections, current_bandwidth=300.0))
    fit = response_models.identify_amplifier(run_rig(slower, response_command(rng, duration=4.0), rng))
    assert fit.bandwidth.value == pytest.approx(300.0, rel=0.05), fit.bandwidth


@pytest.mark.verify
def test_intervals_from_logs_hold_gain_and_bandwidth(measured):
    """200 logs of 4 s: 91 to 99 % of the intervals of gain and bandwidth hold; errors are as large as stated.

    One standard error of a share is 1.5 %, of the spread over the standard error stated 5 %.
    """
    from cabledrive.identification.logs.log import log_of
    from cabledrive.rig.virtual_rig import acting_torque

    rig = rig_of(load_drive("dissertation-3").listed, 1)
    held, off, message = np.zeros(2), [], []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        command = response_command(rng, duration=4.0)
        torque = acting_torque(rig, command, rng, 4)
        weights = np.array([0.5, 1.0, 1.0, 1.0, 0.5]) / 4.0
        padded = np.concatenate([np.full(2, torque[0]), torque, np.full(2, torque[-1])])
        logged = np.convolve(padded, weights, "valid")[::4] + 0.006 * rng.normal(size=command.size)
        channels = {"command_voltage": command, "torque": logged}
        fit = response_models.identify_amplifier(log_of(np.arange(command.size) / 5000.0, channels, {}))
        truth = ((fit.gain, GAIN), (fit.bandwidth, 1000.0))
        held += [estimate.low <= value <= estimate.high for estimate, value in truth]
        off.append([estimate.value - value for estimate, value in truth])
        message.append([estimate.standard_error for estimate, _ in truth])
    ratio = np.sqrt(np.mean(np.square(off), axis=0) / np.mean(np.square(message), axis=0))
    measured(
        f"gain and bandwidth: {held[0]:.0f} and {held[1]:.0f} of 200 intervals hold, "
        f"spread over the stated error {ratio[0]:.2f} and {ratio[1]:.2f}"
    )
    assert np.all((held >= 182) & (held <= 198)), f"observed {held} of 200"
    assert np.all((ratio > 0.85) & (ratio < 1.15)), f"observed {ratio}"


# --- Joint and cable of Table 6.2 from a virtual multisine through the motor encoder, and their model
RATE_TABLE, PERIOD_TABLE = 5000.0, 10_000
PRINTED = {name: TRUE[name] for name in TRUE if name.startswith(("cable", "joint"))}
ROUGH_TABLE = INERTIAS | {name: 0.7 * value for name, value in PRINTED.items()} | {"viscous_friction": 0.004}


@pytest.fixture(scope="module")
def response():
    """Odd lines of 0.5 Hz spacing up to 250 Hz; a constant part keeps the shaft turning one way."""
    periods, rng = 13, np.random.default_rng(2015)
    lines = planning.multisine_lines(PERIOD_TABLE, RATE_TABLE, 1.0, 250.0, odd=True)
    command = 0.12 + 0.3 * np.tile(planning.low_crest_multisine(PERIOD_TABLE, lines), periods)
    log = run_rig(rig_of(load_drive("dissertation-3").listed, 4), command, rng)
    speed = signals.difference(log.channel("angle"), log.interval)
    # The log holds the mean of the torque over each interval, which lowers a line by its sinc.
    mean = np.sinc(np.arange(PERIOD_TABLE // 2 + 1) / PERIOD_TABLE)
    torque = log.channel("torque").reshape(periods, PERIOD_TABLE)
    torque = np.fft.irfft(np.fft.rfft(torque, axis=1) / mean, PERIOD_TABLE, axis=1).ravel()
    return by_periods(torque, speed, PERIOD_TABLE, RATE_TABLE, lines, skipped=5)


def test_table_6_2_lies_inside_its_intervals(response, measured):
    """Every printed value inside its 99.9 % interval, at seed 2015; inertias known from the bench tests."""
    fit = response_models.fit_response(response, 4, ROUGH_TABLE, radius=RADIUS, fixed=INERTIAS)
    bounds = {name: fit.bounds(name, 0.999) for name in PRINTED}
    measured(", ".join(f"{n} {fit[n]:.5g} ({low:.5g} to {high:.5g})" for n, (low, high) in bounds.items()))
    assert 0.8 < fit.misfit < 1.5, f"{fit.misfit:.3f}"
    for name, value in PRINTED.items():
        low, high = bounds[name]
        assert low < value < high, f"{name}: {low:.6g} to {high:.6g}, printed {value}"
        assert high - low < 0.1 * value, f"{name}: {low:.6g} to {high:.6g}"


def test_model_4_is_chosen_over_1_to_3(response, measured):
    choice = response_models.choose_model(response, ROUGH_TABLE, radius=RADIUS, inertias_known=True)
    measured(f"Model {choice.model} chosen")
    assert choice.model == 4


# --- The intervals that a test will give are computed before it is run
TEST = replace(BENCH_TESTS[1], duration=12.0)
GUESS = planning.AxisGuess(
    inertia=TEST.inertia, viscous=TEST.viscous, coulomb=TEST.coulomb, offset=TEST.offset
)
TORQUE = TORQUE_PER_VOLT * bench_command(TEST, np.random.default_rng(1))


def spread(test, noise, repeats):
    """Standard deviation of the estimates over repeats of one test, and the prediction."""
    command = bench_command(test, np.random.default_rng(1))
    found = []
    for seed in range(repeats):
        rig = bench_rig(test, Imperfections(torque_noise=noise))
        log = run_rig(rig, command, np.random.default_rng(seed))
        one = axis_of([log], AxisOptions(bandwidth=20.0, lag=False)).regressed()
        found.append([one[name] for name in one.parameters])
    guess = planning.AxisGuess(
        inertia=test.inertia, viscous=test.viscous, coulomb=test.coulomb, offset=test.offset
    )
    plan = planning.plan_test(
        TORQUE_PER_VOLT * command, 1e-3, guess, planning.Instruments(torque_noise=noise, bandwidth=20.0)
    )
    sizes = np.array([test.inertia, test.viscous, test.coulomb, test.offset])
    return np.std(found / sizes, axis=0, ddof=1) / np.array(list(plan.relative_errors.values()))


@pytest.mark.parametrize("test", BENCH_TESTS, ids=lambda test: test.name)
@pytest.mark.parametrize(
    "seconds, repeats, most", [(12.0, 16, 0.54), pytest.param(30.0, 100, 0.25, marks=pytest.mark.verify)]
)
def test_predicted_standard_errors_of_every_bench_test(test, seconds, repeats, most, measured):
    """Torque noise 50 mN m; repeats give a standard deviation to 18 % and 7 %: three of that, a quarter."""
    ratios = spread(replace(test, duration=seconds), 0.05, repeats)
    measured("spread over prediction, J, b, c, d: " + ", ".join(f"{ratio:.2f}" for ratio in ratios))
    assert (np.abs(ratios - 1.0) < most).all(), ratios


def test_limits_are_kept_by_the_largest_amplitude_and_named_when_passed():
    limits = {"torque": 0.6, "speed": 25.0, "stroke": 6.0}
    scale = planning.largest_amplitude(TORQUE, 1e-3, GUESS, limits)
    peaks = planning.plan_test(scale * TORQUE, 1e-3, GUESS, limits=limits).peaks
    shares = [peaks[name] / limit for name, limit in limits.items()]
    assert max(shares) == pytest.approx(1.0, rel=1e-3), shares
    passed = planning.plan_test(1.2 * scale * TORQUE, 1e-3, GUESS, limits=limits).findings
    assert any("above its limit" in finding for finding in passed), passed


def test_a_line_on_the_pulley_mode_of_a_tuned_drive_is_warned_of_above_its_threshold_only(measured):
    """Configuration 2 near its tuned pretension: 0.9 mN m at 81.74 Hz is the threshold."""
    settings = ("cable.pretension=3.3", "cable.transverse_damping=1.0", "pulley.1.viscous_friction=1e-5")
    drive, time = load_drive("dissertation-2", overrides=settings).listed, np.arange(8000) / 1000.0

    def warned(frequency, amplitude):
        return planning.resonance_warnings(drive, amplitude * np.sin(2 * np.pi * frequency * time), 1000.0)

    measured("; ".join(warned(81.74, 2e-3)) + f"; {len(warned(81.74, 4e-4))} warnings of 0.4 mN m")
    assert "would drive the 1:2 resonance" in warned(81.74, 2e-3)[0]
    assert warned(81.74, 4e-4) == ()
    assert warned(40.0, 0.05) == ()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("frequencies = 3", "is no list"),
        ('band = ["1 Hz"]', "band holds 1 frequencies"),
        ('lines = "all"', "must be a whole number"),
        ("trials = 0", "at least 1"),
        ("odd = 3", "neither true nor false"),
        ("kind = 3", 'excitation "3" is unknown'),
        ("period = 0", "must be above 0"),
        ("amplitude = true", "is no quantity"),
        ("frequencies = []\namplitudes = []", "frequencies holds none"),
    ],
)
def test_an_excitation_with_a_value_of_another_kind_is_refused(tmp_path, line, words):
    (tmp_path / "e.toml").write_text(line + "\n")
    with pytest.raises(InputRefused, match=words):
        load_excitation(tmp_path / "e.toml")


def without(**sensors):
    drive = load_drive("dissertation-3").listed
    return replace(drive, sensors=replace(drive.sensors, **sensors))


SHORT = Excitation(duration=2.0)
BLIND = {"motor_encoder": None, "drive_encoder": None, "load_encoder": None}


@pytest.mark.parametrize(
    ("planned", "words"),
    [
        (lambda: planning.plan_test(0.05 * TORQUE, 1e-3, GUESS), "does not move the axis"),
        (lambda: plan_experiment(without(motor_encoder=None), SHORT), r"sensors\.motor_encoder is missing"),
        (lambda: experiment(without(), SHORT, seed=-1), "seed = -1 must not be negative"),
        (lambda: rig_of(without(**BLIND), 1), "no encoder on motor"),
        (lambda: rig_of(without(sample_rate=None), 1), r"sensors\.sample_rate is missing"),
        (
            lambda: command_of(replace(SHORT, kind="multisine", period=1e-6), 1e3, np.random.default_rng(0)),
            "holds 0 samples",
        ),
        (lambda: plan_experiment(without(), SHORT, model=1, stroke=0.0), "stroke = 0"),
    ],
)
def test_what_cannot_be_planned_is_refused(planned, words):
    with pytest.raises(InputRefused, match=words):
        planned()


def test_the_door_plans_an_experiment_without_running_it(tmp_path):
    """Model 4 under a multisine: stiffness of the joint to a few per cent; nothing is written."""
    toml = 'kind = "multisine"\nduration = "8 s"\namplitude = "1 V"\nband = ["1 Hz", "250 Hz"]\nlines = 120\n'
    (tmp_path / "e.toml").write_text(toml + 'period = "1 s"\nodd = false\n')
    found = answer("experiment", "dissertation-3", "--excitation", tmp_path / "e.toml", "--plan")
    assert 0.0 < found["relative_standard_error"]["joint_stiffness"] < 0.05
    assert set(found["peaks"]) == {"torque", "speed", "stroke"}
    assert [path.name for path in tmp_path.iterdir()] == ["e.toml"]


def test_a_segment_of_few_samples_is_to_be_lengthened():
    u = np.random.default_rng(0).normal(size=4000)
    with pytest.raises(InputRefused, match=r"holds 5 samples, 8 are the least: lengthen it to 0.008 s"):
        signals.response_by_segments(u, u, 1e-3, (0.005, 0.001))
    with pytest.raises(InputRefused, match="shorten it"):
        signals.response_by_segments(u, u, 1e-3, (3.0, 0.2))
