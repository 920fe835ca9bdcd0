"""Logs as users have them: moves of a position servo, a chirp or steps of torque; rigs sound and faulty."""

from math import pi, radians

import numpy as np

from cabledrive.identification.excitation import chirp
from cabledrive.identification.logs.log import DataReport, Log
from cabledrive.rig.bench.chapter_4 import BENCH_TESTS
from cabledrive.trajectories.segments import waypoints
from oracles.axis_plant import move, parameters

TEST = BENCH_TESTS[1]
RATE, QUANTUM = 1000.0, 2 * pi / 2600
COMMON = {"viscous": TEST.viscous, "coulomb": TEST.coulomb, "offset": TEST.offset}
JOINT = COMMON | {"inertia": 0.0011, "load_inertia": 0.000642, "stiffness": 135.0, "damping": 0.075}
RIGS = {
    "rigid": COMMON | {"inertia": TEST.inertia},
    "stribeck": COMMON | {"inertia": TEST.inertia, "stribeck_excess": 0.03, "stribeck_speed": 1.0},
    "backlash": JOINT | {"gap": radians(1.0)},
    "flexible": JOINT,
}
TORQUE_PER_VOLT, AMPLIFIER, CELL = 1.6218, 0.005, 0.006
"""[N m/V]; noise of the torque that acts and of its reading [N m]."""


def distances(rng):
    """Moves to places between -3 and 3 rad, none shorter than 0.3 rad."""
    here = 0.0
    while True:
        there = rng.uniform(-3, 3)
        if abs(there - here) >= 0.3:
            yield here, there
            here = there


def trapezoids(rng, duration):
    """Angle and speed: 6 to 12 rad/s, 100 to 150 rad/s^2, rests of 0.05 to 0.3 s."""
    top, rise = rng.uniform(6, 12), rng.uniform(100, 150)
    samples, parts = round(duration * RATE), [np.zeros(1)]
    for here, there in distances(rng):
        way = there - here
        peak = min(top, np.sqrt(rise * abs(way)))
        up, flat = peak / rise, abs(way) / peak - peak / rise
        t = np.arange(0, 2 * up + flat, 1 / RATE)
        moving = np.sign(way) * np.interp(t, [0, up, up + flat, 2 * up + flat], [0, peak, peak, 0])
        parts += [moving, np.zeros(int(rng.uniform(0.05, 0.3) * RATE))]
        if sum(part.size for part in parts) > samples:
            break
    speed = np.concatenate(parts)[:samples]
    return np.array([np.concatenate([[0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) / RATE]), speed])


def s_curves(rng, duration):
    """Angle and speed of order 7: largest accelerations 80 to 120 rad/s^2."""
    places, rises, rests = [0.0], [], []
    for here, there in distances(rng):
        places.append(there)
        rises.append(np.sqrt(abs(there - here) * 7.5 / rng.uniform(80, 120)))
        rests.append(rng.uniform(0.05, 0.3))
        if sum(rises) + sum(rests) >= duration:
            break
    return waypoints(places, rise=rises, dwell=rests, order=7)(np.arange(round(duration * RATE)) / RATE, 1)


def steps(rng, duration):
    """Command: steps of 0.05 to 0.2 V to either side in turn, 0.1 to 0.6 s long."""
    parts, side = [], 1
    while sum(part.size for part in parts) < duration * RATE:
        length = int(rng.uniform(0.1, 0.6) * RATE)
        parts.append(np.full(length, side * rng.uniform(0.05, 0.2)))
        side = -side
    return np.concatenate(parts)[: round(duration * RATE)]


def servo_log(motion, rig, seed, duration=60.0):
    """One log of "trapezoids", "s-curves", a "chirp" (0.5 to 60 Hz) or "steps".

    The servo is a PD on the motor's encoder, 6 Hz and damped by 0.8 around an axis without friction, whose
    speed is a backward difference behind a low-pass of 50 Hz.
    """
    rng, plant = np.random.default_rng(seed), parameters(**RIGS[rig])
    reference, servo = np.zeros((3, round(duration * RATE))), np.zeros(6)
    command = AMPLIFIER * rng.normal(size=reference.shape[1])
    if motion in ("trapezoids", "s-curves"):
        reference[:2] = (trapezoids if motion == "trapezoids" else s_curves)(rng, duration)
        omega = 2 * pi * 6.0
        gains = TEST.inertia * omega * np.array([omega, 1.6])
        servo[:] = 1.0, *gains, 0.0, 0.0, 1.0 - np.exp(-2 * pi * 50.0 / RATE)
    elif motion == "chirp":
        size = rng.uniform(0.15, 0.25) * rng.choice([-1, 1])
        command += TORQUE_PER_VOLT * size * chirp(duration, RATE, rng.uniform(0.4, 0.6), 60.0)
    else:
        command += TORQUE_PER_VOLT * steps(rng, duration)
    angle, torque = np.empty((2, command.size))
    sensor = np.array([QUANTUM, rng.uniform(), 0.0, 0.0])
    fine = 12 if rig == "backlash" else 4
    move(plant, command, 0 * command, reference, servo, sensor, 1 / RATE, fine, 0, angle, torque)
    channels = {
        "torque": torque + CELL * rng.normal(size=torque.size),
        "angle": QUANTUM * np.floor(angle / QUANTUM + sensor[1]),
    }
    report = DataReport(rows=torque.size, duration=duration, interval=1 / RATE, quantum={"angle": QUANTUM})
    return Log(
        source="virtual rig with servo",
        time=np.arange(torque.size) / RATE,
        channels=channels,
        units={"torque": "N m", "angle": "rad"},
        report=report,
    )
