"""Tension of a span from its ping: the tones of the plucked span against its certified modes."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension.answers import PingTension, SpanTension
from cabledrive.identification.tension.pinged_string import PingedString, tension_of_string, widened
from cabledrive.mechanics.spans import transverse_chains
from cabledrive.modal.tuning import section_frequencies
from cabledrive.parameters import Drive, InputRefused, NotComputed

Array = NDArray[np.float64]

TEETH = 16
"""Modes of a span that a peak may belong to."""


def tension_from_ping(
    log: Log,
    drive: Drive,
    *,
    span: str | None = None,
    channel: str | None = None,
    section: int = 0,
    length_error: float = 0.0,
    density_error: float = 0.0,
) -> PingTension:
    """Tension of each span from a recording of its ping.

    A camera or a microphone hears the span itself; an encoder, a torque or a load cell feels its stretch,
    which has twice the frequency. Frequencies are taken at vanishing amplitude where the ping decays.

    Parameters
    ----------
    log : Log
        From `read_ping`, or any other.
    drive : Drive
        Its pretension serves as a first guess, good to a factor of four.
    span : {"upper", "lower"}, optional
        Default: as the channels are called ("upper position"), else the upper one.
    channel : str, optional
        Default: every position, velocity, acceleration or sound; else the load angle or angle.
    section : int, default 0
        Which section of the span was plucked, where guided carriages part it.
    length_error, density_error : float, default 0.0
        Relative standard errors of the file's length and mass per length; the interval grows by them.

    Returns
    -------
    PingTension

    Raises
    ------
    InputRefused
        If channel, span or section are not there.
    NotComputed
        If no tone is found, or the recording has no onset and decay as a ping has.
    """
    chosen = [channel] if channel is not None else channels_of(log)
    found: dict[str, SpanTension] = {}
    for name in chosen:
        log.channel(name)
        which = span or (name.split("_")[0] if name.split("_")[0] in drive.spans else "upper")
        if which not in drive.spans:
            raise InputRefused(f'span "{which}": {drive.name} has {", ".join(drive.spans)}: choose one')
        one = tension_of_string(log, _string(drive, which, section), name)
        extra = sqrt((2.0 * length_error) ** 2 + density_error**2) * one.tension.value
        found[which] = replace(one, tension=widened(one.tension, extra))
    return PingTension(spans=found, report=log.report, drive=drive.name)


def channels_of(log: Log) -> list[str]:
    """Channels of a recording that can contain a ping, the direct ones first."""
    swings = [c for c in log.channels if c.rpartition("_")[2] in ("position", "velocity", "acceleration")]
    direct = [c for c in swings if "along" not in c.split("_")]  # of a camera: across the cable
    direct = direct or [c for c in log.channels if c == "sound"]
    if direct:
        return direct
    for name in ("load_angle", "angle", "drive_angle", "tension", "force"):
        if name in log.channels:
            return [name]
    raise InputRefused(
        f"{log.source}: no channel that can contain a ping (has {', '.join(log.channels)}): name one"
    )


def _string(drive: Drive, span: str, section: int) -> PingedString:
    """A section of a span of a loop or a line as its ping is read."""
    return PingedString(
        drive=drive,
        span=span,
        modes=section_modes(drive, span, section),
        tension_for=lambda number, hertz: tension_for(drive, span, number, hertz, section),
        bare=lambda hertz: 4.0 * drive.cable.mass_per_length * (drive.span_length * hertz) ** 2,
        remedy="does the other span vibrate? Damp it, or identify both (--span both)",
    )


def section_modes(drive: Drive, span: str, section: int, numbers: int = TEETH) -> Array:
    """First frequencies of a section of a span, shape (numbers,) [Hz]."""
    chains = [chain for chain in transverse_chains(drive) if chain.stretches[0].span == span]
    if not 0 <= section < len(chains):
        raise InputRefused(f"section {section}: the {span} span has {len(chains)}: count from 0")
    return np.array(section_frequencies(chains[section], numbers)) / (2 * pi)


def tension_for(drive: Drive, span: str, number: int, frequency: float, section: int = 0) -> float:
    """Tension at which a certified mode of a span has a frequency.

    ``span``, {"upper", "lower"}; ``number``: which mode, from 1; ``frequency`` [Hz].
    Returns [N].
    Raises `NotComputed` if no tension below the cable's own stiffness gives it.
    """
    trial = drive
    for _ in range(60):
        cable = trial.cable
        mode = float(section_modes(trial, span, section)[number - 1])
        reduced = cable.pretension / (1.0 + cable.prestrain) * (frequency / mode) ** 2
        if reduced >= cable.axial_rigidity:
            raise NotComputed(f"no tension makes mode {number} of the {span} span {frequency:.5g} Hz")
        tension = reduced / (1.0 - reduced / cable.axial_rigidity)
        if abs(tension / cable.pretension - 1.0) < 1e-12:
            return tension
        trial = replace(trial, cable=replace(cable, pretension=tension))
    return tension


def modes_of(drive: Drive, span: str, section: int) -> Array:
    """First frequencies of a section of a span that guided carriages part; one in a single piece has one."""
    parted = any(carriage.guided for carriage in drive.carriages_on(span))
    return section_modes(drive, span, section if parted else 0)
