"""A virtual experiment: excitation by a file, a log like a laboratory's, and what it would identify."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.identification import planning
from cabledrive.identification.logs.log import Log
from cabledrive.identification.response_models import PARAMETERS
from cabledrive.identification.signals import difference, zero_phase
from cabledrive.parameters import Drive, InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import require_known
from cabledrive.parameters.toml_values import flag_of, quantities_of, quantity_of, read_toml, whole_of
from cabledrive.reduction.network_axis import as_axis
from cabledrive.rig.setting import random_from, sample_interval
from cabledrive.rig.virtual_rig import VirtualRig, load_cell_force, rig_of, run_rig

CHANNEL = "load_cell_force"
SPEED_BANDWIDTH = 40.0
"""Of the rim speed, whose square takes off some of the pull [Hz]."""


def with_load_cell(log: Log, drive: Drive, rng: np.random.Generator) -> Log:
    """A log with the channel "load_cell_force", where the drive has a load cell; a chain has no spans.

    What the load pulley adds to one span it takes from the other; a log without the load's angle has no speed
    of the rim.
    """
    noise = None if drive.sensors is None else drive.sensors.load_cell_noise
    if noise is None or not drive.closed or drive.chain_of:
        return log
    pull, speed = np.full(len(log), 2.0 * drive.cable.pretension), np.zeros(len(log))
    if "load_angle" in log.channels:
        bandwidth = min(SPEED_BANDWIDTH, 0.2 * log.sample_rate)
        speed = difference(zero_phase(log.channel("load_angle"), log.interval, bandwidth), log.interval)
    read = load_cell_force(drive, pull, drive.load_pulley.radius * speed, rng)
    return replace(log, channels={**log.channels, CHANNEL: read}, units={**log.units, CHANNEL: "N"})


MULTISINES = ("multisine", "idinput")
KINDS = ("sines", *MULTISINES, "chirp", "steps")


@dataclass(frozen=True, slots=True, kw_only=True)
class Excitation:
    """The command of an experiment."""

    kind: str = "sines"  # one of `KINDS`
    duration: float = 70.0  # [s]
    # frequencies, amplitudes: of "sines" [Hz], [V]
    frequencies: tuple[float, ...] = (1.0, 3.0, 5.0)
    amplitudes: tuple[float, ...] = (0.1, 0.1, 0.1)
    amplitude: float = 0.35  # largest value of the others [V]
    # constant part [V]; keeps the shaft turning one way, so that Coulomb friction is constant
    bias: float = 0.0
    band: tuple[float, float] = (1.0, 250.0)  # of multisines and chirp [Hz]
    lines: int | None = None  # number of sines in the band; None: all
    period: float = 2.0  # of multisines and steps [s]
    odd: bool = True  # odd lines only
    trials: int = 10  # draws of "idinput"

    def __post_init__(self) -> None:
        require_known(self.kind, KINDS, f'excitation "{self.kind}" is unknown')
        if not 0.0 < self.duration <= 3600.0:
            raise InputRefused(
                f"duration = {self.duration:.4g} s must lie above 0 and below 3600 s: shorten it"
            )
        if len(self.frequencies) != len(self.amplitudes):
            counts = f"{len(self.frequencies)} frequencies and {len(self.amplitudes)} amplitudes"
            raise InputRefused(f"{counts}: give as many of one as of the other")
        if not self.frequencies:
            raise InputRefused("frequencies holds none: give at least one, or another kind")
        if len(self.band) != 2:
            raise InputRefused(f"band holds {len(self.band)} frequencies: give the lowest and the highest")
        if not self.period > 0.0:
            raise InputRefused(f"period = {self.period:.4g} s must be above 0: lengthen it")


MOST_LOG_MEMORY, BYTES_PER_ROW = 8e9, 350.0
"""Of the log of an experiment while it is written, an hour at 5 kHz and a little more [bytes]."""
MOST_TRIED_SAMPLES = 1e10
"""Of all draws of a random multisine together: about a quarter of an hour of one core."""


def check_excitation(drive: Drive, excitation: Excitation) -> None:
    """Refuse an experiment whose log does not fit into memory, or whose command its samples cannot carry."""
    e, rate = excitation, 1.0 / sample_interval(drive)
    size = BYTES_PER_ROW * e.duration * rate
    if size > MOST_LOG_MEMORY:
        raise InputRefused(
            f"duration = {e.duration:.4g} s at {rate:.6g} Hz takes {size / 1e9:.3g} GB: at most "
            f"{MOST_LOG_MEMORY / 1e9:.0f} GB are used, {e.duration * MOST_LOG_MEMORY / size:.4g} s: shorten "
            "it, or lower sensors.sample_rate"
        )
    used = {"sines": ("frequencies", e.frequencies), "chirp": ("band", e.band)}.get(e.kind)
    if used is not None and not all(0.0 < f < 0.5 * rate for f in used[1]):
        wrong = next(f for f in used[1] if not 0.0 < f < 0.5 * rate)
        raise InputRefused(
            f"{used[0]}: {wrong:.6g} Hz must lie above 0 and below {0.5 * rate:.6g} Hz, half the sample rate"
        )
    if e.kind == "chirp" and e.band[0] == e.band[1]:
        raise InputRefused(
            f"band: both ends are {e.band[0]:.6g} Hz: give two frequencies, or one of kind sines"
        )
    samples, most = e.period * rate, MOST_LOG_MEMORY / BYTES_PER_ROW
    if e.kind == "steps" and samples < 2.0:
        raise InputRefused(f"period = {e.period:.4g} s holds {samples:.2g} samples: lengthen it to 2 or more")
    if e.kind in MULTISINES and samples > most:
        raise InputRefused(
            f"period = {e.period:.4g} s is above {most / rate:.4g} s at {rate:.6g} Hz: shorten it"
        )
    if e.kind == "idinput" and e.trials * samples > MOST_TRIED_SAMPLES:
        raise InputRefused(
            f"trials = {e.trials} are more than the {int(MOST_TRIED_SAMPLES / samples)} that this period "
            "allows: lower them"
        )


def load_excitation(path: str | Path) -> Excitation:
    """Read an excitation from a TOML file."""
    return read_toml(path, "write TOML", excitation_of)


def excitation_of(table: Mapping[str, Any]) -> Excitation:
    """An excitation from a table of TOML."""
    units = {"duration": "s", "period": "s", "amplitude": "V", "bias": "V"}
    lists = {"frequencies": "Hz", "amplitudes": "V", "band": "Hz"}
    keys = [field.name for field in fields(Excitation)]
    found: dict[str, Any] = {}
    for key, value in table.items():
        require_known(key, keys, f"{key}: unknown key")
        if key in units:
            found[key] = quantity_of(key, value, units[key])
        elif key in lists:
            found[key] = quantities_of(key, value, lists[key])
        elif key in ("lines", "trials"):
            found[key] = whole_of(key, value)
        else:
            found[key] = flag_of(key, value) if key == "odd" else str(value)
    return Excitation(**found)


def command_of(excitation: Excitation, sample_rate: float, rng: np.random.Generator) -> Array:
    """The command, sample by sample, shape (samples,) [V]; ``sample_rate`` [Hz]."""
    e, samples = excitation, round(excitation.duration * sample_rate)
    if e.kind == "sines":
        phases = rng.uniform(0.0, 2 * np.pi, len(e.frequencies))
        return e.bias + planning.sum_of_sines(e.duration, sample_rate, e.frequencies, e.amplitudes, phases)
    if e.kind == "chirp":
        return e.bias + e.amplitude * planning.chirp(e.duration, sample_rate, *e.band)
    if e.kind == "steps":
        return e.bias + e.amplitude * planning.steps(e.duration, sample_rate, e.period)
    period = round(e.period * sample_rate)
    if period < 3:
        raise InputRefused(f"period = {e.period:.4g} s holds {period} samples: lengthen it")
    lines = planning.multisine_lines(period, sample_rate, *e.band, count=e.lines, odd=e.odd)
    if e.kind == "idinput":
        wave = planning.random_multisine(period, lines, e.trials, rng)
    else:
        wave = planning.low_crest_multisine(period, lines)
    return e.bias + e.amplitude * np.tile(wave, -(-samples // period))[:samples]


def experiment(
    drive: Machine | Drive,
    excitation: Excitation | None = None,
    *,
    model: int | None = None,
    seed: int = 0,
) -> Log:
    """Run a virtual experiment on a drive and return its log.

    Parameters
    ----------
    drive : Machine or Drive
        A machine whose axis is a chain, or the drive of that axis.
    excitation : Excitation, optional
        Default: 1, 3 and 5 Hz of 0.1 V for 70 s, as in section 4.2.
    model : {1, 2, 3, 4}, optional
        Model of the plant; default: the highest that the drive's data allow.
    seed : int, default 0
        Of phases, noise and encoder phases.

    Returns
    -------
    Log
    """
    drive, excitation = as_axis(drive), excitation or Excitation()
    check_excitation(drive, excitation)
    rng = random_from(seed)
    rig = rig_of(drive, model)
    command = command_of(excitation, rig.sample_rate, rng)
    log = run_rig(rig, command, rng, source=f"virtual rig of {drive.name}")
    return with_load_cell(log, drive, rng)


def plan_experiment(
    drive: Machine | Drive,
    excitation: Excitation | None = None,
    *,
    model: int | None = None,
    stroke: float | None = None,
    seed: int = 0,
) -> dict[str, Any]:
    """Predict standard errors, peaks and warnings of an experiment; ``stroke``: largest travel [rad].

    Errors are relative; "amplitude_factor": by which the torque reaches the first limit, None without limits.
    """
    drive, excitation = as_axis(drive), excitation or Excitation()
    check_excitation(drive, excitation)
    rig = rig_of(drive, model)
    command = command_of(excitation, rig.sample_rate, random_from(seed))
    torque = rig.torque_per_volt * command
    if "angle" not in rig.encoders:  # of which alone the errors are predicted
        raise InputRefused("sensors.motor_encoder is missing, a plan counts on it: add it, such as 2600")
    quantum, interval, motor = 2 * pi / rig.encoders["angle"], 1.0 / rig.sample_rate, drive.motor
    instruments = planning.Instruments(torque_noise=rig.imperfections.torque_noise, quantum=quantum)
    known = {"torque": motor.torque_limit, "speed": motor.speed_limit} if motor is not None else {}
    limits = {name: float(one) for name, one in {**known, "stroke": stroke}.items() if one is not None}
    chain, reach = rig.chain, np.cumprod([1.0, *(first / second for first, second in rig.chain.ratios)])
    guess = planning.AxisGuess(  # the lumped chain as one, seen from the motor
        inertia=float(reach**2 @ chain.inertias),
        viscous=float(reach**2 @ chain.viscous),
        coulomb=float(np.abs(reach) @ chain.coulomb),
        offset=chain.offsets[0],
    )
    plan = planning.plan_test(torque, interval, guess, instruments, limits)
    errors: dict[str, float | None] = dict(plan.relative_errors)
    warnings = [*plan.findings, *planning.resonance_warnings(drive, torque, rig.sample_rate)]
    if rig.chain.size > 1:
        errors, words = _of_response(drive, rig, excitation, torque, instruments)
        warnings = [w for w in warnings if planning.WEAK not in w] + words
    return {
        "relative_standard_error": {
            k: v if v is not None and np.isfinite(v) else None for k, v in errors.items()
        },
        "peaks": plan.peaks,
        "moving": plan.moving,
        "amplitude_factor": planning.largest_amplitude(torque, interval, guess, limits) if limits else None,
        "warnings": warnings,
    }


def _of_response(
    drive: Drive,
    rig: VirtualRig,
    excitation: Excitation,
    torque: np.ndarray,
    instruments: planning.Instruments,
) -> tuple[dict[str, float | None], list[str]]:
    """Errors of stiffnesses and dampings from the response to a multisine; none from other excitations."""
    if rig.chain.names != ("motor", "drive", "load") or excitation.kind not in MULTISINES:
        return {}, ["errors of a flexible drive are predicted for Model 4 and multisines only"]
    radius, lumped = drive.drive_pulley.radius, rig.chain
    joint, cable = (first * second for first, second in lumped.ratios)
    values = {
        "motor_inertia": lumped.inertias[0],
        "drive_inertia": lumped.inertias[1],
        "load_inertia": lumped.inertias[2],
        "viscous_friction": max(lumped.viscous[0], 1e-9),
        "joint_stiffness": joint * lumped.stiffness[0],
        "joint_damping": joint * lumped.damping[0],
        "cable_stiffness": cable * lumped.stiffness[1] / (2 * radius**2),
        "cable_damping": cable * lumped.damping[1] / (2 * radius),
    }
    if min(values[name] for name in PARAMETERS[4]) <= 0.0:
        return {}, ["errors are not predicted: a stiffness or damping of the guess is zero"]
    period = round(excitation.period * rig.sample_rate)
    spectrum = 2 * np.abs(np.fft.rfft(torque[:period])) / period
    lines = np.flatnonzero(spectrum[1:] > 0.1 * spectrum[1:].max()) + 1
    shown = lines * rig.sample_rate / period, spectrum[lines]
    samples = rig.sample_rate * max(excitation.duration - excitation.period, excitation.period)
    try:
        errors = planning.predicted_response_errors(values, radius, shown, samples, instruments)
    except InputRefused as refusal:
        return {}, [str(refusal)]
    return dict(errors), []
