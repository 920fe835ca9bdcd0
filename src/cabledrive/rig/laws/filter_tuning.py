"""The Kalman filter of a law: its model, its encoders, its noise by what is not known; the damped law."""

import numpy as np

from cabledrive.control.observers import KalmanTuning
from cabledrive.reduction.lumped_chain import LumpedChain, highest_model
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.laws.controllers import Controller, DesignSpec, chain_law, own_filter
from cabledrive.rig.laws.fitting import fitted_encoders, law_shafts
from cabledrive.rig.plant_samples import Spreads


def damped_law(spec: DesignSpec, name: str, number: int = 4) -> Controller:
    """The damping-aware law of Model 3 or 4 (``number``); its filter by what is not known."""
    counts = np.array(list(read_encoders(spec, number).values()))
    tuning = tuning_by_uncertainty(spec, filter_chain(spec, number), counts)
    return chain_law(spec, number, name, damped=True, tuning=tuning)


def filter_chain(spec: DesignSpec, number: int) -> LumpedChain:
    """The chain that the Kalman filter of a law is made for.

    ``number``, {1, 2, 3, 4}: Model of the law.
    """
    return spec.model(own_filter(number, spec.feedback) or highest_model(spec.drive))


def read_encoders(spec: DesignSpec, number: int) -> dict[str, float]:
    """One count of each encoder that the filter of a law reads, at the first shaft [rad], by shaft.

    ``number``, {3, 4}.
    """
    fitted, shafts = fitted_encoders(spec.drive), law_shafts(number, spec.feedback)
    if own_filter(number, spec.feedback) is None:
        return fitted
    return {shaft: count for shaft, count in fitted.items() if shaft in shafts}


def tuning_by_uncertainty(spec: DesignSpec, chain: LumpedChain, counts: Array) -> KalmanTuning:
    """Noise of the filter from what is not known of the drive.

    The load's equation is off by the spreads of stiffness and inertia times the largest acceleration wanted,
    for a sixteenth of the rise; friction by the Coulomb torque, within a second as a walk and within a
    millisecond as noise; each encoder's zero by half a count, walking that far within some seconds.

    ``counts``, shape (m,) [rad].
    """
    spreads = Spreads()
    wanted = spec.wanted(2)
    moving = np.abs(wanted[1]) > 0.0
    rise = float(np.count_nonzero(moving)) * spec.interval / max(1, _moves(moving))
    off = (spreads.cable_stiffness + spreads.load_inertia) * float(np.abs(wanted[2]).max())
    coulomb = chain.coulomb[0]
    return KalmanTuning(
        torque=1e-3 * coulomb**2,
        disturbance=coulomb**2,
        load_acceleration=off**2 * rise / 16.0,
        offsets=tuple(float(count) ** 2 / 6.0 for count in counts[:-1]),
    )


def _moves(moving: Array) -> int:
    """How many times a motion sets out."""
    return int(np.count_nonzero(np.diff(moving.astype(int)) > 0)) + int(moving[0])
