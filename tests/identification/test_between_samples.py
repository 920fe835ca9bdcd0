"""A polygon through logged torques: what its corners must be for the sine that acted."""

import numpy as np
import pytest

from cabledrive.identification.axis_case import CORNER, CORNER_DOUBT, between_samples

RATE, FREQUENCY, FINE = 1000.0, 20.0, 64
SIZE = 1000


def fundamental(values, interval):
    """Of a whole number of periods: its complex amplitude."""
    t = interval * np.arange(values.size)
    return 2.0 * np.mean(values * np.exp(-2j * np.pi * FREQUENCY * t))


def logged_and_acting(channel):
    """A log of a torque, periodic beyond both ends, and the torque on a grid 64 times finer."""
    fine = np.arange(SIZE * FINE) / (RATE * FINE)
    smooth = np.sin(2 * np.pi * FREQUENCY * fine)
    acting = np.repeat(smooth[::FINE], FINE) if channel == "mean of steps" else smooth
    if channel == "point":
        return acting[::FINE], acting
    around = np.roll(acting, FINE // 2).reshape(SIZE, FINE)  # centred on each stamp
    return around.mean(axis=1), acting


@pytest.mark.parametrize("channel, share", [("point", 4), ("mean", 6), ("mean of steps", 8)])
def test_each_kind_of_channel_has_its_share_of_the_second_difference(channel, share):
    """Left are (w T)^4 and a grid of 64: far below the (w T)^2/48 that one share more or less makes."""
    logged, acting = logged_and_acting(channel)
    corners = between_samples(np.concatenate([logged[-1:], logged, logged[:2]]), share / 48)[1:-1]
    polygon = np.interp(np.arange(SIZE * FINE) / FINE, np.arange(SIZE + 1), corners)
    lost = fundamental(polygon, 1 / (RATE * FINE)) / fundamental(acting, 1 / (RATE * FINE)) - 1.0
    unit = (2 * np.pi * FREQUENCY / RATE) ** 2 / 48
    assert abs(lost.real) < 0.1 * unit, f"observed {lost.real / unit:.3f} of a share"
    assert abs(share / 48 - CORNER) < CORNER_DOUBT + 1e-12
