"""Baselines by name: PD, PID, LQG, disturbance observer, input shaper, each with its feedforward told."""

from dataclasses import replace
from math import exp, pi, sqrt

import numpy as np

from cabledrive.control.flat_output import flat_output
from cabledrive.control.kalman import QUIET, KalmanTuning
from cabledrive.control.linear_laws import feedforward, lq_law, pd_law, pid_law
from cabledrive.control.numbers import LawNumbers
from cabledrive.control.reference import flat_reference
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain, natural_frequencies_of, state_space
from cabledrive.reduction.models import highest_model
from cabledrive.rig.controllers import Controller, Wish
from cabledrive.rig.fitting import fitted_encoders
from cabledrive.rig.loop_numbers import Array

PD_HZ, PID_HZ, LQ_TORQUE = 5.0, 2.0, 0.2
INVERSE, RIGID = "damped inverse, friction by the reference", "rigid"


def _shafts(chain: LumpedChain) -> tuple[str, ...]:
    return ("motor", "drive", "load") if chain.size == 3 else ("motor", "load")


def _made(
    wish: Wish,
    name: str,
    law: LawNumbers,
    gains: dict[str, object],
    *,
    tuning: KalmanTuning = QUIET,
    table: Array | None = None,
) -> Controller:
    number = highest_model(wish.drive)
    chain = wish.model(number)
    flat = flat_output(chain)
    if table is None:
        reference = flat_reference(flat, wish.wanted(2 * chain.size), wish.interval)
        table = feedforward(chain, flat, reference)
        gains = gains | {"feedforward": INVERSE}
    return Controller(
        name=name,
        law=law,
        reference=np.ascontiguousarray(table),
        shafts=_shafts(chain),
        start=np.zeros(0),
        tuning=tuning,
        gains=gains,
        model=number,
        damped=True,
    )


def _chain(wish: Wish) -> LumpedChain:
    return wish.model(highest_model(wish.drive))


def _hertz(wish: Wish, default: float) -> float:
    hertz = default if wish.bandwidth is None else wish.bandwidth
    if not hertz > 0.0 or hertz == float("inf"):
        raise InputRefused(f"bandwidth = {hertz:.6g} Hz must be finite and above 0: give one in Hz")
    return hertz


def pd(wish: Wish) -> Controller:
    """PD on the motor with the damped inverse as feedforward.

    Parameters
    ----------
    wish : Wish

    Returns
    -------
    Controller
    """
    hertz = _hertz(wish, PD_HZ)
    return _made(wish, "pd", pd_law(_chain(wish), hertz, wish.interval), {"bandwidth_hz": hertz})


def pid(wish: Wish) -> Controller:
    """PID on the load with a notch at the lowest mode.

    Parameters
    ----------
    wish : Wish

    Returns
    -------
    Controller
    """
    chain, hertz = _chain(wish), _hertz(wish, PID_HZ)
    notch = float(natural_frequencies_of(chain)[0]) / (2.0 * pi)
    law = pid_law(chain, hertz, notch, wish.interval)
    return _made(wish, "pid", law, {"bandwidth_hz": hertz, "notch_hz": notch})


def lqg(wish: Wish) -> Controller:
    """Linear-quadratic feedback; one count of error weighs as much as a torque.

    Parameters
    ----------
    wish : Wish

    Returns
    -------
    Controller

    Raises
    ------
    InputRefused
        If a bandwidth is asked for: its weights set it.
    """
    if wish.bandwidth is not None:
        raise InputRefused("bandwidth is not a setting of lqg, whose weights set it: leave --bandwidth out")
    count = fitted_encoders(wish.drive)["load"]
    law = lq_law(_chain(wish), count, LQ_TORQUE, wish.interval)
    return _made(wish, "lqg", law, {"error_weight_rad": count, "torque_weight": LQ_TORQUE})


def dob(wish: Wish) -> Controller:
    """PD on the motor, and the disturbance that the filter of the whole chain sees subtracted.

    A disturbance observer on a rigid model would cancel the cable's own torque as well.

    Parameters
    ----------
    wish : Wish

    Returns
    -------
    Controller
    """
    hertz = _hertz(wish, PD_HZ)
    law = pd_law(_chain(wish), hertz, wish.interval)
    return _made(wish, "dob", law, {"bandwidth_hz": hertz}, tuning=replace(QUIET, cancels=True))


def shaper(wish: Wish) -> Controller:
    """PD on the motor along a reference through a zero-vibration shaper, rigid feedforward.

    Its reference comes half a period late, and the error is counted against the one that was asked for.

    Parameters
    ----------
    wish : Wish

    Returns
    -------
    Controller
    """
    chain, hertz = _chain(wish), _hertz(wish, PD_HZ)
    poles = np.linalg.eigvals(state_space(chain)[0])
    lowest = min(poles[poles.imag > 1e-6], key=abs)
    ratio = -lowest.real / abs(lowest)
    overshoot = exp(-pi * ratio / sqrt(1.0 - ratio**2))
    late = round(pi / lowest.imag / wish.interval)
    y = wish.wanted(2)
    held = np.concatenate((np.zeros((3, late)), y[:, :-late]), axis=1)
    held[0, :late] = y[0, 0]
    shaped = (y + overshoot * held) / (1.0 + overshoot)
    speed = shaped[1]
    torque = sum(chain.inertias) * shaped[2] + chain.viscous[0] * speed - chain.offsets[0]
    torque = torque + chain.coulomb[0] * np.tanh(50.0 * speed)
    n = chain.size
    table = np.column_stack([shaped[0]] * n + [speed] * n + [torque])
    law = pd_law(chain, hertz, wish.interval)
    gains = {"bandwidth_hz": hertz, "shaper_hz": abs(lowest) / (2.0 * pi), "feedforward": RIGID}
    return _made(wish, "shaper", law, gains, table=table)


BASELINES = {"pd": pd, "pid": pid, "lqg": lqg, "dob": dob, "shaper": shaper}
