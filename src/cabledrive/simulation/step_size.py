r"""The largest stable step, and the grid of times a run takes.

Leapfrog is stable up to :math:`\omega_{max} \Delta t = 2` with the highest frequency of the chain. For a
uniform cable that is :math:`c_u \Delta t = \Delta x`, a CFL number of 1: Eq. (2.31) with the wave speed that
stands under (2.15).
"""

from dataclasses import dataclass
from math import ceil, isfinite, sqrt

import numpy as np

from cabledrive.mechanics.cable_law import CableLaw
from cabledrive.mechanics.mesh import Mesh
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.signals import Signal, Sine

MOST_STEPS = 10**12
MOST_NODE_STEPS = 1e14
"""Steps times nodes: about a week of one core."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeGrid:
    """Steps and records of a run."""

    step: float  # time step [s]
    largest_step: float  # largest stable step [s]
    every: int  # steps per record
    records: int  # recording intervals; the run ends with one more record

    @property
    def cfl(self) -> float:
        """Step over largest stable step, the CFL number of a uniform cable [-]."""
        return self.step / self.largest_step

    @property
    def steps(self) -> int:
        """Steps of the whole run."""
        return self.every * self.records

    @property
    def interval(self) -> float:
        """Time from record to record [s]."""
        return self.step * self.every


def largest_stable_step(mesh: Mesh, law: CableLaw) -> float:
    r"""Largest step for which leapfrog is stable, Eq. (2.31) at a CFL number of 1.

    The squares of the chain's frequencies are the eigenvalues of
    :math:`S^{1/2} D M^{-1} D^T S^{1/2}` over the springs (segments, motor joint, holding spring); the row
    sums of its moduli bound them from above, sharply for a uniform cable. A cable that may go slack is a
    chain of springs with a kink, on which leapfrog is resonantly unstable where the shortest period takes few
    steps: there a quarter of that, a dozen steps per shortest period.

    Returns step [s].
    """
    mobility = 1.0 / mesh.axial_mass
    for node, shaft in zip(mesh.rims, mesh.shafts, strict=False):
        mobility[node] *= 0.0 if shaft.fixed else 1.0
    if mesh.closed:
        mobility[-1] = mobility[0]
    root = np.sqrt(law.largest_stiffness() / mesh.spacing)
    before, after = np.roll(root, 1), np.roll(root, -1)
    if not mesh.closed:
        before[0] = after[-1] = 0.0
    joint, joint_mobility, square = 0.0, 0.0, mesh.shafts[0].radius ** 2
    on_rim, on_motor = sqrt(mesh.shafts[0].holding_stiffness / square), 0.0
    if mesh.joint is not None:
        joint, joint_mobility = sqrt(mesh.joint.stiffness / square), 1.0 / mesh.shafts[2].rim_mass
        on_motor = sqrt(mesh.shafts[2].holding_stiffness / square)
    before[0] += joint + on_rim
    if mesh.closed:
        after[-1] += joint + on_rim
    rows = root * ((root + before) * mobility[:-1] + (root + after) * mobility[1:])
    beside = root[0] + (root[-1] if mesh.closed else 0.0) + on_rim
    joint_row = joint * (joint * mobility[0] + beside * mobility[0] + (joint + on_motor) * joint_mobility)
    rim_row = on_rim * (beside + joint) * mobility[0]
    motor_row = on_motor * (joint + on_motor) * joint_mobility
    share = 0.25 if law.tension_only else 1.0
    return share * 2.0 / sqrt(max(float(np.max(rows)), joint_row, rim_row, motor_row))


def time_grid(
    duration: float, largest_step: float, *, step: float | None, cfl: float, rate: float, nodes: int = 1
) -> TimeGrid:
    """Steps and records of a run, the last record exactly at its end.

    ``duration``: length of the run [s]; ``largest_step``: largest stable step [s]; ``step``: step asked for
    [s]; ``cfl``: share of the largest step to take if none was asked for; ``rate``: least number of records
    per second [Hz]; ``nodes``: of the divided cable.
    Raises `InputRefused` if the run has no end, the step is not stable, or the run takes too many steps.
    """
    if not (isfinite(duration) and duration > 0.0):
        raise InputRefused(f"duration = {duration} s must be above 0 and finite: give the length of the run")
    if not (isfinite(rate) and rate > 0.0):
        raise InputRefused(f"rate = {rate} Hz must be above 0 and finite: give the records per second")
    if step is not None and step > largest_step * (1.0 + 1e-12):
        raise InputRefused(
            f"step = {step:.6g} s is not stable: at most {largest_step:.6g} s (CFL 1), or fewer segments"
        )
    wanted = min(cfl * largest_step if step is None else step, duration)
    most = min(MOST_STEPS, MOST_NODE_STEPS / nodes)
    if duration / wanted > most:
        raise InputRefused(
            f"duration = {duration:.6g} s takes {duration / wanted:.3g} steps of {wanted:.3g} s, at most "
            f"{most:.3g} are taken: shorten the run or use fewer segments"
        )
    records = max(1, ceil(duration * rate * (1.0 - 1e-12)))
    interval = duration / records
    every = max(1, ceil(interval / wanted * (1.0 - 1e-12)))
    return TimeGrid(step=interval / every, largest_step=largest_step, every=every, records=records)


def check_resolved(signal: Signal, step: float) -> None:
    """Refuse a sine that has less than two steps [s] per period."""
    if isinstance(signal, Sine) and abs(signal.frequency) * step > 0.5:
        raise InputRefused(
            f"frequency = {signal.frequency:.4g} Hz has less than two steps of {step:.3g} s per period: give "
            f"at most {0.5 / step:.4g} Hz, or a shorter step"
        )
