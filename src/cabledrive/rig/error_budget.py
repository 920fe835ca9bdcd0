"""Error budget of a law: its error with one source after another removed, everything else as it is."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.rig.closed_loop.loop import Loop, close_loop, run
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY, Array
from cabledrive.rig.closed_loop.other_plants import with_plant
from cabledrive.rig.laws.registry import design
from cabledrive.rig.setting import DEGREE, Motion, RigOptions
from cabledrive.rig.trial import spec_for

FASTER = 4.0
FINE = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ErrorSource:
    """Peaks over encoder phases with one source removed.

    Attributes
    ----------
    away : str
        What was taken away.
    peaks, own_peaks : ndarray, shape (seeds,)
        Of the true angle, and against the load encoder's own zero [rad].
    """

    away: str
    peaks: Array
    own_peaks: Array


def error_sources(
    drive: Drive, name: str, motion: Motion, seeds: int, *, gains: str = "best"
) -> list[ErrorSource]:
    """Peaks of a law with nothing, then with one source after another removed.

    ``name``: of the law; ``seeds``: encoder phases to draw; the same for every source; ``gains``, {"best",
    "printed"}.
    """
    best = gains == "best"
    return [
        ErrorSource(away=away, **_peaks(loop, seeds)) for away, loop in _without(drive, name, motion, best)
    ]


def _without(drive: Drive, name: str, motion: Motion, best: bool) -> Iterator[tuple[str, Loop]]:
    base = _loop(drive, name, motion, RigOptions(), best)
    yield "nothing", base
    for j, shaft in enumerate(base.encoder_shafts):
        counts = base.rig.counts.copy()
        counts[j] *= FINE
        yield f"counts of the {shaft} encoder", replace(base, rig=base.rig._replace(counts=counts))
    fine = base.rig._replace(counts=FINE * base.rig.counts)
    yield "counts of every encoder", replace(base, rig=fine)
    yield "sticking, friction smoothed", with_plant(base, base.chain, RigOptions(smooth_friction=True))
    centred = RigOptions(encoder_phase="centred")
    yield "unknown encoder zeros", _loop(drive, name, motion, centred, best)
    assert drive.sensors is not None
    assert drive.sensors.sample_rate is not None
    sensors = replace(drive.sensors, sample_rate=FASTER * drive.sensors.sample_rate)
    faster = replace(drive, sensors=sensors)
    yield (
        f"three quarters of the sample time, {sensors.sample_rate:g} Hz",
        _loop(faster, name, motion, RigOptions(), best),
    )


def _loop(drive: Drive, name: str, motion: Motion, options: RigOptions, best: bool) -> Loop:
    made = design(name, spec_for(drive, motion, best=best))
    return close_loop(drive, drive, made, motion, options, np.random.default_rng(0))


def _peaks(loop: Loop, seeds: int) -> dict[str, Array]:
    places, found = [SUMMARY.index("peak"), SUMMARY.index("own_peak")], []
    known = not np.any(loop.rig.phases)
    for seed in range(seeds):
        phases = np.random.default_rng(seed).uniform(-0.5, 0.5, len(loop.rig.phases))
        one = loop if known else replace(loop, rig=loop.rig._replace(phases=phases))
        found.append(run(one, log=False).state.summary[places] / loop.gear)
    peaks = np.array(found)
    return {"peaks": peaks[:, 0], "own_peaks": peaks[:, 1]}


def in_degrees(source: ErrorSource) -> tuple[float, float, float]:
    """Median and worst peak, and the worst against the encoder's own zero [deg]."""
    return (
        float(np.median(source.peaks) / DEGREE),
        float(source.peaks.max() / DEGREE),
        float(source.own_peaks.max() / DEGREE),
    )
