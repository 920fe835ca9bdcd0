"""The response between two channels of a log, or from a file, and what its coherence says."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from cabledrive.identification.logs.log import Column, ColumnMap, Log, Table, recognise
from cabledrive.identification.logs.reading import open_log, open_table, read_log
from cabledrive.identification.signals import FrequencyResponse, difference, response_by_segments
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import LARGEST
from cabledrive.parameters.units import to_si


def compensated_torque(torque: Array, speed: Array, coulomb: float, offset: float) -> Array:
    r"""Torque (samples,) without Coulomb friction and offset, :math:`\tau - c_1 S(\dot\theta) + d_1`."""
    return torque - coulomb * np.sign(speed) + offset


def speed_of(log: Log, channel: str) -> Array:
    """Speed (samples,) from a channel: as it is, or the difference of an angle or position."""
    values, quantity = log.channel(channel), channel.rpartition("_")[2]
    if quantity not in ("angle", "position", "velocity"):
        raise InputRefused(f'{log.source}: "{channel}" is no angle, position or velocity: choose another')
    return values if quantity == "velocity" else difference(values, log.interval)


def read_pair(path: str | Path, columns: ColumnMap, input_: str, output: str) -> tuple[Log, str, str]:
    """A log for a response of channels, heads or any columns of a file, and the channels that they are."""
    wanted, chosen, names = {"input_": input_, "output": output}, dict(columns.columns), []
    opened = columns
    if not columns.columns and any(not recognise(name) for name in wanted.values()):
        # A map that lets the file be opened whatever its columns are called.
        opened = replace(columns, columns={"input_voltage": Column(column=input_, unit="V")})
    table = open_log(path, opened).table
    for role, name in wanted.items():
        seen = recognise(name)
        heads = [head for head in table.names if seen and recognise(head) == seen]
        if name in chosen:
            names.append(name)
        elif seen and len(heads) == 1:
            names.append(seen)
            chosen[seen] = Column(column=heads[0])
        else:
            names.append(f"{role.strip('_')}_voltage")  # any column: its numbers as they are
            chosen[names[-1]] = Column(column=table.require(name), unit="V")
    source, target = (chosen[name].column for name in names)
    if source == target:
        raise InputRefused(
            f'{table.source}: input and output are both the column "{source}": a response is from one column '
            f"to another: choose two of {', '.join(table.names)[:90]}"
        )
    return read_log(path, replace(columns, columns=chosen)), names[0], names[1]


OVERLAP = 0.2
"""Of neighbouring windows [s], at most half of one."""


def response(
    log: Log | str | Path,
    input: str,
    output: str,
    *,
    segment: float = 1.0,
    overlap: float | None = None,
    estimator: str = "H1",
    robust: bool = True,
    differentiate: bool = False,
    coulomb: float | None = None,
    offset: float = 0.0,
) -> FrequencyResponse:
    """Frequency response from one channel of a log to another.

    Parameters
    ----------
    log : Log or path
        A path may name plain columns of the file as input and output, too.
    input, output : str
        Channels, as "torque" and "angle".
    segment : float, default 1.0
        Length of the Hann windows [s].
    overlap : float, optional
        Of neighbouring windows [s]; 0.2 s, at most half of one, unless given.
    estimator : {"H1", "H2", "Hv"}
        Least squares with the noise at the output, at the input, or at both.
    robust : bool, default True
        Leave out records in which the output does what neither the input nor its own past explains.
    differentiate : bool, default False
        Take the speed of the output.
    coulomb : float, optional
        Coulomb friction [N m] to take off the input with the sign of the speed; none unless given.
    offset : float, default 0.0
        Offset torque [N m] to take off with it.

    Returns
    -------
    FrequencyResponse
        Frequencies [Hz], magnitude, phase [deg], coherence, deviation by noise and by the bias of the
        windows; the records left out, each with its reason.

    Raises
    ------
    InputRefused
        If a channel is missing, the windows do not fit the log, the input stands still, or a number is beyond
        its bounds.
    """
    if coulomb is not None and not 0.0 <= coulomb <= LARGEST:
        raise InputRefused(f"--coulomb = {coulomb:.4g} N m must lie from 0 to {LARGEST:g} N m: correct it")
    if not abs(offset) <= LARGEST:
        raise InputRefused(f"--offset = {offset:.4g} N m must lie within {LARGEST:g} N m: correct it")
    if not isinstance(log, Log):
        log, input, output = read_pair(log, ColumnMap(), input, output)
    source, target = log.channel(input), speed_of(log, output) if differentiate else log.channel(output)
    if coulomb is not None:
        source = compensated_torque(source, speed_of(log, output), coulomb, offset)
    window = segment, min(OVERLAP, 0.5 * segment) if overlap is None else overlap
    return response_by_segments(source, target, log.interval, window, estimator=estimator, robust=robust)


IN_HERTZ = ("frequency", "frequency_hz", "f", "freq")
FREQUENCIES = dict.fromkeys(("omega", "w"), "rad/s") | dict.fromkeys(IN_HERTZ, "Hz")
MAGNITUDES = ("magnitude", "gain", "amplitude", "mag")
PHASES = {"phase": "rad", "phase_deg": "deg"}
SAME = 1e-6
"""Relative distance of frequencies that count as one."""
DEVIATIONS = 4.0
MOST_ROWS = 5_000_000


def read_response(path: str | Path) -> FrequencyResponse:
    """Read omega or frequency, magnitude, phase; the mean of repeats, less outliers, NaN deviation of one."""
    table = open_table(path)
    heads = {name.lower().strip(): name for name in table.names}
    known = (FREQUENCIES, MAGNITUDES, PHASES)
    names = tuple(heads[name] for names in known for name in [n for n in names if n in heads][:1])
    if len(names) < 3:
        raise InputRefused(
            f"{table.source}: no columns omega or frequency, magnitude and phase (found: "
            f"{', '.join(table.names)[:90]}): name them so, or give --input and --response of a log"
        )
    columns, (frequency, magnitude, phase) = table.whole(names, MOST_ROWS), names
    if not all(np.isfinite(column).all() for column in columns) or columns[0].min() <= 0.0:
        raise InputRefused(f"{table.source}: a number is missing, or a frequency is not above 0: correct it")
    hertz = columns[0] * _factor(table, frequency, FREQUENCIES, "rad/s") / (2 * np.pi)
    size = columns[1]
    if table.units.get(magnitude, "").lower() == "db":
        size = 10.0 ** (size / 20.0)
    elif size.min() < 0.0:
        raise InputRefused(f'{table.source}: column "{magnitude}" is negative: head it "{magnitude} [dB]"')
    angle = columns[2] * _factor(table, phase, PHASES, "rad")
    order = np.argsort(hertz, kind="stable")
    hertz, lines = hertz[order], (size * np.exp(1j * angle))[order]
    cuts = np.flatnonzero(np.diff(hertz) > SAME * hertz[:-1]) + 1
    groups, means, errors = np.split(lines, cuts), [], []
    left_out = 0
    for values in groups:
        middle = np.median(values.real) + 1j * np.median(values.imag)
        off = np.abs(values - middle)
        kept = values[off <= max(DEVIATIONS * 1.4826 * float(np.median(off)), 1e-9 * abs(middle))]
        left_out += values.size - kept.size
        means.append(kept.mean())
        errors.append(np.std(kept) / np.sqrt(kept.size - 1) if kept.size > 1 else np.nan)
    return FrequencyResponse(
        frequency=np.array([group.mean() for group in np.split(hertz, cuts)]),
        response=np.array(means),
        deviation=np.array(errors),
        coherence=np.ones(len(groups)),
        averages=float(np.mean([group.size for group in groups])),
        left_out=left_out,
    )


def _factor(table: Table, name: str, units: dict[str, str], si: str) -> float:
    unit = table.units.get(name) or units[name.lower().strip()]
    if si == "rad/s" and unit.lower() in ("hz", "khz"):
        return 2 * np.pi * to_si(f"1 {unit}", "Hz")
    try:
        return to_si(f"1 {unit}", si)
    except InputRefused as refusal:
        raise refusal.at(f'{table.source}: column "{name}"') from None
