r"""Tension of each span from a load cell that carries the load pulley, section 4.1.

The cell holds the pulley against both spans. Where a cable of mass :math:`\rho` per metre runs with speed v,
it takes momentum round the pulley: of each tension only :math:`T - \rho v^2` presses on it. The turning of
the load pulley gives the difference of both,

.. math:: F = (T_1 - \rho v^2) + (T_2 - \rho v^2) + W, \qquad
          r_2(T_2 - T_1) = J_2\ddot\theta_2 + b_2\dot\theta_2 + c_2 S(\dot\theta_2),

with the weight's part W along the line.
"""

from dataclasses import dataclass
from math import hypot, pi, sqrt

import numpy as np
from scipy import stats

from cabledrive.identification.logs.log import Log
from cabledrive.identification.logs.time_check import quantum_of
from cabledrive.identification.signals import difference, zero_phase
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array

BANDWIDTH = 40.0
"""Of force and angle by default [Hz]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SpanTensions:
    """Tension at the load pulley over time."""

    time: Array  # (samples,) [s]
    # upper, lower: (samples,) [N]
    upper: Array
    lower: Array
    deviation: float  # of each at one instant, from the noise of the cell and of the angle [N]
    # mean over the log with its 95 % bounds [N]; they cover what the log shows, not the cell's calibration
    mean_upper: tuple[float, float, float]
    mean_lower: tuple[float, float, float]
    findings: tuple[str, ...] = ()


def tensions_from_load_cell(
    log: Log,
    drive: Drive,
    *,
    force: str = "load_cell_force",
    angle: str = "load_angle",
    zero: float = 0.0,
    bandwidth: float = BANDWIDTH,
) -> SpanTensions:
    """Tension of the upper and the lower span from their combined pull on the load cell.

    Parameters
    ----------
    log : Log
    drive : Drive
        Loop whose load pulley leans against the cell.
    force, angle : str
        Channels of the cell [N] and of the load pulley [rad]; without the angle the pulley is taken to rest.
        The cell may be called "force" as well.
    zero : float, default 0.0
        What the cell says without cable: its zero and the weight's part [N].
    bandwidth : float, default 40.0
        Of the filter without phase on both channels [Hz].

    Returns
    -------
    SpanTensions

    Raises
    ------
    InputRefused
        If the drive is no loop, or the log lacks the force.
    """
    if drive.kind != "loop":
        raise InputRefused(f'{drive.name}: kind = "{drive.kind}" has one span: give a loop')
    bandwidth, h, pulley = min(bandwidth, 0.2 * log.sample_rate), log.interval, drive.load_pulley
    force = force if force in log.channels else "force"
    pull = zero_phase(log.channel(force), h, bandwidth) - zero
    findings, speed, turning, rounding = [], np.zeros(len(log)), np.zeros(len(log)), 0.0
    if angle in log.channels:
        speed = zero_phase(difference(log.channel(angle), h), h, bandwidth)
        friction = pulley.viscous_friction * speed + pulley.coulomb_friction * np.sign(speed)
        turning = pulley.inertia * difference(speed, h) + friction
        # The difference of tensions from the rounding of the angle, taken for white noise.
        density = quantum_of(log.channel(angle)) ** 2 / 12.0 * 2.0 * h
        rounding = pulley.inertia / pulley.radius * sqrt(density * (2 * pi) ** 4 * bandwidth**5 / 5.0)
    else:
        findings.append("no angle of the load pulley: assumed at rest, equal tensions in both spans")
    momentum = drive.cable.mass_per_length / (1.0 + drive.cable.prestrain) * (pulley.radius * speed) ** 2
    mean, half = 0.5 * pull + momentum, 0.5 * turning / pulley.radius
    edge = min(len(log) // 4, round(1.0 / (bandwidth * h)))
    part = slice(edge, len(log) - edge)
    upper, lower = (mean - half)[part], (mean + half)[part]
    if min(float(upper.min()), float(lower.min())) <= 0.0:
        findings.append("a tension falls to zero: a span goes slack, or the cell's zero is wrong")
    noise = log.channel(force) - zero - pull
    cell = float(noise[part].std()) * sqrt(2.0 * bandwidth * h)
    return SpanTensions(
        time=log.time[part],
        upper=upper,
        lower=lower,
        deviation=0.5 * hypot(cell, rounding),
        mean_upper=_mean(upper),
        mean_lower=_mean(lower),
        findings=tuple(findings),
    )


def _mean(values: Array, blocks: int = 20) -> tuple[float, float, float]:
    """Mean and its 95 % bounds from means of blocks, which forget one another."""
    means = np.array([part.mean() for part in np.array_split(values, blocks)])
    half = float(stats.t.ppf(0.975, blocks - 1) * means.std(ddof=1) / sqrt(blocks))
    return float(values.mean()), float(values.mean() - half), float(values.mean() + half)
