r"""An axis whose inertia depends on the pose of others: the first axis of a robot.

With the momentum :math:`p = J(q)\dot\theta` and :math:`J(q) = \sum_k J_k\,g_k(q)`,

.. math:: \tau = \sum_k J_k \frac{d}{dt}\big(g_k(q)\,\dot\theta\big) + b\dot\theta + c\,S(\dot\theta) - d .

For an arm whose links turn about parallel axes the :math:`g_k` are the sines and cosines of the sums of their
angles up to the second harmonic, since every link's distance from the first axis is a sum of first ones.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.axis_equation import AxisEquation, filtered
from cabledrive.identification.estimates import Identification
from cabledrive.identification.filters import difference
from cabledrive.identification.inverse_dynamics import Rows, factors_of, rows_of
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import solve, suited_segments
from cabledrive.identification.regression_result import regression_result
from cabledrive.identification.rigid_axis import (
    SHORT_SEGMENTS,
    AxisOptions,
    axis_method,
    channels_of,
    equation_for,
)

Array = NDArray[np.float64]

OPEN = 0.05
"""Share of the torque that a direction which the first log left open may make in a prediction."""


def pose_functions(angles: Sequence[Array]) -> list[Array]:
    """Functions of the pose that make up the inertia: 1, and harmonics of the links' directions.

    ``angles``, shape (samples,): of the joints after the first, each against the link before it [rad].
    Returns shape (samples,).
    """
    directions = list(np.cumsum(np.array(angles), axis=0))
    found = [np.ones_like(directions[0])]
    for d in directions:
        found += [np.cos(d), np.sin(d)]
    for a, b in combinations_with_replacement(directions, 2):
        found += [np.cos(a + b), np.sin(a + b)]
    return found


def solve_axis_problem(log: Log, others: Sequence[str], options: AxisOptions | None = None) -> Identification:
    """Friction and offset of an axis whose inertia depends on the pose of other axes.

    Parameters
    ----------
    log : Log
        Torque and angle of the axis, and the angles of the others.
    others : sequence of str
        Channels of the others' angles, from the first axis outwards.
    options : AxisOptions, optional

    Returns
    -------
    Identification
        "inertia" is the constant part, "inertia 1", ... the others; singly they may not be identifiable.
    """
    return axis_problem(log, others, options).identification


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AxisPrediction:
    """Torque that a model of an axis expects in a log, below the bandwidth of its filter.

    Attributes
    ----------
    time : ndarray, shape (rows,)
        [s]; without the ends, where the filter has not settled.
    torque : ndarray, shape (rows,)
        NaN where the log moves what the model was never shown.
    measured : ndarray, shape (rows,)
        The measured torque through the same filter.
    """

    time: Array
    torque: Array
    measured: Array

    @property
    def covered(self) -> float:
        """Share of the rows with a prediction."""
        return float(np.isfinite(self.torque).mean())

    @property
    def explained(self) -> float:
        """Share of the measured torque's power that the prediction explains, where there is one; 0: none."""
        return max(0.0, 1.0 - self.error**2) if self.covered > 0.0 else 0.0

    @property
    def error(self) -> float:
        """Root mean square of the difference over that of the measured torque, where it is predicted."""
        known = np.isfinite(self.torque)
        if not known.any():
            return float("nan")
        off = self.torque[known] - self.measured[known]
        return float(np.sqrt(np.mean(off**2) / np.mean(self.measured[known] ** 2)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AxisProblem:
    """An axis whose inertia depends on the pose, identified from one log.

    Attributes
    ----------
    identification : Identification
        Each parameter that the log identifies by itself, friction among them.
    others : tuple of str
    options : AxisOptions
    equation : AxisEquation
    values : ndarray, shape (p,)
        All parameters; along the directions that the log leaves open, the smallest.
    unidentifiable : ndarray, shape (directions, p)
        These directions, of length 1.
    """

    identification: Identification
    others: tuple[str, ...]
    options: AxisOptions
    equation: AxisEquation
    values: Array
    unidentifiable: Array

    def predict(self, log: Log) -> AxisPrediction:
        """Torque that the axis needs for the motion of another log.

        ``log``: with the same channels.
        Returns NaN where the motion excites a direction that the first log left open.
        """
        torque, position = channels_of(log, self.options)
        rows = problem_rows(log, torque, position, self.others, self.equation)
        expected = rows.regressors @ self.values
        open_ = np.linalg.norm(rows.regressors @ self.unidentifiable.T, axis=1) * np.linalg.norm(self.values)
        unknown = open_ > OPEN * float(np.sqrt(np.mean(expected**2)))
        return AxisPrediction(
            time=log.time[rows.keep], torque=np.where(unknown, np.nan, expected), measured=rows.left
        )


def axis_problem(log: Log, others: Sequence[str], options: AxisOptions | None = None) -> AxisProblem:
    """Identify an axis whose inertia depends on the pose of other axes, for `AxisProblem.predict`.

    ``log``: torque and angle of the axis, and the angles of the others; ``others``: channels of the others'
    angles, from the first axis outwards.
    """
    options = options or AxisOptions()
    torque, position = channels_of(log, options)
    equation = equation_for([log], torque, position, options)
    rows = problem_rows(log, torque, position, others, equation)
    factors = suited_segments(factors_of(rows, min(SHORT_SEGMENTS, rows.left.size // 40)))
    sizes = np.sqrt(np.mean(rows.regressors**2, axis=0))
    found = regression_result(
        factors, equation, sizes, axis_method(equation, options, factors), (), (log.report,)
    )
    fit = solve(factors)
    lengths = np.linalg.norm(fit.unidentifiable, axis=1, keepdims=True)
    return AxisProblem(
        identification=found,
        others=tuple(others),
        options=options,
        equation=equation,
        values=fit.values,
        unidentifiable=fit.unidentifiable / np.where(lengths > 0.0, lengths, 1.0),
    )


def problem_rows(log: Log, torque: str, position: str, others: Sequence[str], equation: AxisEquation) -> Rows:
    """Rows of the regression."""
    plain = rows_of(log.channel(position), log.channel(torque), equation, log.interval)
    smooth = [filtered(log.channel(name), equation, log.interval) for name in (position, *others)]
    speed = difference(smooth[0], log.interval)
    momenta = [difference(g * speed, log.interval)[plain.keep] for g in pose_functions(smooth[1:])]
    names = [equation.inertia, *(f"{equation.inertia} {k}" for k in range(1, len(momenta)))]
    return replace(
        plain,
        names=(*names, *plain.names[1:]),
        regressors=np.column_stack([*momenta, plain.regressors[:, 1:]]),
    )
