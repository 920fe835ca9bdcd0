"""A carriage with a hanging mass in closed loop: its compiled motion, and `move_carriage` under a law."""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import cos, isfinite, pi, sin
from typing import NamedTuple

import numpy as np

from cabledrive.answers.figures import figure
from cabledrive.answers.result import Result
from cabledrive.control.load_schedule import ScheduledLaw, scheduled_step
from cabledrive.control.transporter import STATES, flat_motion, rigid_motion, scheduled_law, shaped
from cabledrive.mechanics.compiled import njit, njit_in_place
from cabledrive.parameters import Drive, InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import check_fields, described, meaning, quantity
from cabledrive.reduction.network_axis import as_axis
from cabledrive.reduction.transporter import Transporter, transporter_of
from cabledrive.rig.setting import Task, sample_interval, torque_limit
from cabledrive.trajectories import Trajectory, waypoints


class CarriageLoop(NamedTuple):
    """Everything of a run but the plant."""

    law: ScheduledLaw
    reference: Array  # (samples, 10): of `cabledrive.control.transporter.flat_motion`
    wind: Array  # (samples,): force on the payload [N]
    interval: float  # sample time [s]
    substeps: int  # internal steps of the plant per sample
    one_count: float  # of the encoders at the rim [m]; 0: they give the displacements themselves


@njit_in_place
def strand_tensions(plant: Transporter, x: Array, tensions: Array) -> None:
    """Tension of the three strands, none of which can push, Eq. (T.2); x: 4 coordinates, 4 rates."""
    span, start, time = plant.span_length, plant.start, plant.damping_time
    grown = 1.0 + plant.pretension / plant.axial_rigidity
    natural = (start + x[0] / grown, span - start - x[2] / grown, span + (x[2] - x[0]) / grown)
    actual = (start * grown + x[1], (span - start) * grown - x[1], span * grown)
    rate = (x[5] - x[4], x[6] - x[5], x[4] - x[6])
    for i in range(3):
        strain = actual[i] / natural[i] - 1.0 + time * rate[i] / natural[i]
        tensions[i] = max(plant.axial_rigidity * strain, 0.0)


@njit_in_place
def transporter_rates(
    plant: Transporter, x: Array, push: tuple[float, float], stuck: bool, tensions: Array, out: Array
) -> float:
    """Rates of the states, Eq. (T.10); returns the force on the motor without its Coulomb friction.

    ``push``: force of the motor and wind on the payload [N]. x[3] is the swing [rad]. A pulley feeds cable at
    its prestrain: it gives T (1 + e / 2) / (1 + prestrain), the derivative of the energy by what is fed, so
    that none is lost.
    """
    strand_tensions(plant, x, tensions)
    rigidity = plant.axial_rigidity
    grown = 1.0 + plant.pretension / rigidity
    first, second, third = tensions[0], tensions[1], tensions[2]
    first *= (1.0 + 0.5 * first / rigidity) / grown
    second *= (1.0 + 0.5 * second / rigidity) / grown
    third *= (1.0 + 0.5 * third / rigidity) / grown
    motor = push[0] + plant.offset + first - third - plant.viscous * x[4]
    for i in range(4):
        out[i] = x[4 + i]
    slip = np.sign(x[4] if x[4] != 0.0 or abs(motor) <= plant.coulomb else motor)
    out[4] = 0.0 if stuck else (motor - slip * plant.coulomb) / plant.drive_mass
    line, payload, wind = plant.line_length, plant.payload_mass, push[1]
    s, c, turn = sin(x[3]), cos(x[3]), x[7]
    back = plant.gravity * s + plant.swing_damping * plant.gravity / line * line * turn
    pull = tensions[1] - tensions[0] - plant.rail_friction * x[5] + wind * (1.0 - c * c)
    pull += payload * (line * turn * turn * s + c * back)
    out[5] = pull / (plant.carriage_mass + payload * (1.0 - c * c))
    out[6] = (third - second) / plant.load_mass
    out[7] = (wind * c / payload - back - c * out[5]) / line
    return motor


@njit_in_place
def transporter_advance(
    plant: Transporter, x: Array, push: tuple[float, float], step: float, tensions: Array, work: Array
) -> None:
    """One internal step of fourth order; a motor that turns in it stops at its end and may stick."""
    stuck = x[4] == 0.0
    if stuck:
        motor = transporter_rates(plant, x, push, True, tensions, work[0])
        stuck = abs(motor) <= plant.coulomb
    before = x[4]
    weights = (0.0, 0.5, 0.5, 1.0)
    for stage in range(4):
        for i in range(8):
            work[4, i] = x[i] + (weights[stage] * step * work[stage - 1, i] if stage > 0 else 0.0)
        transporter_rates(plant, work[4], push, stuck, tensions, work[stage])
    for i in range(8):
        x[i] += step / 6.0 * (work[0, i] + 2.0 * work[1, i] + 2.0 * work[2, i] + work[3, i])
    if stuck or before * x[4] < 0.0:
        x[4] = 0.0


@njit
def run_transporter(loop: CarriageLoop, plant: Transporter, phases: Array, x: Array, log: Array) -> int:
    """Run all samples, rows as `run_carriage` has them; returns the sample at which the run ended."""
    reference, count = loop.reference, loop.one_count
    estimate, fresh = np.zeros(loop.law.transition.shape[1]), np.zeros(loop.law.transition.shape[1])
    readings, tensions, work = np.zeros(2), np.zeros(3), np.zeros((5, 8))
    for k in range(reference.shape[0]):
        place = plant.start + x[1]
        if not 0.0 < place < plant.span_length:
            return k
        for j in range(2):
            readings[j] = count * np.rint(x[2 * j] / count + phases[j]) if count > 0.0 else x[2 * j]
        force = scheduled_step(loop.law, estimate, readings, reference, k, fresh)
        strand_tensions(plant, x, tensions)
        for i in range(8):
            log[k, i] = x[i]
        log[k, 8] = x[1] + plant.line_length * sin(x[3])
        for i in range(3):
            log[k, 9 + i] = tensions[i]
        log[k, 12] = force
        if min(tensions[0], tensions[1], tensions[2]) <= 0.0:
            return k
        for _ in range(loop.substeps):
            transporter_advance(
                plant, x, (force, loop.wind[k]), loop.interval / loop.substeps, tensions, work
            )
    return reference.shape[0]


CARRIAGE, PAYLOAD, TENSIONS, FORCE = 1, 8, 9, 12
"""Columns of a log; eight states come first, three tensions stand from `TENSIONS` on."""


def run_carriage(loop: CarriageLoop, plant: Transporter, phases: Array) -> Array:
    """Run a plant under the law; ``phases``, shape (2,) [counts]; returns the log, shape (samples, 13).

    It is shorter where a strand went slack or the carriage left its span.
    """
    log = np.zeros((len(loop.reference), FORCE + 1))
    return log[: run_transporter(loop, plant, phases, np.zeros(8), log)]


MARGIN = 0.05


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageMove(Task):
    """What is asked of the transporter."""

    unit = "m"
    of = "a carriage with a hanging mass"

    distance: float = meaning("way of the carriage [m]", 1.0)
    duration: float = quantity("s", "positive", "of the move", 2.5)
    rest: float = quantity("s", "positive", "how long the run goes on at the end", 3.0)
    payload_mass: float = quantity("kg", "positive", "of the hanging mass", 0.25)
    line_length: float = quantity("m", "positive", "of the line on which it hangs", 0.25)
    gust: tuple[float, float, float] = meaning(
        "force of the wind on the payload [N], its start and end [s]", (0.0, 1.0, 1.5)
    )

    def __post_init__(self) -> None:
        check_fields(self)
        if not isfinite(self.distance) or self.distance == 0.0:
            raise InputRefused(f"distance = {self.distance:.4g} m must be finite and not 0: give a way to go")
        if not all(isfinite(value) for value in self.gust) or self.gust[1] > self.gust[2]:
            raise InputRefused(f"gust = {self.gust} must be a force, a start and a later end: mend it")

    @property
    def trajectory(self) -> Trajectory:
        """One way, and its rest."""
        return waypoints((0.0, self.distance), rise=self.duration, dwell=self.rest, order=ORDER)


@described
@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class CarriageRun(Result):
    """A run of the transporter."""

    _heading, _table = "{0.law}", "time: wanted payload carriage swing tensions force"
    law: str = meaning("its name")
    time: Array = meaning("(samples,) [s]")
    wanted: Array = meaning("(samples,): displacement asked for [m]")
    payload: Array = meaning("(samples,): true displacement of the hanging mass [m]")
    carriage: Array = meaning("(samples,): true displacement [m]")
    swing: Array = meaning("(samples,): angle of the line [rad]")
    tensions: Array = meaning("(samples, 3): of the strands [N]")
    force: Array = meaning("(samples,): of the motor at the rim [N]")
    arrival: float = figure("s", "when the motion is to be over", "Run")
    incomplete: str | None = meaning("why the run ended early")

    def residual(self, *, later: float = 0.0) -> float:
        """Largest distance of the payload from where it is to rest, once the motion is over.

        Parameters
        ----------
        later : float, default 0.0
            How long after the arrival to begin [s].

        Returns
        -------
        float
            [m]; infinite where the run ended early.
        """
        after = self.time >= self.arrival + later
        if self.incomplete or not after.any():
            return float("inf")
        return float(np.abs(self.payload[after] - self.wanted[-1]).max())


def one_count(drive: Drive) -> float:
    """One count of the pulleys' encoders at the rim [m]."""
    sensors = drive.sensors
    found = (sensors.drive_encoder, sensors.load_encoder) if sensors else (None, None)
    if found[0] is None or found[0] != found[1]:
        raise InputRefused(
            f"sensors.drive_encoder = {found[0]} and sensors.load_encoder = {found[1]}: give both, alike"
        )
    return 2.0 * pi / found[0] * drive.drive_pulley.radius


LAWS = {
    "scheduled": ("by position", "flat"),
    "frozen": ("of the middle of the way", "flat"),
    "pd-flat": ("PD on the motor", "flat"),
    "pd": ("PD on the motor", "rigid"),
    "shaper": ("PD on the motor", "rigid, shaped"),
}
"""Feedback and feedforward of each law."""
PD_HZ, POSITIONS, SUBSTEPS = 5.0, 12, 5
ORDER = 13
"""Lowest order of the rise: six derivatives enter the feedforward."""


def move_carriage(
    drive: Machine | Drive,
    law: str = "scheduled",
    *,
    move: CarriageMove | None = None,
    plant: Transporter | None = None,
    seed: int = 0,
    ideal_sensors: bool = False,
) -> CarriageRun:
    """Carry a hanging mass along the span and look at what swings on; delay and torque loop are left out.

    Parameters
    ----------
    drive : Machine or Drive
        As the law believes it to be: a loop with motor, encoders at both pulleys and one guided carriage.
    law : {"scheduled", "frozen", "pd-flat", "pd", "shaper"}
    move : CarriageMove, optional
        Default: 1 m in 2.5 s with 0.25 kg on a line of 0.25 m.
    plant : Transporter, optional
        As it is, where that differs.
    seed : int, default 0
        Of the encoders' phases.
    ideal_sensors : bool, default False
        The encoders do not count but give the displacements themselves.

    Returns
    -------
    CarriageRun

    Raises
    ------
    InputRefused
        If there is no such law, or the carriage would leave its span.
    """
    if law not in LAWS:
        raise InputRefused(f"law = {law!r} is not known: take one of {', '.join(LAWS)}")
    drive, move = as_axis(drive), CarriageMove.asked(move)
    believed = transporter_of(drive, payload_mass=move.payload_mass, line_length=move.line_length)
    end, length = believed.start + move.distance, believed.span_length
    if not MARGIN < min(believed.start, end) <= max(believed.start, end) < length - MARGIN:
        raise InputRefused(
            f"the carriage goes from {believed.start:.4g} m to {end:.4g} m, nearer than {MARGIN:g} m to "
            f"an end of its span of {length:.4g} m: shorten the way, or lengthen layout.span_length"
        )
    interval, count = sample_interval(drive), one_count(drive)
    wanted, reference = reference_of(believed, law, move, interval)
    made = made_law(drive, believed, law, move)
    wind, (strength, begin, stop) = np.zeros(len(reference)), move.gust
    wind[round(begin / interval) : round(stop / interval)] = strength
    loop = CarriageLoop(made, reference, wind, interval, SUBSTEPS, 0.0 if ideal_sensors else count)
    log = run_carriage(loop, plant or believed, np.random.default_rng(seed).uniform(-0.5, 0.5, 2))
    ended = len(log)
    why = f"a strand went slack, or the carriage left its span, at t = {ended * interval:.4g} s: raise "
    why += "cable.pretension, shorten the way, or take longer"
    return CarriageRun(
        law=law,
        time=np.asarray(interval * np.arange(ended), dtype=np.float64),
        wanted=wanted[:ended],
        payload=log[:, 8],
        carriage=log[:, 1],
        swing=log[:, 3],
        tensions=log[:, 9:12],
        force=log[:, 12],
        arrival=move.duration,
        incomplete=why if ended < len(reference) else None,
    )


def reference_of(
    transporter: Transporter, law: str, move: CarriageMove, interval: float
) -> tuple[Array, Array]:
    """What is wanted, shape (samples,), and what the law follows, (samples, 10), its shaper less."""
    middle, y = transporter.start + 0.5 * move.distance, move.sampled(interval, 6)
    if LAWS[law][1] == "flat":
        return y[0], flat_motion(transporter, y, interval)
    if LAWS[law][1] == "rigid":
        return y[0], rigid_motion(transporter, y)
    late = shaped(transporter, y, interval, middle)[1]
    if late >= move.duration:
        raise InputRefused(
            f"duration = {move.duration:.4g} s is not above {late:.4g} s, which the shaper takes: take longer"
        )
    sooner = replace(move, duration=move.duration - late, rest=move.rest + late).sampled(interval, 6)
    return y[0], rigid_motion(transporter, shaped(transporter, sooner, interval, middle)[0])


@lru_cache(maxsize=16)
def made_law(drive: Drive, transporter: Transporter, law: str, move: CarriageMove) -> ScheduledLaw:
    """Law and observer of a name over the way's positions."""
    ends = sorted((transporter.start, transporter.start + move.distance))
    positions = np.linspace(ends[0] - MARGIN, ends[1] + MARGIN, POSITIONS)
    made = scheduled_law(
        transporter,
        interval=sample_interval(drive),
        count=one_count(drive),
        limit=torque_limit(drive) / drive.drive_pulley.radius,
        positions=positions,
        frozen=0.5 * (ends[0] + ends[1]) if law == "frozen" else None,
    )
    if LAWS[law][0] != "PD on the motor":
        return made
    row, rate, whole = np.zeros(STATES), 2.0 * pi * PD_HZ, transporter.masses.sum()
    row[0], row[4] = whole * rate**2, 2.0 * whole * rate  # both poles of the rigid whole at 5 Hz
    return made._replace(feedback=np.tile(row, (POSITIONS, 1)))
