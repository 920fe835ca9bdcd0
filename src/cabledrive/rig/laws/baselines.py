"""Laws to compare with, by name, and backstepping and model reference adaptation.

One number tunes each, the bandwidth; `cabledrive.rig.tuning` tunes them all by one rule.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import exp, pi, sqrt
from typing import Any

import numpy as np

from cabledrive.control import linear_laws
from cabledrive.control.backstepping import PRINTED_HZ, backstepping_numbers, chain_generator
from cabledrive.control.backstepping_recursion import gain_names
from cabledrive.control.darc import printed_bounds
from cabledrive.control.numbers import LawNumbers
from cabledrive.control.observers import QUIET
from cabledrive.control.reference import AT_ONCE, ReferenceNumbers, flat_output, reference_numbers
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain, natural_frequencies_of, state_space
from cabledrive.rig.laws.controllers import Controller, DesignSpec, law_shafts, load_count, own_filter

PD_HZ, PID_HZ, LQ_TORQUE = 5.0, 2.0, 0.2
INTEGRAL_TIMES = 3.0
LEAST_SHARE = 0.1
"""Of the torque that weighs as one count: what `hinf` works against where the motor has no friction."""
FEEDFORWARDS = {
    "damped": "damped inverse, friction by the reference",
    "undamped": "undamped inverse, friction by the reference",
    "rigid": "rigid, friction by the reference",
}


def inverse_of(
    spec: DesignSpec, chain: LumpedChain, taps: Sequence[tuple[float, float]] = AT_ONCE
) -> ReferenceNumbers:
    """The generator of a spec's feedforward along a chain: angles, speeds and torque."""
    if spec.feedforward not in FEEDFORWARDS:
        raise InputRefused(
            f"feedforward = {spec.feedforward!r} is not known: take one of {', '.join(FEEDFORWARDS)}"
        )
    rigid, damped = spec.feedforward == "rigid", spec.feedforward == "damped"
    flat = None if rigid else flat_output(chain, damped=damped)
    return linear_laws.feedforward_generator(chain, flat, spec.interval, taps)


def _made(
    spec: DesignSpec,
    name: str,
    law: LawNumbers,
    gains: dict[str, Any],
    taps: Sequence[tuple[float, float]] = AT_ONCE,
) -> Controller:
    """A linear law with the spec's feedforward; ``taps``: of an input shaper."""
    generator = inverse_of(spec, spec.chain, taps)
    return Controller(
        name=name,
        law=law,
        reference=spec.rows(generator),
        shafts=spec.shafts,
        gains=gains | {"feedforward": FEEDFORWARDS[spec.feedforward]},
        model=spec.number,
        generator=generator,
    )


def _hertz(spec: DesignSpec, default: float) -> float:
    hertz = default if spec.bandwidth is None else spec.bandwidth
    if not hertz > 0.0 or hertz == float("inf"):
        raise InputRefused(f"bandwidth = {hertz:.6g} Hz must be finite and above 0: give one in Hz")
    return hertz


def pd(spec: DesignSpec) -> Controller:
    """PD on the motor."""
    hertz = _hertz(spec, PD_HZ)
    return _made(spec, "pd", linear_laws.pd_law(spec.chain, hertz, spec.interval), {"bandwidth_hz": hertz})


def pid(spec: DesignSpec) -> Controller:
    """PID on the load with a notch at the lowest mode."""
    chain, hertz = spec.chain, _hertz(spec, PID_HZ)
    notch = float(natural_frequencies_of(chain)[0]) / (2.0 * pi)
    law = linear_laws.pid_law(chain, hertz, notch, spec.interval)
    return _made(spec, "pid", law, {"bandwidth_hz": hertz, "notch_hz": notch})


def lqg(spec: DesignSpec) -> Controller:
    """Linear-quadratic feedback; one count of error weighs as much as a torque."""
    chain, (count, torque, settings) = spec.chain, weights(spec)
    return _made(spec, "lqg", linear_laws.lq_law(chain, count, torque, spec.interval), settings)


def lqi(spec: DesignSpec) -> Controller:
    """Linear-quadratic feedback with an integral of the load's error."""
    chain, (count, torque, settings) = spec.chain, weights(spec)
    time = integral_time(chain, count, torque)
    law = linear_laws.lqi_law(chain, count, torque, time, spec.interval)
    return _made(spec, "lqi", law, settings | {"integral_time": time})


def cancelling(law: Callable[[DesignSpec], Controller], name: str, spec: DesignSpec) -> Controller:
    """A law, and the disturbance that the filter of the whole chain sees subtracted."""
    return replace(law(spec), name=name, tuning=replace(QUIET, cancels=True))


def hinf(spec: DesignSpec) -> Controller:
    """H-infinity feedback with an integral, against torques of the size of the motor's friction."""
    chain, (count, torque, settings) = spec.chain, weights(spec)
    time = integral_time(chain, count, torque)
    against = chain.coulomb[0] if chain.coulomb[0] > 0.0 else LEAST_SHARE * torque
    law = linear_laws.hinf_law(chain, count, torque, against, time, spec.interval)
    return _made(spec, "hinf", law, settings | {"integral_time": time, "disturbance_weight": against})


def l1(spec: DesignSpec) -> Controller:
    """Linear-quadratic feedback with L1 adaptation, whose low-pass has the bandwidth of the feedback."""
    chain, (count, torque, settings) = spec.chain, weights(spec)
    hertz = rigid_bandwidth(chain, count, torque)
    law = linear_laws.l1_law(chain, count, torque, hertz, spec.interval)
    return _made(spec, "l1", law, settings | {"low_pass_hz": hertz})


def rigid_bandwidth(chain: LumpedChain, error: float, torque: float) -> float:
    """Bandwidth of the rigid machine under a quadratic cost, torque weighed as J w^2 times the error [Hz]."""
    return sqrt(torque / (linear_laws.rigid_inertia(chain) * error)) / (2.0 * pi)


def weights(spec: DesignSpec, chain: LumpedChain | None = None) -> tuple[float, float, dict[str, Any]]:
    """Error [rad] and torque [N m] that weigh the same in the laws of a quadratic cost."""
    count, torque, settings = load_count(spec.drive), LQ_TORQUE, dict[str, Any]()
    if spec.bandwidth is not None:
        settings["bandwidth_hz"] = hertz = _hertz(spec, 0.0)
        inertia = linear_laws.rigid_inertia(chain or spec.chain)
        torque = inertia * (2.0 * pi * hertz) ** 2 * count  # by Bryson's rule
    return count, torque, {"error_weight_rad": count} | settings | {"torque_weight": torque}


def integral_time(chain: LumpedChain, error: float, torque: float) -> float:
    """Time of the integral of a law with a quadratic cost: a few times that of its rigid bandwidth [s]."""
    return INTEGRAL_TIMES * sqrt(linear_laws.rigid_inertia(chain) * error / torque)


def shaper(spec: DesignSpec) -> Controller:
    """PD on the motor along a reference through a zero-vibration shaper, which takes the place of an inverse.

    It comes half a period late, and the error is counted against the one that was asked for.
    """
    chain, hertz = spec.chain, _hertz(spec, PD_HZ)
    poles = np.linalg.eigvals(state_space(chain)[0])
    lowest = min(poles[poles.imag > 1e-6], key=abs)
    ratio = -lowest.real / abs(lowest)
    overshoot = exp(-pi * ratio / sqrt(1.0 - ratio**2))
    late = round(pi / lowest.imag / spec.interval)
    first = 1.0 / (1.0 + overshoot)
    taps = ((0.0, first), (late * spec.interval, overshoot * first))
    law = linear_laws.pd_law(chain, hertz, spec.interval)
    gains = {"bandwidth_hz": hertz, "shaper_hz": abs(lowest) / (2.0 * pi)}
    return _made(spec, "shaper", law, gains, taps)


BASELINES: dict[str, Callable[[DesignSpec], Controller]] = {
    "pd": pd,
    "pid": pid,
    "lqg": lqg,
    "lqi": lqi,
    "lqg-dob": partial(cancelling, lqg, "lqg-dob"),
    "hinf": hinf,
    "l1": l1,
    "dob": partial(cancelling, pd, "dob"),
    "shaper": shaper,
}


BACKSTEPPING = {3: (PRINTED_HZ, 1e-6), 4: (25.0, 1e-18)}
"""Bandwidth [Hz] and adaptation of a model's law."""


def backstepping(spec: DesignSpec, number: int = 3) -> Controller:
    """With unmatched uncertainty on Model 3, or on Model 4 with dampers and friction along the reference."""
    chain, (hertz, adaptation) = spec.model(number), BACKSTEPPING[number]
    hertz = hertz if spec.bandwidth is None else spec.bandwidth
    adaptation = adaptation if spec.adapt else 0.0
    law = backstepping_numbers(chain, hertz, adaptation, spec.interval)
    gains, whole = gain_names(law.matrix, law.rows[0]), number == 4
    generator = chain_generator(chain, spec.interval) if whole else reference_numbers(np.eye(5))
    return Controller(
        name="backstepping-6" if whole else "backstepping",
        law=law,
        reference=spec.rows(generator),
        shafts=law_shafts(number, spec.feedback),
        start=law.learning[0],
        gains={"bandwidth_hz": hertz, "adaptation": adaptation} | gains,
        model=number,
        damped=whole,
        filter_model=own_filter(number, spec.feedback),
        generator=generator,
    )


NAME = "mrac"
SLOWER = 0.1
"""Bandwidth of adaptation over that of the feedback."""


def reference_model(spec: DesignSpec) -> Controller:
    """Quadratic feedback whose closed loop is the reference model; the motor's four parameters adapt."""
    chain = spec.chain
    count, torque, settings = weights(spec)
    generator = linear_laws.reference_model_generator(chain, flat_output(chain), spec.interval)
    reference = spec.rows(generator)
    bounds = printed_bounds(chain, flexible_joint=chain.size == 3)
    # The offset of a motor acts against its torque's sign in the model: it is subtracted.
    low, high = bounds.low - bounds.nominal, bounds.high - bounds.nominal
    low[3], high[3] = -high[3], -low[3]
    base = linear_laws.lq_law(chain, count, torque, spec.interval)
    sizes = np.abs(reference[:, -4:]).max(axis=0)
    rate = SLOWER * 2.0 * pi * rigid_bandwidth(chain, count, torque) * float(spec.adapt)
    law = linear_laws.reference_model_law(base, low, high, sizes, rate)
    return Controller(
        name=NAME,
        law=law,
        reference=reference,
        shafts=spec.shafts,
        start=np.zeros(4),
        gains=settings
        | {"learns": ["inertia_motor", "viscous_friction", "coulomb_friction", "offset_torque"]},
        model=spec.number,
        generator=generator,
    )
