"""Which lines of a measured response take part in a fit."""

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.frequency_response import FrequencyResponse

HANN_LINES = 2
"""Neighbouring lines under a Hann window share their noise; lines this far apart hardly do."""


def selected(measured: FrequencyResponse, keep: NDArray[np.bool_]) -> FrequencyResponse:
    """Some lines of a response.

    ``keep``, shape (m,).
    """
    return FrequencyResponse(
        frequency=measured.frequency[keep],
        response=measured.response[keep],
        deviation=measured.deviation[keep],
        coherence=measured.coherence[keep],
        averages=measured.averages,
        left_out=measured.left_out,
    )


def independent_lines(measured: FrequencyResponse, least_coherence: float = 0.0) -> FrequencyResponse:
    """Lines of a response by Hann windows that hardly share their noise, so that a fit counts each once."""
    keep = np.arange(measured.frequency.size) % HANN_LINES == 0
    return selected(measured, keep & (measured.coherence > least_coherence))
