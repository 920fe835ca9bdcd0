"""A body between two motors in closed loop, compiled; runs of one plant and of many."""

from dataclasses import dataclass
from math import ceil, exp, inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.control import tension_position as theory
from cabledrive.mechanics.compiled import njit, njit_part
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import LARGEST
from cabledrive.reduction.two_motors import TwoMotors, line_at, pulled
from cabledrive.rig.closed_loop.chain_kernels import counted, rubbed
from cabledrive.rig.plant_samples import error_words, share_low
from cabledrive.rig.winch_plan import Setup, held_tensions, lines_along

# Columns of a record of m coordinates, in this order: place (m), tensions, torques, angles of the drums,
# reshaped, wanted tensions.
COLUMNS = 9


class RigNumbers(NamedTuple):
    """Sampling and sensors."""

    substeps: int  # internal steps per sample
    late: int  # delay from sampling to torque, in internal steps
    lag: float  # part of the distance to the commanded torque that remains after an internal step
    counts: Array  # (2,): one count of each drum's encoder [rad]; 0: exact
    phases: Array  # (2,): where in its count each starts
    noise: Array  # (samples, 2): of the load cells [N]


class Moving(NamedTuple):
    """What moves, and scratch: places and speeds, shape (m,), angles and speeds of the drums, shape (2,)."""

    q: Array
    v: Array
    angle: Array
    turn: Array
    law: Array  # (3 m + 9,): state of the law
    torque: Array  # (2,): of the motors [N m]
    commands: Array  # (delay in whole samples + 2, 2): on their way, the newest last [N m]
    along: Array  # (2, m): directions of the lines
    tension: Array  # (2,): of the lines [N]


def at_rest(machine: TwoMotors, law: Array, rig: RigNumbers, q: Array, angle: Array) -> Moving:
    """The body at a place (m,) [m], the drums at angles (2,) [rad]; the motors hold the lines."""
    commands, (turn, torque, tension) = np.zeros((rig.late // rig.substeps + 2, 2)), np.zeros((3, 2))
    body = Moving(q, 0.0 * q, angle, turn, law, torque, commands, np.zeros((2, q.size)), tension)
    pull_of(machine, body)
    torque[:] = commands[:] = machine.drum * tension
    return body


@njit
def close_loop(
    machine: TwoMotors,
    gains: theory.TensionGains,
    body: Moving,
    rig: RigNumbers,
    table: tuple[Array, Array],
    kept: tuple[Array, Array],
) -> int:
    """Run a table, (samples, 3 m + 2), under a force, (samples, m) [N]; returns how many samples were sound.

    ``kept``: what happens, shape (samples, m + 9), and the least tension between samples as well, (2,) [N].
    """
    (reference, force), (record, least) = table, kept
    q, _, angle, _, law, torque, commands, _, tension = body
    m, part, newest = q.size, rig.late % rig.substeps, len(commands) - 1
    command, measurement, space = np.zeros(2), np.zeros(4), (np.zeros((2, m)), np.zeros(3 * m + 22))
    pull_of(machine, body)
    for k in range(len(reference)):
        for i in range(2):
            measurement[i] = counted(angle[i], rig.counts[i], rig.phases[i])
            measurement[2 + i] = tension[i] + rig.noise[k, i]
        theory.step_in_place(gains, law, measurement, reference[k], command, space)
        for j in range(m):
            record[k, j] = q[j]
            if not abs(q[j]) < 1e6:
                return k
        for i in range(2):
            for older in range(newest):
                commands[older, i] = commands[older + 1, i]
            commands[newest, i] = command[i]
            record[k, m + i], record[k, m + 2 + i] = tension[i], command[i]
            record[k, m + 4 + i], record[k, m + 7 + i] = angle[i], law[3 * m + 7 + i]
            if not abs(command[i]) < LARGEST:
                return k
        record[k, m + 6] = law[3 * m + 6]
        for s in range(rig.substeps):
            arrived = 1 if s >= part else 0
            for i in range(2):
                torque[i] = commands[arrived, i] + rig.lag * (torque[i] - commands[arrived, i])
            move(machine, body, gains.interval / rig.substeps, torque, force[k])
            for i in range(2):
                least[i] = min(least[i], tension[i])
    return len(reference)


@njit_part
def pull_of(machine: TwoMotors, body: Moving) -> None:
    """Write directions and tensions of both lines."""
    for i in range(2):
        length, free, _ = line_at(machine, i, body.q, body.along[i])
        speed = machine.drum[i] * body.turn[i]
        for j in range(body.q.size):
            speed += body.along[i, j] * body.v[j]
        stretch = length + machine.drum[i] * body.angle[i] - machine.unwound[i]
        body.tension[i] = pulled(stretch, speed, machine.rigidity[i] / free, machine.loss[i] / free)


@njit_part
def move(m: TwoMotors, body: Moving, h: float, torque: Array, force: Array) -> None:
    """One internal step: speeds by the forces, friction set-valued, then places (symplectic)."""
    pull_of(m, body)
    along, tension, v, turn = body.along, body.tension, body.v, body.turn
    for j in range(v.size):
        total = m.force[j] + force[j] - along[0, j] * tension[0] - along[1, j] * tension[1]
        v[j] = held_back(v[j], total, m.mass[j], m.viscous[j], m.coulomb[j], h)
        body.q[j] += h * v[j]
    for i in range(2):
        total = torque[i] - m.drum[i] * tension[i]
        turn[i] = held_back(turn[i], total, m.inertia[i], m.turning_viscous[i], m.turning_coulomb[i], h)
        body.angle[i] += h * turn[i]


@njit_part
def held_back(speed: float, force: float, mass: float, viscous: float, coulomb: float, h: float) -> float:
    """Speed after a step under a force, with friction that holds what it can hold."""
    return rubbed(mass * speed + h * force, h * coulomb) / (mass + h * viscous)


INTERNAL_STEP = 1e-4
"""Largest internal step of the plant [s]; smaller where the lines are stiff."""
STEPS_PER_RADIAN = 20.0


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantRun:
    """One plant under the law."""

    record: Array  # (samples, m + 9), of `COLUMNS`; fewer samples where a number was not finite
    least: Array  # (2,): least tension, between samples as well [N]
    rig: RigNumbers


def run_plant(setup: Setup, actual: TwoMotors, force: Array, rng: np.random.Generator) -> PlantRun:
    """Run one plant, at rest at first, with encoder phases and cell noise drawn."""
    design, gains, table, m = setup.design, setup.design.gains, setup.table, actual.mass.size
    # Steps that resolve the fastest motion of drums and body against the lines.
    reach = np.sqrt(((actual.anchor - actual.centre) ** 2).sum(axis=1)) + actual.fixed
    stiffness = actual.rigidity / reach
    fastest = np.sqrt(np.max(stiffness * (actual.drum**2 / actual.inertia + 1.0 / actual.mass.min())))
    per_second = max(1.0 / INTERNAL_STEP, STEPS_PER_RADIAN * float(fastest))
    substeps = int(max(1, ceil(gains.interval * per_second)))
    step = gains.interval / substeps
    rig = RigNumbers(
        substeps=substeps,
        late=round(design.delay / step),
        lag=exp(-design.rate * step) if design.rate else 0.0,
        counts=np.full(2, design.count),
        phases=rng.uniform(-0.5, 0.5, 2),
        noise=rng.normal(0.0, design.noise, (len(table), 2)),
    )
    record, least = np.zeros((len(table), m + COLUMNS)), np.full(2, np.inf)
    start = at_rest(actual, theory.first_state(gains, setup.machine.tension), rig, np.zeros(m), np.zeros(2))
    ended = close_loop(actual, gains, start, rig, (table, force), (record, least))
    return PlantRun(record=record[:ended], least=least, rig=rig)


CHECKED_PLACES = 50
"""At most so many places of the way are looked at."""


def bound_of_place(setup: Setup) -> Array:
    """Bound of each coordinate along the way, for gusts as the tension is promised for, shape (m,) [m]."""
    gains, design, numbers = setup.design.gains, setup.design, setup.machine.numbers
    m = numbers.mass.size
    places = np.ascontiguousarray(setup.table[:: max(1, len(setup.table) // CHECKED_PLACES), :m])
    along, _, free = lines_along(numbers, places)
    turns, pulls = np.abs(np.linalg.pinv(along)), np.abs(along)
    stretch = design.noise * free / numbers.rigidity
    rounded = 0.5 * design.count * numbers.drum
    unexpected = (design.gust + numbers.coulomb) / numbers.mass
    tension = np.einsum("kim,i->km", pulls, design.margin).max(axis=0) / numbers.mass
    counts = np.einsum("kmi,i->km", turns, rounded).max(axis=0)
    of_place = np.sqrt(np.einsum("kmi,ki->km", turns**2, stretch**2)).max(axis=0)
    of_rate = design.noise * np.sqrt((pulls**2).sum(axis=1)).max(axis=0) / numbers.mass
    answers = theory.place_answers(gains.position, gains.filter, gains.observer)
    largest, noise = np.array([unexpected, tension, counts]), np.array([of_place, of_rate])
    return theory.place_bound(answers, gains.interval, largest, noise)


def part_used(bound: Array, error: Array) -> float:
    """Largest part of the bound, shape (m,), that an error used, shape (samples, m); above 1: left."""
    return float((np.abs(error).max(axis=0) / bound).max())


MASS, RIGIDITY, FRICTION = 0.1, 0.1, 0.5
"""Each true value is drawn evenly within this part of what is believed."""
GUSTS = 3


def run_samples(setup: Setup, draws: int, rng: np.random.Generator) -> dict[str, Any]:
    """Run drawn plants with gusts; how many kept every line tight, and the least share that this shows."""
    rows, bound, m = [], bound_of_place(setup), setup.machine.numbers.mass.size
    for _ in range(draws):
        done = run_plant(setup, drawn_plant(setup, rng), drawn_gusts(setup, rng), rng)
        found = 0.0, inf, inf
        if len(done.record) == len(setup.table):
            off = done.record[:, :m] - setup.table[:, :m]
            away = float(np.sqrt((off**2).sum(axis=1)).max())
            found = float(done.least.min()), away, part_used(bound, off)
        rows.append(found)
    least, errors, used = zip(*rows, strict=True)
    kept = sum(value >= setup.design.floor for value in least)
    shares = {"median_peak_error_mm": 0.5, "worst_peak_error_mm": 1.0}
    return error_words(1e3 * np.array(errors), shares) | {
        "draws": draws,
        "kept": kept,
        "share": kept / draws,
        "share_low": share_low(kept, draws),
        "least_tension": min(least),
        "position_bound_left": sum(part > 1.0 for part in used),
        "drawn": f"mass and stiffness within {MASS:.0%}, friction within {FRICTION:.0%}, {GUSTS} gusts of up "
        f"to {setup.design.gust:.4g} N in any direction",
    }


def drawn_plant(setup: Setup, rng: np.random.Generator) -> TwoMotors:
    """A plant around the believed one that rests where it is believed to rest."""
    numbers = setup.machine.numbers
    heavier, stiffer = 1.0 + rng.uniform(-MASS, MASS), 1.0 + rng.uniform(-RIGIDITY, RIGIDITY)
    rougher = 1.0 + rng.uniform(-FRICTION, FRICTION, 2)
    along = numbers.bearing @ numbers.frame
    extra = np.linalg.lstsq(along.T, (heavier - 1.0) * numbers.force, rcond=None)[0]
    rest = setup.machine.tension + extra
    ratio = rest / setup.machine.tension / stiffer
    return numbers._replace(
        mass=numbers.mass * heavier,
        force=numbers.force * heavier,
        rigidity=numbers.rigidity * stiffer,
        unwound=numbers.unwound * ratio,
        turning_coulomb=numbers.turning_coulomb * rougher,
    )


def drawn_gusts(setup: Setup, rng: np.random.Generator) -> Array:
    """Gusts that step in and out at random, together never above the stated force, shape (samples, m) [N]."""
    samples, m = len(setup.table), setup.machine.numbers.mass.size
    force = np.zeros((samples, m))
    edges = np.sort(rng.integers(0, samples, 2 * GUSTS)).reshape(GUSTS, 2)
    for first, last in edges:
        direction = rng.normal(size=m)
        size = setup.design.gust * rng.uniform() / np.linalg.norm(direction)
        force[first:last] = size * direction
    return force


DIFFERENCE = 1e-6
_SLOW = 0.2


def loop_poles(
    machine: TwoMotors, gains: theory.TensionGains, place: Array, rig: RigNumbers
) -> NDArray[np.complex128]:
    """Poles of the loop about the body at rest at a place [m], without dead beats, shape (p,) [rad/s]."""
    still = machine._replace(turning_coulomb=np.zeros(2), coulomb=np.zeros_like(machine.coulomb))
    believed = gains._replace(machine=still)
    along, length, free = lines_along(still, place[None])
    tension = held_tensions(gains.preferred, along, still.force[None])[0]
    angle = (still.unwound - length[0] + tension * free[0] / still.rigidity) / still.drum
    m, law = place.size, theory.first_state(gains, tension)
    law[:m], law[3 * m + 4 : 3 * m + 6] = place, angle
    table = np.concatenate([place, np.zeros(2 * m + 2)])[None], np.zeros((1, m))
    exact = rig._replace(counts=np.zeros(2), noise=np.zeros((1, 2)))

    def state_of(one: Moving) -> Array:  # without what the next sample does not read
        return np.concatenate([*one[:4], one.law[: 3 * m + 6], one.torque, one.commands[:0:-1].ravel()])

    def following(x: Array) -> Array:
        """The loop one sample later."""
        q, v, angle, turn, own, torque, past = np.split(x.copy(), cuts)
        one = held._replace(q=q, v=v, angle=angle, turn=turn, law=law.copy(), torque=torque)
        one.law[: 3 * m + 6], one.commands[:0:-1] = own, past.reshape(-1, 2)
        close_loop(still, believed, one, exact, table, (np.zeros((1, m + COLUMNS)), np.zeros(2)))
        return state_of(one)

    held = at_rest(still, law, exact, place, angle)
    rest = state_of(held)
    cuts = np.cumsum([m, m, 2, 2, 3 * m + 6, 2])
    size = np.ones(rest.size)
    size[5 * m + 4 : 5 * m + 8], size[cuts[4] :] = tension.max(), np.abs(rest[cuts[4] :]).max()
    columns = [
        (following(rest + h) - following(rest - h)) / (2.0 * DIFFERENCE) for h in DIFFERENCE * np.diag(size)
    ]
    values = np.linalg.eigvals(size[:, None] ** -1 * np.array(columns).T)
    return np.asarray(np.log(values[np.abs(values) > _SLOW]) / gains.interval)
