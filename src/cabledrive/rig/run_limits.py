"""How long a run of the rig may be: by the memory of its record and by the time that its draws take."""

from math import isfinite, sqrt
from typing import TYPE_CHECKING

from cabledrive.parameters import Drive, InputRefused
from cabledrive.rig.setting import Motion, RigOptions, sample_interval

if TYPE_CHECKING:
    from cabledrive.rig.bench.experiment import Excitation

MOST_MEMORY = 4e9
"""Of the record of one run [bytes]."""
BYTES_PER_SAMPLE = 600.0
"""States, readings, estimates, reference and bound of one sample, measured at the process."""
MOST_LOG_MEMORY, BYTES_PER_ROW = 8e9, 350.0
"""Of the log of an experiment while it is written, an hour at 5 kHz and a little more [bytes]."""
MOST_TRIED_SAMPLES = 1e10
"""Of all draws of a random multisine together: about a quarter of an hour of one core."""
MOST_DRAWS = 100_000
MOST_DRAWN_SAMPLES = 1e11
"""Of all draws together: about a day of one core."""
MOST_SEGMENT_STEPS = 1e13
"""Steps times segments of the cable as plant: about a day of one core."""
MOST_JITTER = 0.4
"""Standard deviation of the sample times, in samples: later samples would change places."""


def check_run(
    drive: Drive, motion: Motion, options: RigOptions, *, draws: int = 0, cable: bool = False
) -> None:
    """Refuse a run of the rig with ``draws`` more plants that would not end, or not fit into memory.

    Refused, too: a disturbance after the end of the motion.
    """
    if not isfinite(motion.angle):
        raise InputRefused(f"angle = {motion.angle:.4g} deg must be finite: give one in deg")
    duration = motion.trajectory.duration
    samples = duration / sample_interval(drive)
    check_record(duration, samples)
    _check_draws(draws, samples)
    _check_times(options, duration)
    _check_sampling(drive, options, duration)
    if cable:
        _check_segments(drive, options.segments, duration)


def check_record(duration: float, samples: float) -> None:
    """Refuse a record of a motion of some length [s] that would take more than `MOST_MEMORY`."""
    size = BYTES_PER_SAMPLE * samples
    if size > MOST_MEMORY:
        longest = duration * MOST_MEMORY / size
        raise InputRefused(
            f"a motion of {duration:.4g} s takes {samples:.3g} samples and {size / 1e9:.3g} GB; "
            f"at most {MOST_MEMORY / 1e9:.0f} GB are used, {longest:.4g} s: shorten rise, dwell or pulses"
        )


def _check_draws(draws: int, samples: float) -> None:
    most = min(MOST_DRAWS, int(MOST_DRAWN_SAMPLES / max(samples, 1.0)))
    if draws > most:
        raise InputRefused(f"draws = {draws} are more than the {most} that this motion allows: ask for fewer")


def _check_times(options: RigOptions, duration: float) -> None:
    starts = [(f"disturbance on the {step.on}", step.start) for step in options.disturbances]
    if options.blind is not None:
        starts.append((f"dropout of the {options.blind[0]} encoder", options.blind[1]))
    for what, start in starts:
        if start >= duration:
            raise InputRefused(
                f"{what}: starts at {start:.4g} s, the motion ends at {duration:.4g} s: start earlier"
            )


def _check_sampling(drive: Drive, options: RigOptions, duration: float) -> None:
    interval = sample_interval(drive)
    if options.jitter > MOST_JITTER * interval:
        raise InputRefused(
            f"jitter = {options.jitter:.4g} s is above {MOST_JITTER:g} of the sample time {interval:.4g} s: "
            f"give at most {MOST_JITTER * interval:.4g} s"
        )
    delay = drive.sensors.delay if drive.sensors is not None else 0.0
    if delay >= duration:
        raise InputRefused(
            f"sensors.delay = {delay:.4g} s is not below the {duration:.4g} s of the motion, in which no "
            "torque would act: shorten the delay"
        )


def _check_segments(drive: Drive, segments: int, duration: float) -> None:
    """By the steps that a wave along the cable asks for."""
    per_second = drive.cable.axial_wave_speed / drive.pulley_distance
    most = int(sqrt(MOST_SEGMENT_STEPS / (2.0 * duration * per_second)))
    if segments > most:
        raise InputRefused(
            f"segments = {segments} are more than the {most} per span that a motion of {duration:.4g} s "
            "allows: take fewer, or shorten the motion"
        )


def check_excitation(drive: Drive, excitation: "Excitation") -> None:
    """Refuse an experiment whose log does not fit into memory, or whose command the samples cannot carry.

    Raises `InputRefused` if the log is too long, a frequency is not between 0 and half the sample rate, or a
    period is not one.
    """
    e, rate = excitation, 1.0 / sample_interval(drive)
    size = BYTES_PER_ROW * e.duration * rate
    if size > MOST_LOG_MEMORY:
        raise InputRefused(
            f"duration = {e.duration:.4g} s at {rate:.6g} Hz takes {size / 1e9:.3g} GB: at most "
            f"{MOST_LOG_MEMORY / 1e9:.0f} GB are used, {e.duration * MOST_LOG_MEMORY / size:.4g} s: shorten "
            "it, or lower sensors.sample_rate"
        )
    used = {"sines": ("frequencies", e.frequencies), "chirp": ("band", e.band)}.get(e.kind)
    if used is not None and not all(0.0 < f < 0.5 * rate for f in used[1]):
        wrong = next(f for f in used[1] if not 0.0 < f < 0.5 * rate)
        raise InputRefused(
            f"{used[0]}: {wrong:.6g} Hz must lie above 0 and below {0.5 * rate:.6g} Hz, half the sample rate"
        )
    if e.kind == "chirp" and e.band[0] == e.band[1]:
        raise InputRefused(
            f"band: both ends are {e.band[0]:.6g} Hz: give two frequencies, or one of kind sines"
        )
    if e.kind not in ("sines", "chirp"):
        _check_period(e, rate)


def _check_period(e: "Excitation", rate: float) -> None:
    samples = e.period * rate
    if e.kind == "steps":
        if samples < 2.0:
            raise InputRefused(
                f"period = {e.period:.4g} s holds {samples:.2g} samples: lengthen it to 2 or more"
            )
        return
    most = MOST_LOG_MEMORY / BYTES_PER_ROW
    if samples > most:
        raise InputRefused(
            f"period = {e.period:.4g} s is above {most / rate:.4g} s at {rate:.6g} Hz: shorten it"
        )
    if e.kind == "idinput" and e.trials * samples > MOST_TRIED_SAMPLES:
        most = int(MOST_TRIED_SAMPLES / samples)
        raise InputRefused(
            f"trials = {e.trials} are more than the {most} that this period allows: lower them"
        )
