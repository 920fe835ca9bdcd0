"""Discretisation error of a run, estimated from the same run with a half and a quarter of its segments."""

from dataclasses import asdict, dataclass, replace
from math import log2
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.mesh import FEWEST_SEGMENTS
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.keeping import Records
from cabledrive.simulation.prepared import Outcome
from cabledrive.simulation.run import integrate_run
from cabledrive.simulation.start import Scheme

if TYPE_CHECKING:
    from cabledrive.simulation.case import RopeRun

ORDER_AT_LEAST, ORDER_AT_MOST = 0.5, 2.0
STILL = 1e-14
"""Size up to which a motion is rounding [m], [rad]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """Estimated error of one quantity over the run."""

    error: float  # largest estimated error, in the quantity's unit
    relative: float  # the same over the quantity's largest size [-]; 0 if it did not move
    order: float | None
    """Order of convergence between the three resolutions; None if the differences do not fall."""


def check_halves(scheme: Scheme) -> None:
    """Refuse a run that has too few segments to be halved twice."""
    if scheme.segments // 4 < FEWEST_SEGMENTS:
        raise InputRefused(
            f"segments = {scheme.segments}: an error estimate halves them twice and needs "
            f"{4 * FEWEST_SEGMENTS}: use more"
        )


def estimated_errors(case: "RopeRun", outcome: Outcome, columns: dict[str, int]) -> dict[str, Any] | None:
    r"""Discretisation error of some columns of the records by Richardson's extrapolation, where asked for.

    With the differences :math:`D_1 = |x_n - x_{n/2}|` and :math:`D_2 = |x_{n/2} - x_{n/4}|`, largest over the
    records, the order seen is :math:`p = \log_2(D_2/D_1)`, and the error of :math:`x_n` about
    :math:`D_1/(2^p - 1)`. The order is taken as at most 2 and at least 1/2, below which the runs do not
    converge yet.

    Returns segments of the runs compared, and the estimates by the names in ``columns``, as plain data.
    """
    if case.coarser is None or outcome.stopped is not None:
        return None
    counts = tuple(case.scheme.segments // n for n in (1, 2, 4))
    coarser = [case.coarser(replace(case.scheme, segments=n, step=None)) for n in counts[1:]]
    runs = [outcome.rows, *(integrate_run(own, Records(own)).rows for own in coarser)]
    whole = min(len(run) for run in runs)
    found = {name: _estimate(*(run[:whole, k] for run in runs)) for name, k in columns.items()}
    return {"segments": list(counts), **{name: asdict(one) for name, one in found.items()}}


def _estimate(fine: Array, middle: Array, coarse: Array) -> Estimate:
    first = float(np.max(np.abs(fine - middle), initial=0.0))
    second = float(np.max(np.abs(middle - coarse), initial=0.0))
    size = float(np.max(np.abs(fine), initial=0.0))
    seen = log2(second / first) if first > 0.0 and second > 0.0 else None
    order = min(max(seen or ORDER_AT_LEAST, ORDER_AT_LEAST), ORDER_AT_MOST)
    error = first / (2.0**order - 1.0)
    converges = seen is not None and seen > ORDER_AT_LEAST
    return Estimate(
        error=error, relative=error / size if size > STILL else 0.0, order=seen if converges else None
    )
