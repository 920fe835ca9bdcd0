"""The filters do what chapter 4 says of them."""

import numpy as np
import pytest

from cabledrive.identification import filters

DT = 1e-3
T = DT * np.arange(6000)


@pytest.mark.parametrize("frequency", [1.0, 5.0, 20.0, 60.0])
def test_the_causal_filter_has_the_response_of_4_1(frequency):
    """Gain and phase of (4.1) at zeta = 1, and s, s^2 times that, once the start has died away."""
    w, wf = 2 * np.pi * frequency, 2 * np.pi * 20.0
    found = filters.causal_filter(np.cos(w * T), DT, 20.0)
    h = wf**2 / (wf**2 - w**2 + 2j * wf * w)
    inner = T > 1.0
    for k in range(3):
        exact = np.real(h * (1j * w) ** k * np.exp(1j * w * T))
        # Straight lines between samples differ from a cosine by (w dt)^2 / 12 in the mean.
        size = abs(h) * max(w, wf) ** k
        np.testing.assert_allclose(found[k][inner], exact[inner], atol=0.2 * (w * DT) ** 2 * size)


def test_the_bandwidth_is_where_the_motion_meets_the_rounding_of_the_encoder():
    quantum = 2 * np.pi / 2600
    rng = np.random.default_rng(3)
    lines = [np.sin(2 * np.pi * f * T + rng.uniform(0, 6)) for f in (1, 3, 7.3)]
    angle = quantum * np.floor(0.3 * sum(lines) / quantum)
    assert 7.3 <= filters.chosen_bandwidth(angle, DT) <= 10.0
