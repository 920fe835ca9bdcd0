"""Plants that share no code with the package's: a drive with one thing that its data sheet lacks.

Three inertias (motor, drive pulley, load; a rigid joint is a stiff one without its pulley), integrated by
semi-implicit Euler steps of 20 microseconds. Coulomb friction is set-valued: what a step would turn over, it
stops. Only the sampled law under test is the package's own.
"""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from cabledrive.mechanics.compiled import njit_strict
from cabledrive.rig.closed_loop.chain_kernels import decide
from cabledrive.rig.closed_loop.loop import loop_at_rest

STEP = 20e-6
"""Longest step [s]; a sample holds a whole number of steps."""
NAMES = (
    "j1", "j2", "j3", "b1", "b3", "c1", "c3", "d1", "km", "bm", "kc", "bc", "gap", "stribeck",
    "stribeck_speed", "cogging", "cogging_lines", "ripple", "ripple_lines", "eccentric", "delay", "current",
    "gear", "hardening", "creep", "holds",
)  # fmt: skip
PLACE = {name: k for k, name in enumerate(NAMES)}


@dataclass(frozen=True)
class Truth:
    """The numbers of a plant, at the first shaft, SI."""

    values: np.ndarray
    interval: float
    counts: tuple[float, float, float]

    def __getitem__(self, name):
        return float(self.values[PLACE[name]])

    def but(self, **changes):
        values = self.values.copy()
        for name, value in changes.items():
            values[PLACE[name]] = value
        return replace(self, values=values)


def truth_of(drive):
    """The machine that a data sheet describes, from its plain numbers."""
    first, second, motor, sensors = *drive.pulley, drive.motor, drive.sensors
    gear = second.radius / first.radius
    own = drive.cable.youngs_modulus * drive.cable.area / drive.layout.span_length
    lumped = drive.lumped
    stiffness = lumped.cable_stiffness if lumped and lumped.cable_stiffness else own
    damping = drive.cable.axial_damping / drive.layout.span_length
    if lumped and lumped.cable_damping is not None:
        damping = lumped.cable_damping / first.radius
    values = dict.fromkeys(NAMES, 0.0) | {
        "j1": motor.inertia,
        "j2": first.inertia,
        "j3": second.inertia / gear**2,
        "b1": motor.viscous_friction,
        "c1": motor.coulomb_friction,
        "d1": motor.offset_torque,
        "km": motor.joint_stiffness or 0.0,
        "bm": motor.joint_damping or 0.0,
        "kc": 2.0 * stiffness * first.radius**2,
        "bc": 2.0 * damping * first.radius**2,
        "stribeck_speed": 0.3,
        "current": 2.0 * pi * (motor.current_bandwidth or 0.0),
        "gear": gear,
    }
    counts = tuple(
        0.0 if number is None else 2.0 * pi / number * scale
        for number, scale in (
            (sensors.motor_encoder, 1.0),
            (sensors.drive_encoder, 1.0),
            (sensors.load_encoder, gear),
        )
    )
    return Truth(np.array([values[name] for name in NAMES]), 1.0 / sensors.sample_rate, counts)


@njit_strict
def rubbed(speed, impulse):
    """A speed after a friction that may stop it and never turns it."""
    if speed > 0.0:
        return max(speed - impulse, 0.0)
    return min(speed + impulse, 0.0)


@njit_strict
def one_step(p, x, torque, h):
    """Angles and speeds of three inertias after a step; x = [q1, q2, q3, v1, v2, v3, shaft torque, slip]."""
    j1, j2, j3, b1, b3, c1, c3, d1, km, bm, kc, bc, gap, excess, fade = p[:15]
    if p[21] > 0.0:
        x[6] += h * p[21] * (torque - x[6])
    else:
        x[6] = torque
    drive = x[6] * (1.0 + p[17] * np.sin(p[18] * x[0])) + p[15] * np.sin(p[16] * x[0] + 0.7) + d1
    if km > 0.0:
        twist, rate = x[0] - x[1], x[3] - x[4]
        joint = 0.0
        if twist > 0.5 * gap:
            joint = max(km * (twist - 0.5 * gap) + bm * rate, 0.0)
        elif twist < -0.5 * gap:
            joint = min(km * (twist + 0.5 * gap) + bm * rate, 0.0)
        if gap == 0.0:
            joint = km * twist + bm * rate
    else:
        joint = 0.0
    near = 1 if km > 0.0 else 0
    stretch, slipped = x[near] - x[7] - x[2], x[7]
    if 0.0 < p[25] < kc * abs(stretch):  # the wrap holds no more
        x[7] += stretch - np.sign(stretch) * p[25] / kc
        stretch = np.sign(stretch) * p[25] / kc
    x[7] += h * p[24] * kc * stretch * abs(x[3 + near])
    rate = x[3 + near] - x[5] - (x[7] - slipped) / h
    cable = kc * stretch * (1.0 + p[23] * stretch * stretch) + bc * rate
    friction = c1 + excess * np.exp(-abs(x[3]) / fade)
    mass = j1 if km > 0.0 else j1 + j2
    load = joint if km > 0.0 else cable
    x[3] = rubbed(x[3] + h * (drive - load - b1 * x[3]) / mass, h * friction / mass)
    if km > 0.0:
        x[4] += h * (joint - cable) / j2
    else:
        x[4] = x[3]
    x[5] = rubbed(x[5] + h * (cable - b3 * x[5]) / j3, h * c3 / j3)
    for i in range(3):
        x[i] += h * x[3 + i]
    if km == 0.0:
        x[1] = x[0]


@njit_strict
def shaken(p, torque, interval, step):
    """Angles and speeds of the three inertias under a torque that is held from sample to sample."""
    x, out = np.zeros(8), np.zeros((torque.size, 6))
    steps = int(np.ceil(interval / step - 1e-9))
    h = interval / steps
    for k in range(torque.size):
        out[k] = x[:6]
        for _ in range(steps):
            one_step(p, x, torque[k], h)
    return out


@njit_strict
def followed(p, control, s, shown, step):
    """Largest error of the load under the law, at the first shaft; a runaway counts as 1e3."""
    x, seen, rig, target = np.zeros(8), s.work, control.rig, control.target
    steps = int(np.ceil(rig.interval / step - 1e-9))
    h = rig.interval / steps
    late = round(p[20] / h)
    before, worst = 0.0, 0.0
    for k in range(target.size):
        error = abs(x[2] - target[k])
        worst = max(worst, error)
        if not error < 1e3:
            return 1e3
        for i in range(shown.size):
            seen[i] = x[shown[i]]
        seen[shown.size - 1] += p[19] * np.sin(x[2] + 0.4)
        _, command, _ = decide(None, control, k, s)
        for i in range(steps):
            one_step(p, x, before if i < late else command, h)
        before = command
    return worst


def errors(truth, loop, runs, seed):
    """Largest error of the load in each run, encoders at random phases [rad at the load]."""
    found = np.zeros(runs)
    shown = np.array([0, 1, 2] if loop.chain.size == 3 else [0, 2])
    generator = np.random.default_rng(seed)
    for k in range(runs):
        rig = loop.rig._replace(phases=generator.uniform(-0.5, 0.5, len(loop.rig.phases)))
        control = loop.control._replace(rig=rig)
        worst = followed(truth.values, control, loop_at_rest(loop), shown, STEP)
        found[k] = worst / loop.gear
    return found


def shaken_log(truth, seconds, amplitude, seed):
    """Torque as logged and angles as read, at the first shaft, under a multisine at 1 kHz."""
    generator, interval = np.random.default_rng(seed), 1e-3
    time = interval * np.arange(round(seconds / interval))
    lines = np.arange(0.25, 10.0, 0.25)
    phases = generator.uniform(0.0, 2.0 * pi, len(lines))
    wave = np.sin(2.0 * pi * np.outer(time, lines) + phases).sum(axis=1)
    torque = amplitude * wave / np.abs(wave).max() + generator.normal(0.0, 0.005, time.size)
    angles = shaken(truth.values, torque, interval, STEP)[:, :3]
    angles[:, 2] += truth["eccentric"] * np.sin(angles[:, 2] + 0.4)
    logged = torque + generator.normal(0.0, 0.006, time.size)
    read = [
        count * np.floor(column / count + generator.uniform()) if count > 0.0 else column
        for count, column in zip(truth.counts, angles.T, strict=True)
    ]
    return logged, read


def log_text(truth, seconds, amplitude, seed):
    """The same log of torque, motor, drive and load angle as comma-separated values."""
    torque, read = shaken_log(truth, seconds, amplitude, seed)
    columns, heads = [1e-3 * np.arange(torque.size), torque], ["time [s]", "torque [N m]"]
    for name, count, column in zip(("angle", "drive angle", "load angle"), truth.counts, read, strict=True):
        if count > 0.0:
            columns.append(column / (truth["gear"] if name == "load angle" else 1.0))
            heads.append(f"{name} [rad]")
    rows = "\n".join(",".join(f"{value:.9g}" for value in row) for row in np.column_stack(columns))
    return ",".join(heads) + "\n" + rows + "\n"
