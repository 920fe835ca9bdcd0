"""Chapter 4: the rig and its amplifier, the camera, estimates and frequency responses on a virtual rig.

The measured logs are lost; a virtual rig that has the printed parameters stands for the print's.
"""

from dataclasses import replace
from functools import cache
from math import pi, sqrt

import numpy as np

from cabledrive.identification import IdentifyOptions, identify
from cabledrive.identification.camera_frames import levels_of, spots_of
from cabledrive.identification.estimates import Identification
from cabledrive.identification.log_response import compensated_torque
from cabledrive.identification.logs.log import Log
from cabledrive.identification.signals import (
    causal_filter,
    difference,
    ideal_low_pass,
    response_by_segments,
    zero_phase,
)
from cabledrive.parameters.arrays import Array, Complex
from cabledrive.reduction.lumped_chain import LumpedChain, speed_response
from cabledrive.rig import virtual_rig
from cabledrive.rig.virtual_rig import run_rig
from reproduction import appendix
from reproduction.bench import BENCH_TESTS, TORQUE_PER_VOLT, bench_command, bench_rig, response_command
from reproduction.drives import packaged
from reproduction.items import Found, Outcome
from reproduction.panel import panel

MOTOR, BOTH, WITH_LOAD = BENCH_TESTS
EXPERIMENTS = {
    "7": (BOTH, (3.0, 4.0), (0.1, 0.1)),
    "9": (BOTH, (1.0, 5.0), (0.1, 0.1)),
    "11": (BOTH, (1.0, 3.0, 5.0), (0.1, 0.1, 0.1)),
    "13": (MOTOR, (1.0, 3.0, 5.0), (0.05, 0.05, 0.1)),
    "15": (WITH_LOAD, (1.0, 3.0, 5.0), (0.05, 0.05, 0.1)),
}
"""Rig, frequencies [Hz] and amplitudes [V] of Section 4.2, by the figure of the regressors."""

SEED, ROWS, COLUMNS = 2015, 160, 224
CORNER, IDEAL, SMOOTHING = 20.0, 50.0, 0.5  # Hz, Hz, s/rad
WIDE = 3.5  # standard errors on each side of an estimate: 99.9 %
JOINT, JOINT_DAMPING = 135.0, 0.075
CLOSE = 0.25  # median difference that an eye calls a good agreement on logarithmic axes: 2 dB


def section_4_1(quick: bool) -> Outcome:
    """Every number of the description of the rig."""
    sensors, (gear, counts) = packaged("dissertation-3").sensors, appendix.gear_and_counts()
    assert sensors is not None
    torque, speed = appendix.NOMINAL_TORQUE, appendix.NOMINAL_SPEED
    found: Found = {"power": torque * speed * appendix.RPM, "speed": speed, "torque": torque, "gear": gear}
    found |= {"output_torque": gear * torque, "output_speed": speed / gear, "output_counts": counts * gear}
    found |= {"voltage": appendix.VOLTAGE, "counts": counts, "pulley_counts": sensors.load_encoder}
    return {f"section_4_1_{key}": value for key, value in found.items()}, []


def figure_4_6(quick: bool) -> Outcome:
    """Fig. 4.6: grey frame, threshold, unwanted pixels removed, centroid; on frames that are made up."""
    rng, truth, seen = np.random.default_rng(SEED), [], []
    for _ in range(20 if quick else 200):
        row, column = rng.uniform(60.0, 100.0), rng.uniform(100.0, 124.0)
        frame = _frame(row, column, rng)
        truth.append(row)
        seen.append(float(spots_of(frame, levels_of([frame]))[0, 0]))
    order = np.argsort(truth)
    curve = ("frames", np.array(truth)[order], np.array(seen)[order])
    title = "Centroid found over true place, made-up frames"
    drawn = panel("Fig. 4.6", title, "true row [pixel] | row found [pixel]", curve)
    error = rms(np.array(seen) - truth)
    return {"error": error, "figure_4_6": error < 0.2}, [drawn]


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def _frame(row: float, column: float, rng: np.random.Generator) -> Array:
    """A white segment of 3 by 24 pixels with soft edges, noise, and a few specks."""
    y, x = np.mgrid[0:ROWS, 0:COLUMNS]
    across = 1.0 / (1.0 + np.exp(4.0 * (np.abs(y - row) - 1.5)))
    along = 1.0 / (1.0 + np.exp(4.0 * (np.abs(x - column) - 12.0)))
    frame = 20.0 + 200.0 * across * along + rng.normal(0.0, 4.0, (ROWS, COLUMNS))
    specks = rng.integers(0, ROWS * COLUMNS, 8)
    frame.ravel()[specks] += 120.0
    return np.asarray(np.clip(frame, 0.0, 255.0), dtype=np.float64)


def section_4_3(quick: bool) -> Outcome:
    """The excitation and the windows of the frequency responses."""
    spacing, hann = (500.0 - 1.0) / (1000 - 1), np.hanning(5000)
    leak = np.abs(np.sum(hann * np.exp(2j * pi * spacing * np.arange(5000) / 5000.0))) / np.sum(hann)
    return {"spacing": spacing, "leak": leak}, []


def figure_4_21(quick: bool) -> Outcome:
    """Fig. 4.21 and (4.20): the amplifier's gain."""
    hertz = np.geomspace(1.0, 500.0, 200)
    bandwidth = packaged("dissertation-3").motor.current_bandwidth or np.inf  # type: ignore[union-attr]
    size = 20 * np.log10(TORQUE_PER_VOLT / np.hypot(1.0, hertz / bandwidth))
    current = TORQUE_PER_VOLT / (appendix.TORQUE_CONSTANT * appendix.gear_and_counts()[0])
    found = {"section_4_4_gain": 20 * np.log10(1.6218), "section_4_4_torque": TORQUE_PER_VOLT}
    found |= {"section_4_4_voltage": 1.0 / TORQUE_PER_VOLT, "section_4_4_current": 20 * np.log10(current)}
    found |= {"fall": size[0] - size[-1], "bandwidth": bandwidth, "figure_4_21": size[0] - size[-1] < 3.0}
    title = "Torque over voltage command; first-order torque loop chosen"
    curve = ("amplifier", hertz, size)
    return found, [panel("Fig. 4.21", title, "frequency [Hz] | gain [dB]", curve, log="x")]


@cache
def bench_log(name: str, frequencies: tuple[float, ...], amplitudes: tuple[float, ...]) -> Log:
    """Log of a rig of Table 4.1 under sines, frequencies [Hz] and amplitudes [V]."""
    rng = np.random.default_rng(SEED)
    (rig,) = (one for one in BENCH_TESTS if one.name == name)
    test = replace(rig, frequencies=frequencies, amplitudes=amplitudes)
    return run_rig(bench_rig(test), bench_command(test, rng), rng)


@cache
def estimated() -> tuple[Identification, ...]:
    """What the identification finds of the three rigs of Table 4.1."""
    logs = [bench_log(rig.name, rig.frequencies, rig.amplitudes) for rig in BENCH_TESTS]
    return tuple(identify(log, IdentifyOptions(check=False), method="output-error") for log in logs)


def _regression(log: Log) -> tuple[Array, Array, Array]:
    """Columns of (4.9) by plain differences and through the filter of (4.1), and the estimates J, b, c, d."""
    angle, h = log.channel("angle"), log.interval
    speed, acceleration = np.gradient(angle, h), np.gradient(np.gradient(angle, h), h)
    friction, ones = np.tanh(SMOOTHING * speed), -np.ones_like(angle)
    raw = np.column_stack([acceleration, speed, friction, ones])
    through = causal_filter(angle - angle[0], h, CORNER)
    others = [causal_filter(column, h, CORNER)[0] for column in (friction, ones)]
    filtered = np.column_stack([through[2], through[1], *others])
    kept = slice(round(0.5 / h), None)
    right = causal_filter(log.channel("torque"), h, CORNER)[0]
    return raw, filtered, np.linalg.lstsq(filtered[kept], right[kept], rcond=None)[0]


def experiment(regressors: str, quick: bool) -> Outcome:
    """Regressors before and after the filter, and the modelling error, of one experiment."""
    rig, frequencies, amplitudes = EXPERIMENTS[regressors]
    log = bench_log(rig.name, frequencies, amplitudes)
    angle, torque, h, time = log.channel("angle"), log.channel("torque"), log.interval, log.time
    raw, filtered, estimate = _regression(log)
    kept, inside = slice(round(0.5 / h), None), slice(round(1.0 / h), -round(1.0 / h))
    speed = ideal_low_pass(difference(angle, h), h, IDEAL)
    acceleration = ideal_low_pass(difference(speed, h), h, IDEAL)
    smooth = np.column_stack([acceleration, speed, np.tanh(SMOOTHING * speed), -np.ones_like(angle)])
    left = ideal_low_pass(smooth @ estimate - torque, h, IDEAL)
    share = rms(left[inside]) / rms(torque[inside])
    noise = [rms(raw[kept, k] - filtered[kept, k]) / rms(filtered[kept, k]) for k in (0, 1)]
    error = int(regressors) + 1
    found: Found = {"noise": noise, "share": 100 * share}
    found |= {"estimates": ", ".join(f"{x:.3g}" for x in estimate)}
    found |= {f"figure_4_{regressors}": noise[0] > noise[1], f"figure_4_{error}": share < 0.25}
    first, middle = time < 2.0, (time > 10.0) & (time < 12.0)
    panels = []
    for k, name in enumerate(("acceleration [rad/s^2]", "speed [rad/s]")):
        pair = ("unfiltered", raw), ("filtered", filtered)
        curves = ((words, time[first], one[first, k]) for words, one in pair)
        title = f"{name}, unfiltered and filtered"
        panels.append(panel(f"Fig. 4.{regressors}", title, f"time [s] | {name}", *curves))
    both = ("torque", time[middle], torque[middle]), ("error", time[middle], left[middle])
    title = "Modelling error beside the torque"
    return found, [*panels, panel(f"Fig. 4.{error}", title, "time [s] | torque [N m]", *both)]


def section_4_2(quick: bool) -> Outcome:
    """Friction that sticks through the regressor of (4.8): right within 5 % would be a smooth signum."""
    _, viscous, coulomb, _ = _regression(bench_log(BOTH.name, (3.0, 4.0), (0.1, 0.1)))[2]
    found = {"b": BOTH.viscous, "c": BOTH.coulomb, "viscous": viscous, "coulomb": coulomb}
    right = abs(viscous / BOTH.viscous - 1.0) < 0.05 and abs(coulomb / BOTH.coulomb - 1.0) < 0.05
    return found | {"section_4_2_tanh": right}, []


def table_4_1(quick: bool) -> Outcome:
    """Table 4.1: twelve estimates, with the half-width of their 99.9 % intervals."""
    found: Found = {"b1": 0.005 / 0.00216, "c1": 0.045 / 0.024}
    found["table_4_1_consistent"] = max(found["b1"], found["c1"]) < 1.5
    names = ("inertia", "viscous_friction", "coulomb_friction", "offset_torque")
    for rig, identification in zip(BENCH_TESTS, estimated(), strict=True):
        for name in names:
            one = identification.parameters[name]
            key = f"table_4_1_{rig.name.replace(' ', '_')}_{name.partition('_')[0]}"
            found[key] = one.value, WIDE * one.standard_error
    return found, []


def table_4_2(quick: bool) -> Outcome:
    """Table 4.2: inertias by differences."""
    motor, drive, load = (one.parameters["inertia"] for one in estimated())
    rows = {"j1": (drive.value, drive.standard_error), "j11": (motor.value, motor.standard_error)}
    for name, one in (("j12", drive), ("j2", load)):
        rows[name] = one.value - motor.value, np.hypot(one.standard_error, motor.standard_error)
    found: Found = {f"table_4_2_{name}": (value, WIDE * error) for name, (value, error) in rows.items()}
    exact = {"j1": 0.001742, "j11": 0.0011, "j12": 0.001742 - 0.0011, "j2": 0.00345 - 0.0011}
    return found | {f"table_4_2_{name}_arithmetic": value for name, value in exact.items()}, []


def measured_response(chain: LumpedChain) -> tuple[Array, Complex, float]:
    """Frequency [Hz], response of motor speed to compensated torque [rad/s / (N m)], difference from theory.

    Section 4.3 on a virtual rig with this chain, in windows of 2.5 s: the print's, 1 s, do not part its
    lines. The difference is the median from 5 to 100 Hz; above, counts of the encoder drown the speed.
    """
    rng = np.random.default_rng(SEED)
    rig = replace(virtual_rig.rig_of(packaged("dissertation-3")), chain=chain, encoders={"angle": 2600})
    log = run_rig(rig, response_command(rng, amplitude=1.0), rng)
    h, angle = log.interval, log.channel("angle")
    slow = difference(zero_phase(angle, h, 60.0), h)  # the speed whose sign the friction takes
    torque = compensated_torque(log.channel("torque"), slow, chain.coulomb[0], chain.offsets[0])
    used = slice(round(3.0 / h), round(8.0 / h))
    found = response_by_segments(torque[used], difference(angle, h)[used], h, (2.5, 0.2))
    kept = (found.frequency >= 1.0) & (found.frequency <= 500.0)
    frequency, response = found.frequency[kept], found.response[kept]
    band = (frequency >= 5.0) & (frequency <= 100.0)
    theory = speed_response(chain, 2 * pi * frequency[band])
    return frequency, response, float(np.median(np.abs(response[band] / theory - 1.0)))


def _response(figure: str, chain: LumpedChain, title: str) -> Outcome:
    frequency, response, off = measured_response(chain)
    theory = ("theory", frequency, np.abs(speed_response(chain, 2 * pi * frequency)))
    curves = ("virtual rig", frequency, np.abs(response)), theory
    axes = "frequency [Hz] | speed per torque [rad/(N m s)]"
    found = {"off": 100 * off, f"figure_{figure.replace('.', '_')}": off < CLOSE}
    return found, [panel(f"Fig. {figure}", title, axes, *curves, log="xy")]


def figure_4_17(quick: bool) -> Outcome:
    """Fig. 4.17: the motor alone."""
    return _response("4.17", bench_rig(MOTOR).chain, "Motor, virtual rig and theory")


def figure_4_19(quick: bool) -> Outcome:
    """Fig. 4.19: motor and drive pulley with the joint of Section 4.3.2."""
    motor, pulley = MOTOR.inertia, BOTH.inertia - MOTOR.inertia
    chain = LumpedChain(
        names=("motor", "drive"),
        inertias=(motor, pulley),
        viscous=(BOTH.viscous, 0.0),
        coulomb=(BOTH.coulomb, 0.0),
        offsets=(BOTH.offset, 0.0),
        stiffness=(JOINT,),
        damping=(JOINT_DAMPING,),
        ratios=((1.0, 1.0),),
    )
    found, panels = _response("4.19", chain, "Motor and drive pulley, virtual rig and theory")
    found |= {"anti": sqrt(JOINT / pulley) / (2 * pi)}
    found["section_4_3_2_joint"] = sqrt(JOINT * (1 / motor + 1 / pulley)) / (2 * pi)
    s, twist = 100j, JOINT_DAMPING * (1 / motor + 1 / pulley)
    linear = JOINT * (1 / motor + 1 / pulley) + BOTH.viscous * JOINT_DAMPING / (motor * pulley)
    printed = s**3 + twist * s**2 + linear * s + BOTH.viscous * JOINT / (motor * pulley)
    printed = (s**2 + JOINT_DAMPING / pulley * s + JOINT / pulley) / motor / printed
    exact = complex(speed_response(chain, np.array([100.0]))[0])
    return found | {"section_4_3_2_second_line": abs(printed / exact - 1.0) < 1e-9}, panels
