r"""Records of a log with motion that neither the input nor the motion before explains: a blow, a lost sample.

An output of large power is no fault: a sweep passes a resonance. Each record is judged by its innovations,
the part of the output that the past of input and output does not predict,

.. math:: e_k = y_k - \sum_{i=1}^{n} a_i y_{k-i} - \sum_{i=0}^{n} b_i u_{k-i},

with one set of coefficients for the whole log, at some samples per period of its fastest motion.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import zero_phase

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

ORDER = 10
SAMPLES_PER_PERIOD = 8.0
POWER = 0.999
"""Share of the power of the output below the frequency that counts as its fastest motion."""
ROUNDS = 5
FACTOR = 10.0
"""Power of the innovations, in medians over the records, below which no record is left out."""
DEVIATIONS = 5.0
LEAST_SHARE = 1e-9
"""Power of the innovations in that of the output that counts as none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """A record that was left out.

    Attributes
    ----------
    start, end : float
        [s], from the first sample of the log.
    reason : str
    """

    start: float
    end: float
    reason: str


def explained_records(
    input_: Array, output: Array, starts: NDArray[np.int64], length: int
) -> tuple[NDArray[np.bool_], Array]:
    """Records whose innovations are like those of the others.

    ``input_``, ``output``, shape (samples,); ``starts``, shape (records,): first sample of each; ``length``:
    samples of each.
    Returns ``keep``, shape (records,); ``excess``, shape (records,): power of the innovations in medians over
    the records.
    """
    step = min(_step(output), max(1, length // (2 * ORDER)))
    u, y = (_thinned(values, step) for values in (input_, output))
    if y.size < 6 * ORDER:
        return np.ones(starts.size, dtype=bool), np.ones(starts.size)
    keep = np.ones(starts.size, dtype=bool)
    excess = np.ones(starts.size)
    for _ in range(ROUNDS):
        used = np.zeros(y.size, dtype=bool)
        for start in starts[keep]:
            used[start // step : (start + length) // step] = True
        innovations = _innovations(u, y, used)
        power = np.array([np.mean(innovations[s // step : (s + length) // step] ** 2) for s in starts])
        power = np.maximum(power, LEAST_SHARE * float(np.var(y)))
        excess = power / np.median(power)
        spread = 1.4826 * float(np.median(np.abs(np.log(excess))))
        ordinary = np.log(excess) <= max(DEVIATIONS * spread, np.log(FACTOR))
        if (ordinary == keep).all() or ordinary.sum() < 2:
            break
        keep = ordinary
    return keep, excess


def ordinary_records(spectra: ComplexArray) -> NDArray[np.bool_]:
    """Repetitions whose power is not an outlier among the others.

    ``spectra``, shape (records, frequencies).
    Returns shape (records,): false where the logarithm of the mean power is farther than 5 scaled median
    deviations from the median.
    """
    power = np.log(np.maximum((np.abs(spectra) ** 2).mean(axis=1), 1e-300))
    off = np.abs(power - np.median(power))
    spread = 1.4826 * np.median(off)
    return off <= np.maximum(5.0 * spread, 0.5)


def _step(output: Array) -> int:
    """Samples between those that show the fastest motion of the output."""
    power = np.cumsum(np.abs(np.fft.rfft(output - output.mean())) ** 2)
    fastest = int(np.searchsorted(power, POWER * power[-1])) / output.size
    return max(1, int(1.0 / (SAMPLES_PER_PERIOD * max(fastest, 1.0 / output.size))))


def _thinned(values: Array, step: int) -> Array:
    """Every ``step``-th sample of what the thinner grid can show."""
    values = values - values.mean()
    return values if step == 1 else zero_phase(values, 1.0, 0.4 / step)[::step]


def _innovations(u: Array, y: Array, used: NDArray[np.bool_]) -> Array:
    """What one set of coefficients, fitted where it is used, leaves over everywhere."""
    rows = np.arange(ORDER, y.size)
    columns = [y[rows - k] for k in range(1, ORDER + 1)] + [u[rows - k] for k in range(ORDER + 1)]
    table = np.column_stack([*columns, np.ones(rows.size)])
    fitted = used[rows]
    coefficients = np.linalg.lstsq(table[fitted], y[rows[fitted]], rcond=1e-10)[0]
    return np.concatenate([np.zeros(ORDER), y[rows] - table @ coefficients])
