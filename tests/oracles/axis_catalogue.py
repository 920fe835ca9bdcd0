"""Logs of one axis whose truth is known: fault x excitation x sampling convention x noise.

Every number is drawn from the seed; the plant is `oracles.axis_plant`, of which the package knows nothing.
"""

from dataclasses import dataclass, field
from math import exp, pi

import numpy as np
from scipy import signal

from oracles.axis_plant import Axis, move, parameters

RATE = 1000.0
DURATION = 40.0
QUIET = {"counts": 10_000, "torque": 0.003, "angle": 0.0}
COARSE = {"counts": 2600, "torque": 0.01, "angle": 0.0}
ANALOG = {"counts": 0, "torque": 0.01, "angle": 1e-4}
NOISES = {"fine": QUIET, "coarse": COARSE, "analog": ANALOG}
"""Encoder counts per turn, noise of the torque over its size, noise of an analog angle [rad]."""
FAULTS = {
    "sound": {},
    "flexible-4": {"resonance": 4.0},
    "flexible-15": {"resonance": 15.0},
    "flexible-40": {"resonance": 40.0},
    "flexible-load-friction": {"resonance": 25.0, "load_share": 0.5},
    "backlash": {"resonance": 92.0, "gap": np.radians(1.0)},
    "bouc-wen": {"resonance": 30.0, "hysteresis": 0.4},
    "stribeck": {"stribeck_excess": 0.6, "stribeck_speed": 1.0},
    "smooth": {"smooth_slope": 0.5},
    "lugre": {"bristle": 3e-3, "stribeck_excess": 0.3, "stribeck_speed": 1.0},
    "cogging": {"cogging": 8e-3, "cogging_count": 12},
    "gravity": {"gravity": 0.6},
    "eccentric": {"eccentricity": 2e-3},
    "coloured": {"disturbance": 1.0},
    "quadratic": {"quadratic": 0.5},
    "asymmetric": {"asymmetry": 0.5},
    "warming": {"coulomb_drift": -0.4},
    "load-dependent": {"load_dependence": 0.15},
    "outliers": {"outliers": 7},
    "clipped-sensor": {"clip": 0.75},
    "ripple": {"ripple": 0.1, "ripple_count": 6},
    "one-sided": {"one_sided": 0.1},
}
LATER = ("bouc-wen", "ripple", "one-sided")
"""Faults that are not in the list of truths, whose places are part of their seeds."""
"""Amounts relative to the axis drawn: shares of its frictions, or SI; under the names that `Axis` has."""

NAMES = {"inertia": "inertia", "coulomb": "coulomb_friction", "viscous": "viscous_friction"}
NAMES |= {"offset": "offset_torque"}


@dataclass(frozen=True)
class Truth:
    """One kind of log."""

    fault: str
    excitation: str
    convention: str
    noise: str

    @property
    def name(self):
        """All four words."""
        return "/".join((self.fault, self.excitation, self.convention, self.noise))


@dataclass(frozen=True)
class Made:
    """One log and what made it.

    ``values``, dict of str to float: what an identification should find.
    """

    time: np.ndarray
    torque: np.ndarray
    angle: np.ndarray
    values: dict[str, float] = field(default_factory=dict)


def _truths():
    """84 of them: sound axes in every convention, each fault under open and closed loops."""
    sound = [
        ("sound", excitation, convention, noise)
        for excitation, conventions in {
            "multisine": ("held", "line", "before", "lag-60"),
            "chirp": ("held", "line", "before", "lag-60"),
            "steps": ("held", "before", "lag-60"),
            "servo": ("held", "before", "lag-60"),
            "servo-periodic": ("held", "before", "lag-60"),
            "servo-smooth": ("held", "late-3"),
            "servo-quiet": ("held", "line-lag-200"),
        }.items()
        for convention, noise in zip(conventions, ("fine", "coarse", "analog", "coarse"), strict=False)
    ]
    sound += [("sound", e, "held", "coarse") for e in ("multisine", "servo", "servo-periodic", "steps")]
    faulty = []
    runs = ("multisine", "servo-periodic", "chirp", "servo", "steps")
    for number, fault in enumerate(name for name in FAULTS if name not in ("sound", *LATER)):
        for k in range(3):
            excitation = runs[(number + 2 * k) % len(runs)]
            noise = ("fine", "coarse", "analog")[(number + k) % 3]
            faulty.append((fault, excitation, "held", noise))
    faulty += [
        ("flexible-4", "multisine", "line", "fine"),
        ("coloured", "multisine", "before", "coarse"),
        ("cogging", "chirp", "lag-60", "fine"),
        ("stribeck", "servo-periodic", "before", "coarse"),
        ("lugre", "servo-smooth", "held", "fine"),
        ("backlash", "servo", "lag-60", "fine"),
    ]
    return tuple(Truth(*entry) for entry in (*sound, *faulty))


TRUTHS = _truths()


def made(truth, seed, duration=DURATION):
    """One log, of a truth of the list or of another.

    ``duration``: [s].
    """
    rng = np.random.default_rng([seed, TRUTHS.index(truth) if truth in TRUTHS else len(TRUTHS)])
    fault, noise = FAULTS[truth.fault], NOISES[truth.noise]
    count = round(duration * RATE)
    inertia = 1e-3 * 2.0 ** rng.uniform(0.0, 2.0)
    coulomb, viscous = 10.0 * inertia * rng.uniform(1.0, 2.0), inertia * rng.uniform(0.5, 2.5)
    offset = 0.2 * coulomb * rng.uniform(-1.0, 1.0)
    numbers = {"inertia": inertia, "coulomb": coulomb, "viscous": viscous, "offset": offset}
    sought = {NAMES[name]: value for name, value in numbers.items()}
    size = rng.uniform(3.0, 5.0) * coulomb
    reference, command = np.zeros((3, count)), np.zeros(count)
    servo = np.zeros(6)
    if truth.excitation.startswith("servo"):
        reference = reference_of(truth.excitation, rng, count)
        omega = 2 * pi * rng.uniform(4.0, 7.0)
        gains = (inertia * omega**2, 1.6 * inertia * omega, 0.0, inertia * rng.choice([0.0, 0.8]))
        servo[:] = [1.0, *gains, 1.0 - exp(-2 * pi * 60.0 / RATE)]
    else:
        command = size * _open_loop(truth.excitation, rng, count)
    plant = parameters(**numbers | _plant_fault(fault, numbers, rng))
    extra = np.zeros(count)
    if "disturbance" in fault:
        extra = fault["disturbance"] * coulomb * _coloured(rng, count)
    sensor = np.zeros(4)
    if noise["counts"]:
        sensor[:2] = 2 * pi / noise["counts"], rng.uniform()
    sensor[2:] = fault.get("eccentricity", 0.0), rng.uniform(0.0, 2 * pi)
    angle, torque = np.empty(count), np.empty(count)
    line = int(truth.convention.startswith("line") and servo[0] == 0.0)
    fine = 40 if "bristle" in fault else (10 if "resonance" in fault else 4)
    move(plant, command, extra, reference, servo, sensor, 1.0 / RATE, fine, line, angle, torque)
    seen = angle + sensor[2] * np.sin(angle + sensor[3]) + noise["angle"] * rng.normal(size=count)
    if sensor[0] > 0.0:
        seen = sensor[0] * np.floor(seen / sensor[0] + sensor[1])
    logged = _logged(torque, truth.convention)
    logged = logged + noise["torque"] * np.std(torque) * rng.normal(size=count)
    if "outliers" in fault:
        logged[rng.integers(0, count, fault["outliers"])] = 99.0
    if "clip" in fault:
        most = fault["clip"] * np.abs(logged).max()
        logged = np.clip(logged, -most, most)
    return Made(np.arange(count) / RATE, logged, seen, sought)


def _plant_fault(fault, numbers, rng):
    """Numbers of the plant that a fault changes."""
    c, viscous = numbers["coulomb"], numbers["viscous"]
    size = {"stribeck_excess": c, "gravity": c, "quadratic": viscous / 10.0, "asymmetry": viscous}
    made = {name: amount * size.get(name, 1.0) for name, amount in fault.items() if name in Axis._fields}
    if "resonance" in fault:
        total, share = numbers["inertia"], rng.uniform(0.3, 0.5)
        motor, load = (1.0 - share) * total, share * total
        omega = 2 * pi * fault["resonance"]
        stiffness = omega**2 * motor * load / total
        made |= {"inertia": motor, "load_inertia": load, "stiffness": stiffness}
        made |= {"damping": 0.04 * stiffness / omega}
        if "hysteresis" in fault:  # of that frequency and that share on average, which both are drawn
            stiffness *= rng.uniform(0.5, 2.0) ** 2
            made |= {"stiffness": stiffness, "hysteresis": fault["hysteresis"] * rng.uniform(0.5, 1.5)}
            made |= {"hysteresis_size": c / stiffness * rng.uniform(0.5, 3.0)}
        if "load_share" in fault:
            made |= {"coulomb": (1.0 - fault["load_share"]) * c, "load_coulomb": fault["load_share"] * c}
    for name in ("cogging", "ripple"):
        if name in fault:
            made |= {f"{name}_phase": rng.uniform(0.0, 2 * pi)}
    return made


def _logged(torque, convention):
    """The torque as a drive of a convention writes it down."""
    if convention == "before":
        return np.concatenate([torque[:1], torque[:-1]])
    if convention.startswith("smoothed"):  # by a filter of the second order, as digital drives have it
        sections = signal.butter(2, float(convention.rpartition("-")[2]), fs=RATE, output="sos")
        return (signal.sosfiltfilt if "both-ways" in convention else signal.sosfilt)(sections, torque)
    if convention == "late-3":
        return np.concatenate([np.full(3, torque[0]), torque[:-3]])
    if "lag" in convention:
        pole, out, state = exp(-2 * pi * float(convention.rpartition("-")[2]) / RATE), torque.copy(), 0.0
        for k in range(torque.size):
            out[k] = state
            state = pole * state + (1.0 - pole) * torque[k]
        return out
    return torque


def _open_loop(kind, rng, count):
    """A command of size 1 (root mean square, about)."""
    t = np.arange(count) / RATE
    if kind == "multisine":
        period = 10.0
        lines = np.arange(5, 146) / period
        chosen = rng.choice(lines, 28, replace=False)
        phases = rng.uniform(0.0, 2 * pi, chosen.size)
        weights = np.minimum(1.0, chosen / 2.0)
        waves = (weights[:, None] * np.sin(2 * pi * chosen[:, None] * t + phases[:, None])).sum(axis=0)
        return waves / np.std(waves)
    if kind == "chirp":
        low, high = rng.uniform(0.4, 0.6), 30.0
        rate = (high - low) / t[-1]
        return 1.4 * np.sin(2 * pi * (low * t + 0.5 * rate * t**2))
    parts, side = [], 1.0
    while sum(len(part) for part in parts) < count:
        parts.append(np.full(int(RATE * rng.uniform(0.1, 0.6)), side * rng.uniform(0.5, 1.5)))
        side = -side
    return np.concatenate(parts)[:count]


def reference_of(kind, rng, count):
    """Angle, speed, acceleration of a reference."""
    speed = np.zeros(count)
    start, here = int(0.2 * RATE), 0.0
    if kind == "servo-periodic":
        top, rise, rest = rng.uniform(6.0, 12.0), rng.uniform(100.0, 150.0), rng.uniform(0.1, 0.25)
        one = np.concatenate([speed_of_move(rng.uniform(2.0, 4.0), top, rise), np.zeros(int(rest * RATE))])
        period = np.concatenate([one, -one])
        speed = np.resize(period, count)
    else:
        while start < count:
            there = rng.uniform(-3.0, 3.0)
            if abs(there - here) < 0.3:
                continue
            top, rise = rng.uniform(4.0, 14.0), rng.uniform(60.0, 150.0)
            if kind == "servo-quiet":
                top, rise = 0.6 * top, 0.4 * rise
            part = np.sign(there - here) * speed_of_move(abs(there - here), top, rise)
            if kind == "servo-smooth":
                duration = max(0.1, np.sqrt(abs(there - here) * 7.5 / rise))
                s = np.arange(0, 1, 1 / (duration * RATE))
                part = (there - here) / duration * 140 * s**3 * (1 - s) ** 3
            end = min(count, start + part.size)
            speed[start:end] = part[: end - start]
            start, here = end + int(RATE * rng.uniform(0.05, 0.3)), there
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) / RATE])
    return np.array([angle, speed, np.gradient(speed, 1.0 / RATE)])


def speed_of_move(way, top, rise):
    """A trapezium of speed over a way, at most so fast and so steep."""
    peak = min(top, np.sqrt(rise * way))
    up, flat = peak / rise, way / peak - peak / rise
    t = np.arange(0.0, 2 * up + flat, 1.0 / RATE)
    return np.interp(t, [0.0, up, up + flat, 2 * up + flat], [0.0, peak, peak, 0.0])


def _coloured(rng, count):
    """Noise of a first-order low-pass at 2 to 8 Hz, deviation 1."""
    pole = exp(-2 * pi * rng.uniform(2.0, 8.0) / RATE)
    white = np.sqrt(1.0 - pole**2) * rng.normal(size=count)
    out, state = np.empty(count), 0.0
    for k in range(count):
        state = pole * state + white[k]
        out[k] = state
    return out
