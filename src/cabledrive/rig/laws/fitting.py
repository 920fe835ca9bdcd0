"""Which inertia each encoder reads and each law takes, and one count of each as seen from the first shaft."""

from math import pi

import numpy as np

from cabledrive.control.load_schedule import LoadSchedule, scheduled_filter, with_load
from cabledrive.control.numbers import ObserverNumbers
from cabledrive.control.observers import (
    QUIET,
    KalmanTuning,
    Sampling,
    filtered_difference,
    ideal_states,
    kalman_filter,
)
from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.loop_numbers import Array, Integers
from cabledrive.rig.setting import RigOptions

SHAFTS = ("motor", "drive", "load")


def place(chain: LumpedChain, shaft: str) -> int:
    """Inertia of a chain that a shaft belongs to."""
    if shaft == "load":
        return chain.size - 1
    return chain.names.index(shaft) if shaft in chain.names else 0


def load_gear(drive: Drive) -> float:
    """Angle of the first shaft per angle of the load pulley, r2 / r1 [-]."""
    return drive.load_pulley.radius / drive.drive_pulley.radius


def fitted_encoders(drive: Drive) -> dict[str, float]:
    """One count of each encoder at the first shaft [rad], by shaft; the load's last, if there is one."""
    sensors = drive.sensors
    counts = {shaft: getattr(sensors, f"{shaft}_encoder") if sensors else None for shaft in SHAFTS}
    if not any(counts.values()):
        raise InputRefused("sensors has no encoder, nothing is measured: add motor_encoder, such as 10000")
    gears = {"motor": 1.0, "drive": 1.0, "load": load_gear(drive)}
    return {shaft: 2.0 * pi / number * gears[shaft] for shaft, number in counts.items() if number is not None}


def load_count(drive: Drive) -> float:
    """One count of the load's encoder, else of the one nearest to it, at the first shaft [rad]."""
    return list(fitted_encoders(drive).values())[-1]


def law_shafts(model: int, feedback: str) -> tuple[str, ...]:
    """Shafts whose angles a law of a model takes, from the motor to the load."""
    return {1: (feedback,), 2: ("motor", "drive"), 3: (feedback, "load"), 4: ("motor", "drive", "load")}[
        model
    ]


def fit_observer(
    design: LumpedChain,
    plant: LumpedChain,
    drive: Drive,
    shafts: tuple[str, ...],
    options: RigOptions,
    sampling: Sampling,
    tuning: KalmanTuning = QUIET,
    *,
    own: bool = False,
    settled: bool = False,
    schedule: LoadSchedule | None = None,
) -> tuple[ObserverNumbers, Integers, Array]:
    """Observer of a law, inertias that its encoders read, shape (m,), and their counts, shape (m,) [rad]."""
    fitted = fitted_encoders(drive)
    if own:
        fitted = {shaft: count for shaft, count in fitted.items() if shaft in shafts}
    read = np.array([place(plant, shaft) for shaft in fitted], dtype=np.int64)
    counts = np.array(list(fitted.values()))
    if options.ideal_sensors:
        chosen = [place(plant, shaft) for shaft in shafts]
        return ideal_states(plant.size, sampling.interval, chosen=chosen), read, np.zeros(len(counts))
    places = [place(design, shaft) for shaft in fitted]
    chosen = [place(design, shaft) for shaft in shafts]
    if options.observer == "difference":
        names = list(fitted)
        missing = [shaft for shaft in shafts if shaft not in fitted]
        if missing:
            raise InputRefused(
                f"sensors.{missing[0]}_encoder is missing, the difference needs it: add it, or take the "
                "Kalman filter"
            )
        numbers = [names.index(shaft) for shaft in shafts]
        return filtered_difference(range(len(names)), sampling.interval, chosen=numbers), read, counts

    def designed(chain: LumpedChain) -> ObserverNumbers:
        return kalman_filter(
            chain, places, list(counts), sampling, chosen=chosen, tuning=tuning,
            settled=settled or schedule is not None,
        )  # fmt: skip

    if schedule is None:
        return designed(design), read, counts
    filters = [designed(with_load(design, load)) for load in schedule.loads]
    return scheduled_filter(filters, schedule), read, counts
