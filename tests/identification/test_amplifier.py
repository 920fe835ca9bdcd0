"""The amplifier's gain and lag are in the response from command to torque, Eq. (4.20)."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.identification.amplifier import amplifier_response, fit_amplifier, identify_amplifier
from cabledrive.identification.frequency_response import FrequencyResponse
from cabledrive.parameters import load_drive
from cabledrive.rig.bench.chapter_4 import response_command, rig_of
from cabledrive.rig.bench.virtual_rig import run_rig

GAIN = 10 ** (4.2 / 20)


def noisy(seed, bandwidth=800.0, delay=1.5e-4, noise=0.01):
    rng = np.random.default_rng(seed)
    frequency = np.linspace(5.0, 500.0, 120)
    exact = amplifier_response(frequency, GAIN, bandwidth, delay)
    parts = rng.normal(size=(2, frequency.size)) * noise / np.sqrt(2)
    return FrequencyResponse(
        frequency=frequency,
        response=exact + parts[0] + 1j * parts[1],
        deviation=np.full(frequency.size, noise),
        coherence=np.ones(frequency.size),
        averages=10.0,
    )


def test_intervals_of_gain_bandwidth_and_delay_hold_the_truth():
    """40 responses with 1 % noise: each 95 % interval holds its truth in at least 34."""
    held = np.zeros(3)
    for seed in range(40):
        fit = fit_amplifier(noisy(seed))
        truth = ((fit.gain, GAIN), (fit.bandwidth, 800.0), (fit.delay, 1.5e-4))
        held += [estimate.low <= value <= estimate.high for estimate, value in truth]
        assert fit.misfit == pytest.approx(1.0, abs=0.25)
    assert (held >= 34).all(), held


def test_a_lag_far_above_the_band_gets_no_number_but_a_bound():
    fit = fit_amplifier(noisy(3, bandwidth=1e6, noise=0.02))
    assert np.isnan(fit.bandwidth.value)
    assert fit.bandwidth.low > 500.0
    assert "constant gain" in fit.findings[0]
    assert fit.gain.low < GAIN < fit.gain.high


def test_the_amplifier_of_the_virtual_rig_is_found_in_its_log(measured):
    """4.2 dB and 1 kHz, from 4 s of 1,000 sines at 5 kHz."""
    rig, rng = rig_of(load_drive("dissertation-3"), 4), np.random.default_rng(2015)
    log = run_rig(rig, response_command(rng, duration=4.0), rng)
    fit = identify_amplifier(log)
    gain = fit.gain
    measured(
        f"{fit.decibels:.3f} dB, {gain.value:.4f} ({gain.low:.4f} to {gain.high:.4f}) N m/V, "
        f"{fit.bandwidth.value:.0f} Hz"
    )
    assert abs(fit.gain.value - GAIN) < 3.3 * fit.gain.standard_error, fit.gain  # 99.9 %
    assert fit.decibels == pytest.approx(4.2, abs=0.01)
    assert fit.volts_per_torque == pytest.approx(0.6166, rel=1e-3)
    assert fit.bandwidth.value == pytest.approx(1000.0, rel=0.05), fit.bandwidth
    slower = replace(rig, imperfections=replace(rig.imperfections, current_bandwidth=300.0))
    fit = identify_amplifier(run_rig(slower, response_command(rng, duration=4.0), rng))
    assert fit.bandwidth.value == pytest.approx(300.0, rel=0.05), fit.bandwidth


def amplifiers(seeds):
    """Logs of 4 s: intervals of gain and bandwidth that hold, and the spread over the stated error."""
    from cabledrive.identification.logs.log import log_of
    from cabledrive.rig.bench.virtual_rig import acting_torque

    rig = rig_of(load_drive("dissertation-3"), 1)
    held, off, message = np.zeros(2), [], []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        command = response_command(rng, duration=4.0)
        torque = acting_torque(rig, command, rng, 4)
        weights = np.array([0.5, 1.0, 1.0, 1.0, 0.5]) / 4.0
        padded = np.concatenate([np.full(2, torque[0]), torque, np.full(2, torque[-1])])
        logged = np.convolve(padded, weights, "valid")[::4] + 0.006 * rng.normal(size=command.size)
        channels = {"command_voltage": command, "torque": logged}
        fit = identify_amplifier(log_of(np.arange(command.size) / 5000.0, channels, {}))
        truth = ((fit.gain, GAIN), (fit.bandwidth, 1000.0))
        held += [estimate.low <= value <= estimate.high for estimate, value in truth]
        off.append([estimate.value - value for estimate, value in truth])
        message.append([estimate.standard_error for estimate, _ in truth])
    return held, np.sqrt(np.mean(np.square(off), axis=0) / np.mean(np.square(message), axis=0))


@pytest.mark.verify
def test_intervals_from_logs_hold_gain_and_bandwidth(measured):
    """200 logs of 4 s: 91 to 99 % of the intervals of gain and bandwidth hold; errors are as large as stated.

    One standard error of a share is 1.5 %, of the spread over the standard error stated 5 %.
    """
    held, ratio = amplifiers(range(200))
    measured(
        f"gain and bandwidth: {held[0]:.0f} and {held[1]:.0f} of 200 intervals hold, "
        f"spread over the stated error {ratio[0]:.2f} and {ratio[1]:.2f}"
    )
    assert np.all((held >= 182) & (held <= 198)), f"observed {held} of 200"
    assert np.all((ratio > 0.85) & (ratio < 1.15)), f"observed {ratio}"
