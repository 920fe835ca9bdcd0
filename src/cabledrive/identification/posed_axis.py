r"""An axis whose inertia depends on the pose of others: the first axis of a robot.

With the momentum :math:`p = J(q)\dot\theta` and :math:`J(q) = \sum_k J_k\,g_k(q)`,

.. math:: \tau = \sum_k J_k \frac{d}{dt}\big(g_k(q)\,\dot\theta\big) + b\dot\theta + c\,S(\dot\theta) - d .

For an arm whose links turn about parallel axes the :math:`g_k` are the sines and cosines of the sums of their
angles up to the second harmonic, since every link's distance from the first axis is a sum of first ones.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.axis_equation import AxisEquation, filtered
from cabledrive.identification.conclusion import concluded
from cabledrive.identification.estimates import Identification
from cabledrive.identification.filters import difference
from cabledrive.identification.inverse_dynamics import Rows, factors_of, rows_of
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import suited_segments
from cabledrive.identification.rigid_axis import (
    SHORT_SEGMENTS,
    AxisOptions,
    axis_method,
    channels_of,
    equation_for,
)

Array = NDArray[np.float64]


def pose_functions(angles: Sequence[Array]) -> list[Array]:
    """Functions of the pose that make up the inertia: 1, and harmonics of the links' directions.

    Parameters
    ----------
    angles : sequence of ndarray, shape (samples,)
        Of the joints after the first, each against the link before it [rad].

    Returns
    -------
    list of ndarray, shape (samples,)
    """
    directions = list(np.cumsum(np.array(angles), axis=0))
    found = [np.ones_like(directions[0])]
    for d in directions:
        found += [np.cos(d), np.sin(d)]
    for a, b in combinations_with_replacement(directions, 2):
        found += [np.cos(a + b), np.sin(a + b)]
    return found


def identify_posed_axis(
    log: Log, others: Sequence[str], options: AxisOptions | None = None
) -> Identification:
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
    options = options or AxisOptions()
    torque, position = channels_of(log, options)
    equation = equation_for([log], torque, position, options)
    rows = posed_rows(log, torque, position, others, equation)
    factors = suited_segments(factors_of(rows, min(SHORT_SEGMENTS, rows.left.size // 40)))
    sizes = np.sqrt(np.mean(rows.regressors**2, axis=0))
    return concluded(factors, equation, sizes, axis_method(equation, options, factors), (), (log.report,))


def posed_rows(log: Log, torque: str, position: str, others: Sequence[str], equation: AxisEquation) -> Rows:
    """Rows of the regression.

    Parameters
    ----------
    log : Log
    torque, position : str
    others : sequence of str
    equation : AxisEquation

    Returns
    -------
    Rows
    """
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
