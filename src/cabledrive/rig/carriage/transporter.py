"""`move_carriage`: a carriage with a hanging mass travels along its span under a law tabled over the way."""

from functools import lru_cache
from math import pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.schedule_kernels import ScheduledLaw
from cabledrive.control.transporter import (
    STATES,
    TransporterTuning,
    flat_motion,
    rigid_motion,
    scheduled_law,
    shaped,
)
from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.transporter import Transporter, transporter_of
from cabledrive.rig.carriage.carriage_loop import run_carriage
from cabledrive.rig.carriage.carriage_move import (
    MARGIN,
    CarriageMove,
    CarriageRun,
    check_way,
    force_limit,
    one_count,
)
from cabledrive.rig.carriage.transporter_kernels import CarriageLoop
from cabledrive.rig.setting import sample_interval
from cabledrive.trajectories import Move, Trajectory

Array = NDArray[np.float64]
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
    check_way(believed, move.distance)
    interval, count = sample_interval(drive), one_count(drive)
    wanted, reference = reference_of(believed, law, move, interval)
    made = made_law(believed, law, move, interval, count, force_limit(drive), tuning)
    actual = plant or believed
    phases = np.random.default_rng(seed).uniform(-0.5, 0.5, 2)
    wind, samples = np.zeros(len(reference)), len(reference)
    strength, start, end = move.gust
    wind[round(start / interval) : round(end / interval)] = strength
    loop = CarriageLoop(
        law=made,
        reference=reference,
        wind=wind,
        interval=interval,
        substeps=substeps,
        one_count=0.0 if ideal_sensors else count,
    )
    log, why = run_carriage(loop, actual, phases), None
    ended = len(log)
    if ended < samples:
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
    """What is wanted, and what the law follows; a shaped motion is as much shorter as its shaper is long.

    ``interval``: sample time [s].
    Returns ``wanted``, shape (samples,); ``reference``, shape (samples, 10).
    Raises `InputRefused` if the shaper takes longer than the motion.
    """
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
    """A smooth way of the payload.

    ``duration`` [s].
    """
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
    """Law and observer of a name, over the positions of the way.

    ``interval``: sample time [s]; ``count``: one count at the rim [m]; ``limit`` [N].
    """
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
    return made._replace(feedback=pd_feedback(transporter)) if law in ("pd", "pd-flat", "shaper") else made


def pd_feedback(transporter: Transporter) -> Array:
    """PD on the motor at every position: both poles of the rigid whole at 5 Hz.

    Returns shape (positions, 8).
    """
    row, rate = np.zeros(STATES), 2.0 * pi * PD_HZ
    row[0], row[4] = transporter.masses.sum() * rate**2, 2.0 * transporter.masses.sum() * rate
    return np.tile(row, (POSITIONS, 1))
