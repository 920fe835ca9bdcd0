"""Random drives and motions for the alarm, drawn without looking at what the alarm says of them."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

import cabledrive as cd
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.rest import rest_state
from cabledrive.studies.motion_response import _crossing_times, prepare
from cabledrive.studies.planned_motion import PlannedMotion
from network_samples import as_routes

KINDS = ("1:2", "direct", "sum", "anywhere")
SIGNALS = ("tone", "chirp", "move with ripple", "jerks", "noise")
RADIUS = 0.03
MOST_NODE_STEPS = 3e7
"""Of one run of the full model: bounds the length of a motion."""


@dataclass(frozen=True)
class Sample:
    """One drive, one motion, what is always there, what is allowed."""

    kind: str
    signal: str
    drive: cd.Drive
    motion: PlannedMotion
    omega: float
    floor: float
    limit: float


def log_uniform(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def random_drive(rng, heavy=False):
    """A loop or line with gravity: slope, sag, carriages, motor and damping over wide ranges.

    `heavy`: a span weighs 0.1 to 3 times as much as either rim.
    """
    length, density = log_uniform(rng, 0.5, 20.0), log_uniform(rng, 3e-4, 3e-2)
    slope = float(rng.choice([0.0, 0.0, 0.5236, -0.5236, -pi / 2, rng.uniform(-1.4, 1.4)]))
    sag, strain = log_uniform(rng, 1e-5, 8e-3), log_uniform(rng, 1e-3, 8e-3)
    pretension = density * 9.81 * length / (8 * sag)
    loop = rng.uniform() < 0.85
    weight = 2 * density * length
    masses = weight * log_uniform(rng, 1.0, 100.0), weight * log_uniform(rng, 0.3, 30.0)
    if heavy:
        masses = tuple(density * length / log_uniform(rng, 0.1, 3.0) for _ in range(2))
    damping = log_uniform(rng, 3e-4, 1e-2)
    lowest = pi * np.sqrt(pretension / density) / length
    elastic = np.sqrt(2 * pretension / strain / length / min(masses))
    pulleys = [
        cd.Pulley(
            radius=RADIUS,
            inertia=m * RADIUS**2,
            viscous_friction=2 * log_uniform(rng, 5e-4, 2e-2) * elastic * m * RADIUS**2,
        )
        for m in masses
    ]
    motor = None
    if rng.uniform() < 0.5:
        own = log_uniform(rng, 0.3, 3.0) * pulleys[0].inertia
        joint = (
            (elastic * rng.uniform(0.8, 4.0)) ** 2 * min(own, pulleys[0].inertia)
            if rng.uniform() < 0.4
            else None
        )
        motor = cd.Motor(inertia=own, joint_stiffness=joint)
    carriages, taken = [], set()
    for _ in range(int(rng.choice([0, 0, 1, 1, 2]))):
        span = "lower" if loop and rng.uniform() < 0.4 else "upper"
        guided = rng.uniform() < 0.7
        mass = weight * (log_uniform(rng, 0.3, 20.0) if guided else 0.5 * log_uniform(rng, 0.03, 0.6))
        place = length * rng.uniform(0.2, 0.8)
        if all(abs(place - other) > 0.1 * length for other in taken):
            taken.add(place)
            carriages.append(cd.Carriage(mass=mass, position=place, span=span, guided=bool(guided)))
    return cd.Drive(
        name="random",
        kind="loop" if loop else "line",
        cable=cd.Cable(
            youngs_modulus=pretension / strain / 1e-6,
            area=1e-6,
            mass_per_length=density,
            pretension=pretension,
            transverse_damping=2 * damping * lowest,
            axial_damping=log_uniform(rng, 1e-4, 3e-3) * pretension / strain / elastic,
        ),
        layout=cd.Layout(span_length=length, inclination=slope),
        pulley=tuple(pulleys),
        carriage=tuple(carriages),
        motor=motor,
    )


def with_pretension(drive, pretension):
    return replace(drive, cable=replace(drive.cable, pretension=pretension))


def taut(drive):
    """State of rest where every piece keeps some tension and sags little, else None."""
    if not 3e-4 < drive.cable.prestrain < 2e-2:
        return None
    try:
        state = rest_state(drive)
    except (cd.NotComputed, cd.InputRefused):
        return None
    forces = [own for piece in state.stretches for own in (piece.force, piece.end_force)]
    steepest = max(abs(across / along) for along, across in forces)
    fits = state.lowest_tension > 0.25 * drive.cable.pretension and steepest < 0.08
    return state if fits else None


def crossing_times(drive):
    """Time that a transverse wave takes along each free stretch, upper first."""
    return _crossing_times(network_of(as_routes(drive)))


def tuned(rng, kind, drive):
    """The drive, its pretension moved for a 1:2 pair, and the torque's frequency; None where that fails."""
    state = taut(drive)
    if state is None:
        return None
    along = [2 * pi * hertz for hertz in cd.natural_frequencies(drive, count=2, motor="free")]
    pulley = along[int(rng.uniform() < 0.25)]
    parts = crossing_times(drive)
    which, number = int(rng.integers(len(parts))), int(rng.integers(1, 9))
    if kind == "1:2":
        aim = 0.5 * pulley * (1 + 0.01 * rng.standard_normal())
        for _ in range(4):
            own = number * pi / crossing_times(drive)[which]
            drive = with_pretension(drive, drive.cable.pretension * (aim / own) ** 2)
            state = taut(drive)
            if state is None:
                return None
        return drive, pulley * (1 + 0.003 * rng.standard_normal())
    own = pi / parts[which]
    if kind == "direct":
        return drive, min(number, 5) * own * (1 + 0.01 * rng.standard_normal())
    if kind == "sum":
        number = min(number, 4)
        return drive, (2 * number + rng.integers(1, 3)) * own * (1 + 0.005 * rng.standard_normal())
    return drive, log_uniform(rng, own, 1.2 * along[0]) if along[0] > own else along[0]


def unit_torque(rng, signal, time, omega):
    """A torque of size one around a frequency."""
    duration = time[-1]
    if signal == "tone":
        return np.sin(omega * time)
    if signal == "chirp":
        ratio = np.linspace(*(1 + rng.uniform(-0.06, 0.06, 2)), time.size)
        return np.sin(omega * np.cumsum(ratio) * time[1])
    if signal == "move with ripple":
        rise = np.clip(time / (0.5 * duration), 0.0, 1.0)
        return np.sin(2 * pi * rise) * (1 + 0 * time) + rng.uniform(0.03, 0.6) * np.sin(omega * time)
    if signal == "jerks":
        sides = np.sign(np.sin(omega * time / rng.integers(1, 4)))
        return np.where(time < rng.uniform(0.3, 1.0) * duration, sides, 0.0)
    phases, widths = rng.uniform(0, 2 * pi, 12), 1 + 0.08 * rng.standard_normal(12)
    return sum(np.sin(omega * w * time + p) for w, p in zip(widths, phases, strict=True)) / 4.0


def random_sample(rng, node_steps=MOST_NODE_STEPS, heavy=False):
    """A drive and a motion of a random kind; one run of the full model takes no more than some node steps."""
    while True:
        kind, signal = str(rng.choice(KINDS)), str(rng.choice(SIGNALS))
        found = tuned(rng, kind, random_drive(rng, heavy))
        if found is None:
            continue
        drive, omega = found
        lowest = pi / max(crossing_times(drive))
        duration = 2 * pi / lowest * rng.uniform(12, 25)
        speed = drive.cable.axial_wave_speed
        cost = duration * speed / (drive.span_length / 100) * 100 * len(drive.spans)
        duration *= min(1.0, node_steps / cost)
        if duration < 9 * 2 * pi / lowest or duration * omega > 2500:
            continue
        time = np.linspace(0.0, duration, int(duration * omega / (2 * pi) * 40) + 200)
        unit = unit_torque(rng, signal, time, omega)
        size = log_uniform(rng, 0.1, 0.9)
        limit = drive.span_length * log_uniform(rng, 5e-5, 1e-3)
        floor = limit / rng.uniform(20, 60)
        return scaled(
            Sample(kind, signal, drive, PlannedMotion(time=time, torque=unit), omega, floor, limit), size, rng
        )


def scaled(sample, size, rng):
    """The same motion, its torque such that a linear span would lose a share of its least tension."""
    drive, unit = sample.drive, sample.motion.torque
    holding = rest_state(drive).holding_torque
    small = 1e-6 * drive.cable.pretension * drive.drive_pulley.radius
    trial = PlannedMotion(time=sample.motion.time, torque=holding + small * unit)
    prepared = prepare(drive.machine, trial)
    rest = float(prepared.models[0].rest.min())
    lost = max(rest - prepared.response().tension, 1e-12 * rest)
    amplitude = min(size * rest / lost * small, 0.5 * rest * drive.drive_pulley.radius)
    if rng.uniform() < 0.25:
        share = rng.uniform(0.02, 0.2, 2) * amplitude
        pulley = [replace(p, coulomb_friction=float(c)) for p, c in zip(drive.pulley, share, strict=True)]
        drive = replace(drive, pulley=tuple(pulley))
    motion = PlannedMotion(time=sample.motion.time, torque=holding + amplitude * unit)
    return replace(sample, drive=drive, motion=motion)


def scaled_torque(sample, factor):
    """The same motion with its torque above the holding torque multiplied."""
    holding = rest_state(sample.drive).holding_torque
    torque = holding + factor * (sample.motion.torque - holding)
    return replace(sample, motion=PlannedMotion(time=sample.motion.time, torque=torque))


def varied(sample, rng):
    """A neighbour: other frequency, pretension, damping, perhaps waveform; None where it cannot rest."""
    change = 1.0 + 0.015 * rng.standard_normal(2)
    drive = with_pretension(sample.drive, sample.drive.cable.pretension * change[0])
    loss = float(rng.uniform(0.5, 1.1)) * drive.cable.transverse_damping
    drive = replace(drive, cable=replace(drive.cable, transverse_damping=loss))
    if taut(drive) is None:
        return None
    old = rest_state(sample.drive).holding_torque
    new = rest_state(drive).holding_torque
    time, above = sample.motion.time, sample.motion.torque - old
    if rng.uniform() < 0.4:
        signal = str(rng.choice(SIGNALS))
        unit = unit_torque(rng, signal, time, sample.omega * change[1])
        above, sample = unit * np.abs(above).max() / np.abs(unit).max(), replace(sample, signal=signal)
    else:
        above = np.interp(time * change[1], time, above)
    return replace(sample, drive=drive, motion=PlannedMotion(time=time, torque=new + above))
