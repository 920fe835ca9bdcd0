"""A torque that is held from its sample on stands half a sample late, in each log half of its own."""

import numpy as np

from cabledrive.identification.logs.log import log_of
from cabledrive.identification.torque_timing import given_timing, with_torque_moved

RATES = (1000.0, 200.0)


def test_each_log_of_a_held_torque_is_moved_by_half_of_its_own_interval(measured):
    """A sine, whose phase tells the shift: 0.5 ms at 1 kHz and 2.5 ms at 200 Hz, read together."""
    logs = []
    for rate in RATES:
        time = np.arange(0.0, 4.0, 1.0 / rate)
        logs.append(log_of(time, {"torque": np.sin(2 * np.pi * 3.0 * time)}, {"torque": "N m"}))
    moved = with_torque_moved(logs, "torque", given_timing("held", max(log.interval for log in logs)))
    for rate, log in zip(RATES, moved, strict=True):
        inside = slice(int(rate), 3 * int(rate))
        turn = np.exp(-2j * np.pi * 3.0 * log.time[inside])
        phase = np.angle(log.channel("torque")[inside] @ turn) + 0.5 * np.pi
        late = -phase / (2 * np.pi * 3.0)
        measured(f"{rate:g} Hz: {1e3 * late:.3f} ms")
        assert abs(late - 0.5 / rate) < 2e-5
