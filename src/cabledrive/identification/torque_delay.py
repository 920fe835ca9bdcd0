"""How late the torque channel is: moved back until no delay is left.

The first figure holds to first order, while the delay is short against the fastest line. Moved back by it,
and fitted anew, the log shows how much is left.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from cabledrive.identification.logs.log import Log
from cabledrive.identification.rigid_axis import AxisOptions, channels_of
from cabledrive.parameters import NotComputed

ROUNDS = 12


def moved_back(log: Log, channel: str, samples: int) -> Log:
    """A log with one channel earlier by whole samples; what has no partner at either end is left out.

    ``samples``: later where negative.
    """
    size = len(log) - abs(samples)
    own, others = max(samples, 0), max(-samples, 0)
    kept = log.part(float(log.time[others]), float(log.time[others + size - 1]) + log.interval)
    moved = {**kept.channels, channel: log.channels[channel][own : own + size]}
    return replace(kept, channels=moved)


def torque_delay(
    logs: Sequence[Log], options: AxisOptions, first: float, left_in: Callable[[Sequence[Log]], float]
) -> float:
    """Delay of the torque channel against the motion.

    ``first``: its estimate from the logs as they are, to first order [s]; ``left_in``: the same of logs whose
    channel was moved back: what is left [s].
    Returns [s]; to a share of a sample where the torque between samples allows it.
    Raises `NotComputed` if it does not come to an end: the lag is no delay.
    """
    torque, _ = channels_of(logs[0], options)
    interval, samples, left = logs[0].interval, 0, first
    for _ in range(ROUNDS):
        step = round(left / interval)
        if step == 0:
            return samples * interval + left
        samples += step
        if abs(samples) > min(len(log) for log in logs) // 4:
            break
        left = left_in([moved_back(log, torque, samples) for log in logs])
    raise NotComputed(f"moved back by {samples * interval:.3g} s the torque channel still lags")
