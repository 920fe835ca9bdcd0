"""What the coherence of a measured response says of it, in words."""

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.frequency_response import FrequencyResponse

Array = NDArray[np.float64]

LOW = 0.8
"""Coherence below which a response is mostly not that of its input."""
TAIL = 0.025
"""Share of the input's power on either side of the band in which it is judged."""


def driven_band(input_: Array, interval: float) -> tuple[float, float]:
    """Band that holds all of a signal's power but its tails [Hz]; its mean counts for nothing.

    ``input_``, shape (samples,); ``interval`` [s].
    """
    power = np.abs(np.fft.rfft((input_ - input_.mean()) * np.hanning(input_.size))) ** 2
    total = np.cumsum(power)
    ends = np.searchsorted(total, [TAIL * total[-1], (1.0 - TAIL) * total[-1]])
    low, high = np.fft.rfftfreq(input_.size, interval)[np.minimum(ends, power.size - 1)]
    return float(low), float(high)


def coherence_words(found: FrequencyResponse, input_: Array, interval: float) -> tuple[str, list[str]]:
    """The coherence in the band that the input drives, and a warning where it is low.

    ``input_``, shape (samples,); ``interval`` [s].
    """
    low, high = driven_band(input_, interval)
    inside = (found.frequency >= low) & (found.frequency <= high)
    if not inside.any():
        distance = np.abs(found.frequency - 0.5 * (low + high))
        inside = distance == distance.min()
    values = found.coherence[inside]
    middle, worst = float(np.median(values)), int(np.argmin(values))
    words = (
        f"coherence {middle:.2f} (median, {low:.3g} to {high:.3g} Hz, where the input has its power), lowest "
        f"{values[worst]:.2f} at {found.frequency[inside][worst]:.4g} Hz"
    )
    if middle >= LOW:
        return words, []
    warning = (
        f"coherence {middle:.2f} is below {LOW:g}: most of the output is noise, not linear, or not of this "
        "input; check the columns, excite more strongly"
    )
    return f"{words}\nwarning: {warning}", [warning]
