r"""Coulomb's law or a smooth one: two models that do not contain one another, compared segment by segment.

Both follow the log; the weighted squares of their residuals are summed in each segment of time. If the laws
were equally far from the truth, the mean of the differences :math:`d_b` would be zero, and

.. math:: t = \sqrt{G}\,\bar d / s_d

Student's t of G - 1 degrees of freedom: Q. H. Vuong, "Likelihood ratio tests for model selection and
non-nested hypotheses", Econometrica 57(2), 307-333, 1989.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.axis_case import case_of, simulated, weighed
from cabledrive.identification.axis_refinement import refine_rigid_axis
from cabledrive.identification.diagnosis import Suspicion, critical
from cabledrive.identification.estimates import Identification
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import MOST_SEGMENTS
from cabledrive.identification.rigid_axis import AxisOptions, channels_of, equation_for, identify_rigid_axis
from cabledrive.parameters import NotComputed

Array = NDArray[np.float64]


def other_law(
    logs: Sequence[Log], refined: Identification, options: AxisOptions, suspected: Sequence[Suspicion]
) -> Suspicion | None:
    """Evidence for the smooth law where Coulomb's was fitted, and the other way round.

    ``refined``: by output error, with Coulomb or smooth friction; ``options``: those it was found with;
    ``suspected``: what was found without it; they share the chance of a false alarm with this one.
    Returns of "slope" or "jump"; None where the other law gives no machine, or follows no better.
    """
    smooth = options.friction.kind == "coulomb"
    other = replace(options, friction=replace(options.friction, kind="tanh" if smooth else "coulomb"))
    try:
        found = identify_rigid_axis(logs, other)
        if (
            not found.identifiable
            or min(found["coulomb_friction"], found[next(iter(found.parameters))]) <= 0.0
        ):
            return None
        rival = refine_rigid_axis(logs, found, other)
    except NotComputed:
        return None
    squares = _squares(logs, [(refined, options), (rival, other)])
    difference = squares[0] - squares[1]
    if difference.sum() <= 0.0:
        return None
    count, gain = difference.size, float(difference.sum() / squares[0].sum())
    return Suspicion(
        fault="slope" if smooth else "jump",
        significance=float(np.sqrt(count) * difference.mean() / difference.std(ddof=1)),
        critical=critical(len(suspected) + 1, count - 1),
        gain=gain,
        family_gain=max(gain, *(s.family_gain for s in suspected)),
        value=options.friction.slope,
        from_law=True,
    )


def _squares(logs: Sequence[Log], rivals: Sequence[tuple[Identification, AxisOptions]]) -> Array:
    """Weighted squares of the residuals of each rival in segments of all logs, weights of the first."""
    sums: list[list[float]] = [[] for _ in rivals]
    weights: list[Array | None] = []
    for number, (found, options) in enumerate(rivals):
        torque, position = channels_of(logs[0], options)
        equation = equation_for(logs, torque, position, options)
        values = np.array([estimate.value for estimate in found.parameters.values()])
        cases = [case_of(log, torque, position, equation) for log in logs]
        if number == 0:
            weights = [c.weights for c in weighed(cases, values, np.array([c.start for c in cases]))]
        for case, weight in zip(cases, weights, strict=True):
            residual, slopes = simulated(replace(case, weights=weight), values, case.start)
            if case.lag:  # the instant of the torque is free under either law
                residual = residual - slopes[:, 5] * (slopes[:, 5] @ residual) / (slopes[:, 5] @ slopes[:, 5])
            count = max(6, MOST_SEGMENTS // len(logs))
            sums[number] += [float(part @ part) for part in np.array_split(residual, count)]
    return np.array(sums)
