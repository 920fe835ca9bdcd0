"""Two inertias from logs that show both of them: parameters of the two equations of `two_sides`."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.estimates import Estimate, Finding, Identification
from cabledrive.identification.filters import difference
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import readable, unidentifiable_parameters
from cabledrive.identification.two_inertia_channels import TwoInertiaChannels, unit_of
from cabledrive.identification.two_sides import LOAD, SUM, Solution, TwoSides, load_equation, sum_equation
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]

NAMES = (
    "inertia_motor",
    "inertia_load",
    "stiffness",
    "damping",
    "viscous_friction_motor",
    "viscous_friction_load",
    "coulomb_friction_motor",
    "coulomb_friction_load",
    "offset",
)
FRICTIONS = NAMES[4:8]
FOLLOWS = 70.0
"""Share of the torque, and of the load's acceleration, that is explained where intervals are given [%]."""
STILL = 0.05
"""Share of its usual speed below which the sign of a speed is not trusted."""
GEAR = 1.3
"""Turns of the motor over those of the load from which a gear lies between: a spring makes them fewer."""


def identify_by_equations(logs: Sequence[Log], channels: TwoInertiaChannels) -> Identification:
    """Identify motor, load and the spring between them from logs that show both.

    Raises `InputRefused` if the load's channel is not at the motor's shaft, or too few samples can be used.
    """
    sides = [_sides(log, channels) for log in logs]
    load = load_equation(sides)
    torque, sides, lag = sum_equation(sides, load)
    values, errors, beyond, covariance = _parameters(torque, load)
    freedom = torque.fit.freedom if load is None else min(torque.fit.freedom, load.fit.freedom)
    halves = errors + beyond
    explained = [
        100.0 * (1.0 - one.fit.residual / one.fit.scale) for one in (torque, load) if one is not None
    ]
    findings = []
    follows = min(explained) >= FOLLOWS
    if not follows:
        what = "torque" if explained[0] < FOLLOWS else "load's acceleration"
        words = f"the model explains {min(explained):.3g} % of the {what}, less than {FOLLOWS:g} %"
        findings.append(Finding("model-misfit", f"{words}: no intervals are given"))
    closed = _undetermined(torque, load, values, halves)
    parameters = {}
    for name, value, half, error in zip(NAMES, values, halves, np.sqrt(np.diag(covariance)), strict=True):
        unit, low, high = unit_of(name, channels, logs[0]), value - half, value + half
        if name in closed:
            value, error, low, high = np.nan, np.inf, -np.inf, np.inf
        elif name in FRICTIONS and value < 0.0 < high:
            value, low = 0.0, 0.0
        elif name != "offset" and value < 0.0:
            words = f"{readable(name)} is identified as negative: check signs and units"
            findings.append(Finding("negative", words))
        if not follows:
            low, high = -np.inf, np.inf
        parameters[name] = Estimate(
            value=float(value),
            unit=unit,
            standard_error=float(error),
            low=float(low),
            high=float(high),
            reason="not identifiable from the log" if name in closed else "",
        )
    return Identification(
        model="two-inertia",
        parameters=parameters,
        identifiable=not closed,
        unidentifiable=tuple(f"{readable(name)} is not determined by the log" for name in closed),
        residual={
            "rms": torque.fit.residual,
            "relative": torque.fit.residual / torque.fit.scale,
            "rows": torque.fit.rows,
        },
        condition_number=torque.fit.condition,
        method={
            "name": "inverse-dynamics",
            "residual_of": channels.input,
            "input": channels.input,
            "measured": list(channels.outputs),
            "lag": lag,
            "bandwidths": [one.band for one in (torque, load) if one is not None],
            "explained_percent": explained,
        },
        covariance=covariance,
        freedom=freedom,
        findings=tuple(findings),
        notes=(
            f"the motion is {1e3 * lag:.3g} ms later than the {readable(channels.input)}: taken out",
            *channels.notes,
        ),
        checked=True,
        check_reason="shares explained, filters of other bandwidths",
        reports=tuple(log.report for log in logs),
    )


def _sides(log: Log, channels: TwoInertiaChannels) -> TwoSides:
    """Angles, or speeds where one of the two is a speed."""
    rates = any(name.endswith("velocity") for name in channels.outputs)
    motor, load = (
        difference(log.channel(name), log.interval)
        if rates and not name.endswith("velocity")
        else log.channel(name)
        for name in channels.outputs
    )
    one = TwoSides(
        source=log.source,
        interval=log.interval,
        torque=log.channel(channels.input),
        motor=motor,
        load=load,
        rates=rates,
        saturated=log.saturated.get(channels.input),
    )
    speeds = [one.quick(values, 10.0) for values in (motor, load)]
    turns = float(speeds[0] @ speeds[1] / (speeds[1] @ speeds[1]))
    if turns > GEAR:
        raise InputRefused(
            f"{log.source}: {channels.motor} moves {turns:.3g} times as far as {channels.load}: give both at "
            "one shaft, the load's times the gear ratio"
        )
    return replace(one, slow=STILL * float(np.sqrt(np.mean(speeds[0] ** 2))))


def _parameters(torque: Solution, load: Solution | None) -> tuple[Array, Array, Array, Array]:
    """Values, halves of the intervals by chance and beyond it, each of shape (9,), and their covariance.

    The two equations err independently; of a product both errors count.
    """
    s = dict(zip(SUM, range(len(SUM)), strict=True))
    split = len(SUM)
    u = dict(zip(LOAD, range(split, split + len(LOAD)), strict=True))
    p = np.concatenate([torque.fit.values, np.zeros(len(LOAD)) if load is None else load.fit.values])
    inertia = p[s["load_inertia"]]
    slopes = np.zeros((len(NAMES), p.size))
    values = np.zeros(len(NAMES))
    for k, name in ((0, "motor_inertia"), (1, "load_inertia"), (8, "offset")):
        values[k], slopes[k, s[name]] = p[s[name]], 1.0
    for k, name in ((2, "beta"), (3, "gamma"), (5, "viscous"), (7, "coulomb")):
        values[k] = inertia * p[u[name]]
        slopes[k, u[name]], slopes[k, s["load_inertia"]] = inertia, p[u[name]]
    for k, name in ((4, "viscous"), (6, "coulomb")):
        values[k] = p[s[name]] - values[k + 1]
        slopes[k] = -slopes[k + 1]
        slopes[k, s[name]] = 1.0
    whole = np.zeros((p.size, p.size))
    whole[:split, :split] = torque.fit.covariance
    student = torque.fit.half_width()[0] / float(np.sqrt(torque.fit.covariance[0, 0]) or 1.0)
    beyond = np.zeros(p.size)
    beyond[:split] = torque.beyond
    if load is not None:
        whole[split:, split:], beyond[split:] = load.fit.covariance, load.beyond
        student = max(student, load.fit.half_width()[0] / float(np.sqrt(load.fit.covariance[0, 0]) or 1.0))
    covariance = slopes @ whole @ slopes.T
    return values, student * np.sqrt(np.diag(covariance)), np.abs(slopes) @ beyond, covariance


def _undetermined(torque: Solution, load: Solution | None, values: Array, halves: Array) -> tuple[str, ...]:
    """Parameters without a row that shows them, and what is no larger than the half of its interval."""
    closed = {name for k, name in enumerate(NAMES[:3]) if not halves[k] < abs(values[k])}
    if load is None:
        closed |= {"stiffness", "damping", *FRICTIONS}
    if unidentifiable_parameters(torque.fit):
        closed |= {"inertia_motor", "inertia_load"}
    return tuple(name for name in NAMES if name in closed)
