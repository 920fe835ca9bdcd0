"""`move_carriage`: a carriage with a hanging mass travels along its span under a law."""

from dataclasses import dataclass
from functools import lru_cache
from math import inf, isfinite, pi

import numpy as np

from cabledrive.control.load_schedule import ScheduledLaw
from cabledrive.control.transporter import (
    OBSERVED,
    STATES,
    TransporterTuning,
    flat_motion,
    rigid_motion,
    scheduled_law,
    shaped,
)
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import described, meaning
from cabledrive.reduction.transporter import Transporter, transporter_of
from cabledrive.rig.carriage.transporter_kernels import CarriageLoop, TransporterPlant, run_transporter
from cabledrive.rig.setting import sample_interval
from cabledrive.trajectories import Move, Trajectory

CARRIAGE, SWING, PAYLOAD, TENSIONS, FORCE, ESTIMATE = 1, 3, 8, 9, 12, 13
"""Columns of a log; eight states come first, three tensions stand from `TENSIONS` on."""


def run_carriage(loop: CarriageLoop, plant: Transporter, phases: Array) -> Array:
    """Run a plant under the law.

    ``phases``, shape (2,): of the encoders, in counts.
    Returns shape (samples, 23): 8 states, payload's place, 3 tensions, force of the motor, 10 estimates;
    fewer samples where a strand went slack or the carriage left its span.
    """
    log = np.zeros((len(loop.reference), ESTIMATE + OBSERVED))
    ended = run_transporter(loop, plant_of(plant), phases, np.zeros(8), log)
    return log[:ended]


def plant_of(transporter: Transporter) -> TransporterPlant:
    """The transporter as the compiled run takes it."""
    t = transporter
    return TransporterPlant(
        lengths=np.array([t.span_length, t.start, t.line_length]),
        cable=np.array([t.axial_rigidity, t.pretension / t.axial_rigidity, t.damping_time]),
        masses=t.masses,
        friction=np.array(
            [t.viscous, t.coulomb, t.offset, t.rail_friction, t.swing_damping * t.gravity / t.line_length]
        ),
        gravity=t.gravity,
    )


MARGIN = 0.05


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageMove:
    """What is asked of the transporter."""

    distance: float = meaning("way of the carriage [m]", 1.0)
    duration: float = meaning("of the move [s]", 2.5)
    rest: float = meaning("how long the run goes on at the end [s]", 3.0)
    payload_mass: float = meaning("of the hanging mass [kg]", 0.25)
    line_length: float = meaning("of the line on which it hangs [m]", 0.25)
    gust: tuple[float, float, float] = meaning(
        "force of the wind on the payload [N], its start and end [s]", (0.0, 1.0, 1.5)
    )

    def __post_init__(self) -> None:
        for name, unit in (("duration", "s"), ("rest", "s"), ("payload_mass", "kg"), ("line_length", "m")):
            value = getattr(self, name)
            if not isfinite(value) or value <= 0.0:
                raise InputRefused(f"{name} = {value:.4g} {unit} must be finite and above 0: give more")
        if not isfinite(self.distance) or self.distance == 0.0:
            raise InputRefused(f"distance = {self.distance:.4g} m must be finite and not 0: give a way to go")
        if not all(isfinite(value) for value in self.gust) or self.gust[1] > self.gust[2]:
            raise InputRefused(f"gust = {self.gust} must be a force, a start and a later end: mend it")


@described
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CarriageRun:
    """A run of the transporter."""

    law: str = meaning("its name")
    time: Array = meaning("(samples,) [s]")
    wanted: Array = meaning("(samples,): displacement asked for [m]")
    payload: Array = meaning("(samples,): true displacement of the hanging mass [m]")
    carriage: Array = meaning("(samples,): true displacement [m]")
    swing: Array = meaning("(samples,): angle of the line [rad]")
    tensions: Array = meaning("(samples, 3): of the strands [N]")
    force: Array = meaning("(samples,): of the motor at the rim [N]")
    arrival: float = meaning("when the motion is to be over [s]")
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


def force_limit(drive: Drive) -> float:
    """Largest force of the motor at the rim [N], infinite where the drive names no torque limit."""
    limit = drive.motor.torque_limit if drive.motor else None
    return inf if limit is None else limit / drive.drive_pulley.radius


LAWS = {
    "scheduled": ("by position", "flat"),
    "frozen": ("of the middle of the way", "flat"),
    "pd-flat": ("PD on the motor", "flat"),
    "pd": ("PD on the motor", "rigid"),
    "shaper": ("PD on the motor", "rigid, shaped"),
}
"""Feedback and feedforward of each law."""
PD_HZ = 5.0
ORDER = 13
POSITIONS = 12


def move_carriage(
    drive: Drive,
    law: str = "scheduled",
    *,
    move: CarriageMove | None = None,
    plant: Transporter | None = None,
    tuning: TransporterTuning | None = None,
    seed: int = 0,
    substeps: int = 5,
    ideal_sensors: bool = False,
) -> CarriageRun:
    """Carry a hanging mass along the span and look at what swings on.

    Parameters
    ----------
    drive : Drive
        As the law believes it to be: a loop with motor, encoders at both pulleys and one guided carriage.
    law : {"scheduled", "frozen", "pd-flat", "pd", "shaper"}
    move : CarriageMove, optional
        Default: 1 m in 2.5 s with 0.25 kg on a line of 0.25 m.
    plant : Transporter, optional
        As it is, where that differs.
    tuning : TransporterTuning, optional
    seed : int, default 0
        Of the encoders' phases.
    substeps : int, default 5
        Internal steps of the plant per sample.
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
    move = move or CarriageMove()
    if law not in LAWS:
        raise InputRefused(f"law = {law!r} is not known: take one of {', '.join(LAWS)}")
    believed = transporter_of(drive, payload_mass=move.payload_mass, line_length=move.line_length)
    end, length = believed.start + move.distance, believed.span_length
    if not MARGIN < min(believed.start, end) <= max(believed.start, end) < length - MARGIN:
        raise InputRefused(
            f"the carriage goes from {believed.start:.4g} m to {end:.4g} m, nearer than {MARGIN:g} m to "
            f"an end of its span of {length:.4g} m: shorten the way, or lengthen layout.span_length"
        )
    interval, count = sample_interval(drive), one_count(drive)
    wanted, reference = reference_of(believed, law, move, interval)
    made = made_law(believed, law, move, interval, count, force_limit(drive), tuning)
    wind, why = np.zeros(len(reference)), None
    strength, begin, stop = move.gust
    wind[round(begin / interval) : round(stop / interval)] = strength
    loop = CarriageLoop(made, reference, wind, interval, substeps, 0.0 if ideal_sensors else count)
    log = run_carriage(loop, plant or believed, np.random.default_rng(seed).uniform(-0.5, 0.5, 2))
    ended = len(log)
    if ended < len(reference):
        why = (
            f"a strand went slack, or the carriage left its span, at t = {ended * interval:.4g} s: raise "
            "cable.pretension, shorten the way, or take longer"
        )
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
        incomplete=why,
    )


def reference_of(
    transporter: Transporter, law: str, move: CarriageMove, interval: float
) -> tuple[Array, Array]:
    """What is wanted, shape (samples,), and what the law follows, (samples, 10), its shaper less."""
    samples = round((move.duration + move.rest) / interval)
    time = np.asarray(interval * np.arange(samples), dtype=np.float64)
    y, middle = way_of(move, move.duration)(time, 6), transporter.start + 0.5 * move.distance
    feedforward = LAWS[law][1]
    if feedforward == "flat":
        return y[0], flat_motion(transporter, y, interval)
    if feedforward == "rigid":
        return y[0], rigid_motion(transporter, y)
    late = shaped(transporter, y, interval, middle)[1]
    if late >= move.duration:
        raise InputRefused(
            f"duration = {move.duration:.4g} s is not above {late:.4g} s, which the shaper takes: take longer"
        )
    sooner = way_of(move, move.duration - late)(time, 6)
    return y[0], rigid_motion(transporter, shaped(transporter, sooner, interval, middle)[0])


def way_of(move: CarriageMove, duration: float) -> Trajectory:
    """A smooth way of the payload; ``duration`` [s]."""
    moves = (Move(start=0.0, duration=duration, distance=move.distance),)
    return Trajectory(moves=moves, duration=move.duration + move.rest, order=ORDER)


@lru_cache(maxsize=16)
def made_law(
    transporter: Transporter,
    law: str,
    move: CarriageMove,
    interval: float,
    count: float,
    limit: float,
    tuning: TransporterTuning | None = None,
) -> ScheduledLaw:
    """Law and observer of a name over the way's positions; ``interval`` [s], ``count`` [m], ``limit`` [N]."""
    ends = sorted((transporter.start, transporter.start + move.distance))
    positions = np.linspace(ends[0] - MARGIN, ends[1] + MARGIN, POSITIONS)
    made = scheduled_law(
        transporter,
        interval=interval,
        count=count,
        limit=limit,
        positions=positions,
        tuning=tuning,
        frozen=0.5 * (ends[0] + ends[1]) if law == "frozen" else None,
    )
    if LAWS[law][0] != "PD on the motor":
        return made
    row, rate = np.zeros(STATES), 2.0 * pi * PD_HZ  # both poles of the rigid whole at 5 Hz
    row[0], row[4] = transporter.masses.sum() * rate**2, 2.0 * transporter.masses.sum() * rate
    return made._replace(feedback=np.tile(row, (POSITIONS, 1)))
