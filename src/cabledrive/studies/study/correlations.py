r"""Correlations of the errors of numbers identified from one log.

An interval is the regression's 95 % and, on top, what cannot be distinguished from a number: other filters, a
residual that hides. Of the second part nobody knows how it goes together with that of another number; it is
taken as independent. The whole covariance is then the regression's and a diagonal, and with the half widths
:math:`h` of the regression's intervals and :math:`H` of the whole ones the correlation is

.. math:: \rho_{ij} = \frac{C_{ij}}{\sqrt{C_{ii}C_{jj}}}\,\frac{h_i}{H_i}\,\frac{h_j}{H_j}, \qquad i \ne j .
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.estimates import Identification
from cabledrive.identification.regression import Fit
from cabledrive.studies.study.machine import LOG, Quantity

Array = NDArray[np.float64]
Interval = tuple[float, float, float]
ROUNDING = 1e-9
"""Largest negative eigenvalue of a matrix of correlations that counts as rounding."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Correlation:
    """How two numbers of a log err together.

    Attributes
    ----------
    first, second : str
        Quantities, in the order of the alphabet.
    value : float
        From -1 to 1.
    """

    first: str
    second: str
    value: float


def of_intervals(fit: Fit, intervals: Mapping[str, Interval]) -> tuple[Correlation, ...]:
    """Correlations of what is identified from a whole drive's log.

    A cable's stiffness and damping come out over the load's inertia, whose whole error they share. Of what is
    their own they are independent, and so is the joint: twist and its rate are orthogonal over a record.

    ``fit``: the sum of torques; ``intervals``: value and bounds of what was identified.
    """
    common = _half_products(fit.covariance, fit.half_width())
    names = [name for name in fit.names if name in intervals]
    products = {
        (a, b): float(common[fit.names.index(a), fit.names.index(b)]) for a in names for b in names if a != b
    }
    whole = {name: 0.5 * (high - low) for name, (_, low, high) in intervals.items()}
    cable = [name for name in ("cable_stiffness", "cable_damping") if name in intervals]
    shares = {name: intervals[name][0] / intervals["load_inertia"][0] for name in cable}
    for name in cable:
        for other in names:
            along = products.get(("load_inertia", other), whole["load_inertia"] ** 2)
            products[name, other] = shares[name] * along
    if len(cable) == 2:
        products[cable[0], cable[1]] = shares[cable[0]] * shares[cable[1]] * whole["load_inertia"] ** 2
    return _over(products, whole)


def of_an_axis(
    found: Identification, parts: Mapping[str, float], known: Mapping[str, Quantity]
) -> tuple[Correlation, ...]:
    """Correlations of what is identified from a log of one rigid axis.

    ``found``: with an inertia; ``parts``: shares of the axis's inertia that its two parts are, by their
    names; ``known``: as identified from the log.
    """
    names = list(found.parameters)
    halves = np.array([0.5 * (e.high - e.low) for e in found.parameters.values()])
    common = _half_products(found.covariance, halves)
    weights = {name: (names.index("inertia"), part) for name, part in parts.items()}
    weights |= {name: (names.index(name), 1.0) for name in names if name in known}
    products = {
        (a, b): float(weights[a][1] * weights[b][1] * common[weights[a][0], weights[b][0]])
        for a in weights
        for b in weights
        if a != b
    }
    return _over(products, {name: known[name].half_width for name in weights})


def _half_products(covariance: Array, halves: Array) -> Array:
    """Correlation times both half widths; 0 where a number has no variance."""
    errors = np.sqrt(np.diag(covariance))
    scale = np.divide(halves, errors, out=np.zeros_like(errors), where=errors > 0.0)
    return np.asarray(covariance * np.outer(scale, scale), dtype=np.float64)


def _over(products: Mapping[tuple[str, str], float], whole: Mapping[str, float]) -> tuple[Correlation, ...]:
    found = {}
    for (a, b), product in products.items():
        if product != 0.0:
            found[min(a, b), max(a, b)] = product / (whole[a] * whole[b])
    return tuple(Correlation(first=a, second=b, value=found[a, b]) for a, b in sorted(found))


def among(correlations: Sequence[Correlation], quantities: Mapping[str, Quantity]) -> tuple[Correlation, ...]:
    """Those of two numbers that both stayed the log's."""
    from_log = {name for name, quantity in quantities.items() if quantity.source == LOG}
    return tuple(one for one in correlations if {one.first, one.second} <= from_log)


def root_of(correlations: Sequence[Correlation], names: Sequence[str]) -> Array:
    """Symmetric root of the matrix of correlations: it makes independent numbers correlated ones.

    ``names``: each quantity of a correlation among them.
    Returns shape (names, names).
    Raises `ValueError` if no numbers can be correlated so.
    """
    matrix = np.eye(len(names))
    for one in correlations:
        i, j = names.index(one.first), names.index(one.second)
        matrix[i, j] = matrix[j, i] = one.value
    sizes, directions = np.linalg.eigh(matrix)
    if sizes.size and sizes[0] < -ROUNDING:
        raise ValueError(f"smallest eigenvalue {sizes[0]:.3g} of the correlations is negative: mend them")
    return np.asarray(directions * np.sqrt(np.maximum(sizes, 0.0)) @ directions.T, dtype=np.float64)
