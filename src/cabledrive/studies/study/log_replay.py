r"""The identified model replayed over its own log: does the log do what the model does, beyond chance?

A Kalman filter of the identified drive runs over the log, torque in, angles of all encoders in; its
innovations are what the past does not predict. The same filter runs over logs of the identified model itself,
under the same torque, with the same encoders at random phases: what is left there is chance. Powers of the
innovations are compared in octaves; a power is that of a chi-squared variable with two degrees of freedom
for each independent frequency. Nothing is assumed of what is wrong: cogging, an eccentric encoder, an inertia
or a spring that the model lacks.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import floor, pi

import numpy as np
from scipy import signal, stats

from cabledrive.control.numbers import ObserverNumbers
from cabledrive.control.observers import KalmanTuning, Sampling, correct, kalman_filter, predict
from cabledrive.identification.logs.log import Log
from cabledrive.identification.signals import zero_phase
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.parameters import Drive, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.friction_integration import integrate_chain
from cabledrive.reduction.lumped_chain import highest_model
from cabledrive.rig.laws.controllers import joint_backlash, load_gear, place, plant_chain

ENCODERS = {
    "angle": "motor_encoder",
    "motor_angle": "motor_encoder",
    "drive_angle": "drive_encoder",
    "load_angle": "load_encoder",
}
COARSER = 1.2
"""Step of a log over that of the file from which the two contradict."""
FEWEST_LEVELS = 8
"""Readings that differ, below which their common step may be a multiple of a count."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LogFinding:
    """What a log says against the drive file."""

    id: str  # A quantity of the study, an encoder's key, "delay", "replay" or "identification"
    words: str
    # value, limit: what was found, and what is allowed; None: said in words alone
    value: float | None = None
    limit: float | None = None
    unit: str = ""
    decides: bool = True  # whether the verdict rests on it

    def __str__(self) -> str:
        return self.words


def coarser_encoders(drive: Drive, logs: Sequence[Log]) -> dict[str, int]:
    """Counts per revolution of encoders that the logs show coarser than the drive file has them, by key."""
    found: dict[str, int] = {}
    for log in logs:
        for channel, key in ENCODERS.items():
            counts = None if drive.sensors is None else getattr(drive.sensors, key)
            step = log.report.quantum.get(channel, 0.0)
            if not counts or not step or channel not in log.channels:
                continue
            if np.unique(log.channel(channel)).size < FEWEST_LEVELS:
                continue
            seen = floor(2.0 * pi / step + 0.5)
            if seen < counts:
                found[key] = max(min(seen, found.get(key, seen)), 1)
    return found


def encoder_findings(drive: Drive, coarser: Mapping[str, int]) -> tuple[LogFinding, ...]:
    """Encoders of a log that are no longer those of the drive file."""
    return tuple(
        LogFinding(
            id=key,
            value=2.0 * pi / counts,
            limit=COARSER * 2.0 * pi / named,
            unit="rad",
            words=f"the {key.replace('_', ' ')} of the log has {counts} counts per revolution, "
            f"sensors.{key} of the drive file {named}; the coarser one is used",
        )
        for key, counts in coarser.items()
        if (named := getattr(drive.sensors, key)) > COARSER * counts
    )


CHANNELS = {"angle": "motor", "drive_angle": "drive", "load_angle": "load"}
REPEATS = 4
"""Logs of the model itself."""
CHANCE = 1e-4
"""Probability that a log of the model itself exceeds its limit in some octave of some encoder."""
TOLERANCE = 1.5
"""Power over that of the model that numbers within their intervals may make at least."""
LOWEST = 1.0
"""Lower end of the first octave [Hz]."""
DIVERGED = 1e9
"""Stands for the ratio of a model that runs away under the log's torque."""
TUNING = KalmanTuning(disturbance=1e-4, offsets=())


@dataclass(frozen=True, slots=True, kw_only=True)
class Replay:
    """Innovations of a log beside those of the identified model."""

    ratio: float  # largest power over that of the model, among octaves and encoders
    limit: float  # of that octave, what chance and the numbers' intervals allow
    encoder: str
    frequency: float  # middle of the octave [Hz]

    @property
    def contradicts(self) -> bool:
        """Whether the log does what the model does not."""
        return self.ratio > self.limit

    @property
    def words(self) -> str:
        """The replay in a sentence."""
        name = self.encoder.replace("_", " ")
        return (
            f"in a replay of the log, the identified model leaves {self.ratio:.3g} times the power in the "
            f"{name} near {self.frequency:.3g} Hz that it leaves over its own logs; chance and the intervals "
            f"allow {self.limit:.3g} times"
        )


def replay(log: Log, drive: Drive, seed: int = 0, likely: Sequence[Drive] = ()) -> Replay:
    """The octave and encoder of a whole drive's log whose replay is farthest over its limit."""
    generator = np.random.default_rng(seed)
    channels = [name for name in CHANNELS if name in log.channels]
    gears = np.array([load_gear(drive) if name == "load_angle" else 1.0 for name in channels])
    counts = []  # at the first shaft [rad], by the log where it shows one, else by the file
    for name, gear in zip(channels, gears.tolist(), strict=True):
        number = getattr(drive.sensors, f"{CHANNELS[name]}_encoder") if drive.sensors else None
        counts.append((float(log.report.quantum.get(name) or 0.0) or 2.0 * np.pi / (number or 1e5)) * gear)
    chain, h = plant_chain(drive, highest_model(drive)), log.interval
    torque = log.channel("torque")
    places = [place(chain, CHANNELS[name]) for name in channels]
    probe = kalman_filter(
        chain,
        list(zip(places, counts, strict=True)),
        Sampling(interval=h),
        chosen=range(chain.size),
        tuning=TUNING,
        settled=True,
    )
    measured = np.column_stack([log.channel(name) for name in channels]) * gears
    middle, lines, seen = octaves(innovations(probe, torque, measured - measured[0]), h)
    # Of white noise, by the upper half of the spectrum; that none of it acts on the shaft forgives most.
    noise = np.sqrt(2.0) * np.std(torque - zero_phase(torque, h, 0.25 / h))

    def left(moved: Array) -> Array:
        """Power that the model leaves of a log of these angles."""
        angles = moved[:, [place(chain, CHANNELS[name]) for name in channels]]
        read = np.array(counts) * np.floor(angles / counts + generator.uniform(size=len(channels)))
        logged = torque + noise * generator.standard_normal(torque.size)
        return octaves(innovations(probe, logged, read - read[0]), h)[2]

    own = _moved(drive, torque, h)
    if own is None:
        return Replay(ratio=DIVERGED, limit=1.0, encoder=channels[0], frequency=0.0)
    model = np.mean([left(own) for _ in range(REPEATS)], axis=0)
    drawn = [left(moved) for machine in likely if (moved := _moved(machine, torque, h)) is not None]
    excess = np.max([model, *drawn], axis=0) / model - 1.0
    ratio = seen / model
    chance = stats.f.isf(CHANCE / ratio.size, 2.0 * lines, 2.0 * REPEATS * lines)
    limit = np.maximum(TOLERANCE, 1.0 + excess) * chance[:, None]
    k, j = np.unravel_index(int(np.argmax(ratio / limit)), ratio.shape)
    return Replay(
        ratio=float(ratio[k, j]),
        limit=float(limit[k, j]),
        encoder=channels[int(j)],
        frequency=float(middle[k]),
    )


def _moved(drive: Drive, torque: Array, interval: float) -> Array | None:
    """Angles of a machine under a torque, shape (samples, inertias); None where it runs away."""
    chain = plant_chain(drive, highest_model(drive))
    gaps = (joint_backlash(drive, chain), *(0.0,) * (chain.size - 2))
    try:
        return integrate_chain(chain, torque, interval, gaps=gaps, substeps=4, hold="line").angles
    except NotComputed:
        return None


def octaves(values: Array, interval: float) -> tuple[Array, Array, Array]:
    """Middles [Hz], independent frequencies and powers, (k, m), of values, (samples, m), in octaves."""
    n = len(values)
    spectrum = np.abs(np.fft.rfft(values * signal.windows.hann(n)[:, None], axis=0)) ** 2
    frequency = np.fft.rfftfreq(n, interval)
    edges = LOWEST * 2.0 ** np.arange(0, 40)
    edges = edges[edges <= 0.25 / interval]
    bands = [(frequency >= low) & (frequency < high) for low, high in pairwise(edges)]
    lines = np.array([band.sum() / 1.5 for band in bands])  # Hann's window ties neighbours together
    return np.sqrt(edges[1:] * edges[:-1]), lines, np.array([spectrum[band].sum(axis=0) for band in bands])


def innovations(probe: ObserverNumbers, torque: Array, readings: Array) -> Array:
    """Readings, shape (samples, m) [rad], less their predictions, settled part."""
    out, states = np.zeros(readings.shape), probe.model.shape[0]
    mean = np.append(0.5 * (torque[1:] + torque[:-1]), torque[-1])
    probe = probe._replace(gains=np.ascontiguousarray(probe.gains))
    memory = np.zeros((4, max(states, readings.shape[1], len(probe.chosen))))
    predict_along(probe, mean, np.ascontiguousarray(readings), memory, out)
    return out[len(out) // 10 :]


@njit_in_place
def predict_along(probe: ObserverNumbers, torque: Array, readings: Array, memory: Array, out: Array) -> None:
    """The Kalman filter along a log; ``memory``, shape (4, states or more), is zero at the start."""
    output, held, commands = probe.output, memory[3, :1], memory[3, 1:3]
    estimate, fresh, taken = memory[0, : output.shape[1]], memory[1], memory[2, : probe.chosen.size]
    for k in range(readings.shape[0]):
        for j in range(readings.shape[1]):
            predicted = 0.0
            for i in range(estimate.size):
                predicted += output[j, i] * estimate[i]
            out[k, j] = readings[k, j] - predicted
        correct(probe, float(k), estimate, readings[k], taken, fresh)
        commands[0] = commands[1] = torque[k]
        predict(probe, 0.0, estimate, held, commands, fresh)
