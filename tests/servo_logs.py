"""Logs as users have them: moves of a position servo, a chirp or steps of torque; rigs sound and faulty."""

from math import pi, radians

import numpy as np
from reproduction.bench import BENCH_TESTS, bench_rig

from cabledrive.identification.planning import chirp
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.virtual_rig import Imperfections, VirtualRig, log_from, run_rig
from cabledrive.trajectories.segments import waypoints
from oracles.axis_catalogue import speed_of_move
from oracles.axis_plant import move, parameters

TEST = BENCH_TESTS[1]
RATE = 1000.0
RIGID = bench_rig(TEST).chain
JOINTED = LumpedChain(
    names=("motor", "drive"),
    inertias=(0.0011, 0.000642),
    viscous=(TEST.viscous, 0.0),
    coulomb=(TEST.coulomb, 0.0),
    offsets=(TEST.offset, 0.0),
    stiffness=(135.0,),
    damping=(0.075,),
    ratios=((1.0, 1.0),),
)
RIGS = {
    "rigid": (RIGID, {}),
    "stribeck": (RIGID, {"stribeck_excess": 0.03, "stribeck_speed": 1.0}),
    "backlash": (JOINTED, {"backlash": radians(1.0)}),
    "flexible": (JOINTED, {}),
}


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
        moving = np.sign(there - here) * speed_of_move(abs(there - here), top, rise)
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


def run_servo(rig, reference, rng, oversampling):
    """A PD on the motor's encoder, 6 Hz and damped by 0.8 around an axis without friction; speed at 50 Hz."""
    chain, flaws, omega = rig.chain, rig.imperfections, 2 * pi * 6.0
    joint = (
        {}
        if chain.size == 1
        else {
            "load_inertia": chain.inertias[1],
            "stiffness": chain.stiffness[0],
            "damping": chain.damping[0],
        }
    )
    plant = parameters(
        inertia=chain.inertias[0],
        viscous=TEST.viscous,
        coulomb=TEST.coulomb,
        offset=TEST.offset,
        gap=flaws.backlash,
        stribeck_excess=flaws.stribeck_excess,
        stribeck_speed=flaws.stribeck_speed,
        **joint,
    )
    gains = sum(chain.inertias) * omega * np.array([omega, 1.6])
    servo = np.array([1.0, *gains, 0.0, 0.0, 1.0 - np.exp(-2 * pi * 50.0 / RATE)])
    noise = flaws.amplifier_noise * rng.normal(size=reference.shape[1])
    phase, wanted = float(rng.uniform()), np.vstack([reference, 0 * noise])
    sensor = np.array([2 * pi / rig.encoders["angle"], phase, 0.0, 0.0])
    angle, torque = np.empty((2, noise.size))
    move(plant, noise, 0 * noise, wanted, servo, sensor, 1 / RATE, oversampling, 0, angle, torque)
    acting = np.roll(np.repeat(torque, oversampling), 1)  # the amplifier answers a step later
    return log_from(rig, acting, angle[:, None], rng, "virtual rig with servo", {"angle": phase})


def servo_log(motion, rig, seed, duration=60.0):
    """One log of "trapezoids", "s-curves", a "chirp" (0.5 to 60 Hz) or "steps"."""
    chain, flaws = RIGS[rig]
    rng = np.random.default_rng(seed)
    made = VirtualRig(chain=chain, torque_per_volt=1.6218, imperfections=Imperfections(**flaws))
    oversampling = 12 if rig == "backlash" else 4
    if motion in ("trapezoids", "s-curves"):
        reference = (trapezoids if motion == "trapezoids" else s_curves)(rng, duration)
        return run_servo(made, reference, rng, oversampling)
    if motion == "chirp":
        size = rng.uniform(0.15, 0.25) * rng.choice([-1, 1])
        command = size * chirp(duration, RATE, rng.uniform(0.4, 0.6), 60.0)
    else:
        command = steps(rng, duration)
    return run_rig(made, command, rng, oversampling=oversampling)
