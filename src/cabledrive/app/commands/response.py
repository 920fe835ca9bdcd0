"""`cabledrive response`: a frequency response from a log, or of a machine."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from cabledrive.app.combinations import HOW_READ, Chooser, refuse_given, refuse_not_of
from cabledrive.app.options import argument, opt, saves_answer, subcommand
from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import InputRefused, load_drive, packaged_drives

if TYPE_CHECKING:
    from cabledrive.identification.signals import FrequencyResponse
    from cabledrive.parameters.arrays import Array

LOG, DRIVE, LOG_OR_DRIVE = ("log",), ("drive",), ("log", "drive")


@subcommand(
    "cabledrive response log.csv --input torque --response angle --differentiate --json", (saves_answer,)
)
def command(
    log: str = argument("LOG"),
    input_: str | None = opt("COL", "Channel or column of the input.", flags="--input"),
    column: str | None = opt("COL", "Channel or column of the output.", flags="--response"),
    choose: Chooser = HOW_READ,
    config: str | None = opt("path", "TOML file with [log].", of=LOG),
    segment: float = opt("s", "Length of the Hann windows.", 1.0, of=LOG),
    overlap: float | None = opt(
        "s", "Overlap of neighbouring windows; default: 0.2 s, at most half a window.", of=LOG
    ),
    estimator: str = opt(click.Choice(["H1", "H2", "Hv"]), "", "H1", of=LOG),
    below: float | None = opt("Hz", "Of a drive file: highest line.", of=DRIVE),
    keep_all: bool = opt("flag", "Keep all records, also those with a disturbance.", of=LOG),
    differentiate: bool = opt("flag", "The speed of the output, an angle or position.", of=LOG_OR_DRIVE),
    coulomb: float | None = opt("N m", "Coulomb friction to take off the input first.", of=LOG),
    offset: float = opt("N m", "Offset to add to the input first.", 0.0, of=LOG),
    amplifier: bool = opt("flag", "Fit gain and bandwidth, from a command [V] to a torque [N m].", of=LOG),
) -> Answer:
    """Measure the response from one channel of LOG to another: magnitude, phase, coherence.

    Without --input and --response LOG is a measured response itself, a table of frequency, magnitude and
    phase; repeats are averaged robustly. LOG may also be the name or file of a machine: its response is
    computed, --input and --response are then coordinates such as "drive pulley", "motor" and head.x.
    """
    from cabledrive.identification.axis.answer import IdentifyOptions
    from cabledrive.identification.log_response import read_pair, response
    from cabledrive.identification.one_log import load_options

    if log.endswith(".toml") or log in packaged_drives():
        refuse_not_of("drive", "is for logs: leave it out with a drive file")
        return response_of_machine(log, input_, column, below, speed=differentiate)
    if input_ is None and column is None:
        refuse_given("below", why="is for drive files: leave it out with a log")
        refuse_not_of("file", "is for logs: name the channels with --input and --response, or leave it out")
        return _of_a_file(log)
    refuse_not_of("log", "is for drive files: leave it out with a log")
    if input_ is None or column is None:
        raise InputRefused("a response needs both --input COL and --response COL: name the columns")
    if coulomb is None:
        refuse_given("offset", why="belongs to --coulomb: add that (0 for none), or leave it out")
    options = IdentifyOptions() if config is None else load_options(config)
    read, source, target = read_pair(log, choose(options.columns), input_, column)
    found = response(
        read,
        source,
        target,
        segment=segment,
        overlap=overlap,
        estimator=estimator,
        robust=not keep_all,
        differentiate=differentiate,
        coulomb=coulomb,
        offset=offset,
    )
    fitted, words = _amplifier(read, source, target, segment) if amplifier else ({}, "")
    said, warnings = coherence_words(found, read.channel(source), read.interval)
    blows = [{"start": b.start, "end": b.end, "reason": b.reason} for b in found.blows]
    about = {"left_out": blows, "input": input_, "output": column, "warnings": warnings}
    text = f"{found.frequency.size} lines up to {found.frequency[-1]:g} Hz, {found.averages:.1f} averages"
    text += f"\n{said}"
    text += "".join(f"\nexcluded, {b.start:.4g} to {b.end:.4g} s: {b.reason}" for b in found.blows)
    return Answer(
        data=_lines_of(found) | about | fitted,
        text=text + words,
        provenance=provenance(method=f"{estimator}, Hann windows of {segment:g} s"),
    )


def _lines_of(found: Any) -> dict[str, Any]:
    """Frequencies of a response and what was found at them, as JSON has them."""
    same = {name: getattr(found, name) for name in ("magnitude", "coherence", "deviation", "averages")}
    return same | {
        "frequency_hz": found.frequency,
        "phase_deg": found.phase,
        "records_left_out": found.left_out,
    }


def _of_a_file(path: str) -> Answer:
    """A response that was measured elsewhere, averaged over its repeats."""
    from cabledrive.identification.log_response import read_response

    found = read_response(path)
    return Answer(
        data=_lines_of(replace(found, coherence=np.full(found.frequency.size, np.nan)))
        | {"left_out": [], "coherence_reason": NO_COHERENCE},
        text=f"{found.frequency.size} lines up to {found.frequency[-1]:g} Hz, {found.averages:.1f} repeats, "
        f"{found.left_out} outliers; {NO_COHERENCE}",
        provenance=provenance(method="median of the repeats at each frequency"),
    )


def _amplifier(log: Any, command_: str, torque: str, segment: float) -> tuple[dict[str, Any], str]:
    """Gain, bandwidth and dead time, as JSON and in a line."""
    from cabledrive.identification.response_models import identify_amplifier

    fit = identify_amplifier(log, command=command_, torque=torque, segment=segment)
    parts = {"gain": fit.gain, "bandwidth": fit.bandwidth, "delay": fit.delay}
    data = {name: estimate.as_dict() for name, estimate in parts.items()}
    lag = f"{fit.bandwidth.value:.5g} Hz" if fit.bandwidth.value > 0.0 else fit.bandwidth.reason
    words = f"\namplifier: {fit.gain.value:.5g} {fit.gain.unit}, {fit.decibels:.3g} dB, {lag}"
    return {"amplifier": data | {"gain_db": fit.decibels, "misfit": fit.misfit}}, words


NO_COHERENCE = "a table of responses does not say its coherence"
LINES = 400
ROUND_OFF = 1e-10
"""Of a response, relative to the mean of the responses of both its coordinates to their own forces."""
_FIRST = 1e-2
"""Lowest line, relative to the highest."""


def response_of_machine(
    source: str, force_on: str | None, motion_of: str | None, below: float | None, *, speed: bool
) -> Answer:
    """The response of a machine about where it hangs; ``below`` [Hz]; ``speed``: of the motion's speed."""
    from cabledrive.mechanics.holding import motor_condition
    from cabledrive.mechanics.network import network_of, responses
    from cabledrive.modal import natural_frequencies
    from cabledrive.modal.ranges import route_range_warnings

    drive = load_drive(source)
    force_on = force_on or (drive.pulley[drive.driven[0]].name if drive.motor else None)
    if force_on is None:
        raise InputRefused("a machine without a motor: name the coordinate that is pushed with --input")
    motion_of = motion_of or force_on
    top = 3.0 * float(natural_frequencies(drive, count=1)[0]) if below is None else below
    frequency = top * np.geomspace(_FIRST, 1.0, LINES)
    with np.errstate(all="ignore"):  # far above all modes the waves of damped spans overflow
        every = responses(drive, frequency, (force_on, motion_of))
    if not np.isfinite(every).all():
        raise InputRefused(
            f"--below {top:.4g} Hz lies beyond what waves on a span are computed for: lower it"
        )
    found = every[:, 1, 0]
    # Round-off beside what each of both coordinates moves under its own force?
    own = np.sqrt(np.abs(every[:, 0, 0] * every[:, 1, 1]))
    still = bool((np.abs(found) <= ROUND_OFF * own).all())
    if speed:
        found = 2j * np.pi * frequency * found
    parts: tuple[Any, ...] = (*drive.body, *drive.pulley, *drive.motor)
    rubs = any(part.coulomb_friction > 0.0 for part in parts)
    data: dict[str, Any] = {
        "frequency_hz": frequency,
        "magnitude": np.abs(found),
        "phase_deg": np.degrees(np.unwrap(np.angle(found))),
        "input": force_on,
        "output": motion_of,
        "motor": motor_condition(drive),
        "left_out": [],
        "warnings": [
            *([f"a force on {force_on} does not move {motion_of}: zero but for round-off"] if still else []),
            *(["Coulomb friction is left out"] if rubs else []),
            *route_range_warnings(network_of(drive)),
        ],
    }
    what = "speed" if speed else "motion"
    text = f"{drive.name}: {what} of {motion_of} per force on {force_on}, {LINES} lines up to {top:.4g} Hz"
    text += "".join(f"\nwarning: {words}" for words in data["warnings"])
    return Answer(data=data, text=text, provenance=provenance(drive, method="exact waves on every span"))


LOW = 0.8
"""Coherence below which a response is mostly not that of its input."""
TAIL = 0.025
"""Share of the input's power on either side of the band in which it is judged."""


def coherence_words(found: "FrequencyResponse", input_: "Array", interval: float) -> tuple[str, list[str]]:
    """The coherence in the band that the input drives, and a warning where it is low."""
    power = np.abs(np.fft.rfft((input_ - input_.mean()) * np.hanning(input_.size))) ** 2
    total = np.cumsum(power)
    ends = np.searchsorted(total, [TAIL * total[-1], (1.0 - TAIL) * total[-1]])
    low, high = np.fft.rfftfreq(input_.size, interval)[np.minimum(ends, power.size - 1)]
    inside = (found.frequency >= low) & (found.frequency <= high)
    if not inside.any():
        distance = np.abs(found.frequency - 0.5 * (low + high))
        inside = distance == distance.min()
    values = found.coherence[inside]
    middle, worst = float(np.median(values)), int(np.argmin(values))
    words = f"coherence {middle:.2f} (median, {low:.3g} to {high:.3g} Hz, where the input has its power), "
    words += f"lowest {values[worst]:.2f} at {found.frequency[inside][worst]:.4g} Hz"
    if middle >= LOW:
        return words, []
    warning = f"coherence {middle:.2f} is below {LOW:g}: most of the output is noise, not linear, "
    warning += "or not of this input; check the columns, excite more strongly"
    return f"{words}\nwarning: {warning}", [warning]
