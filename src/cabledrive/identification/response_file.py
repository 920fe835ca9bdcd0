"""A frequency response that was measured elsewhere: a table of frequency, magnitude and phase."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.frequency_response import FrequencyResponse
from cabledrive.identification.logs.opening import open_table
from cabledrive.identification.logs.table import Table
from cabledrive.parameters import InputRefused
from cabledrive.parameters.units import to_si

Array = NDArray[np.float64]

FREQUENCIES = {
    "omega": "rad/s",
    "w": "rad/s",
    "frequency": "Hz",
    "frequency_hz": "Hz",
    "f": "Hz",
    "freq": "Hz",
}
MAGNITUDES = ("magnitude", "gain", "amplitude", "mag")
PHASES = {"phase": "rad", "phase_deg": "deg"}
SAME = 1e-6
"""Relative distance of frequencies that count as one."""
DEVIATIONS = 4.0
MOST_ROWS = 5_000_000


def read_response(path: str | Path) -> FrequencyResponse:
    """Read a response from a table; repeats at one frequency are averaged without their outliers.

    ``path``: with columns omega [rad/s] or frequency [Hz], magnitude (or "magnitude [dB]") and phase [rad] or
    [deg], of any format that logs may have.
    Returns ``deviation`` from the spread of the repeats, NaN where there is one; ``coherence`` 1, since it
    cannot be determined; ``left_out`` the number of outliers.
    Raises `InputRefused` if a column is missing, or a number is missing or impossible.
    """
    table = open_table(path)
    heads = {name.lower().strip(): name for name in table.names}
    frequency = next((heads[name] for name in FREQUENCIES if name in heads), None)
    magnitude = next((heads[name] for name in MAGNITUDES if name in heads), None)
    phase = next((heads[name] for name in PHASES if name in heads), None)
    if frequency is None or magnitude is None or phase is None:
        raise InputRefused(
            f"{table.source}: no columns omega or frequency, magnitude and phase (found: "
            f"{', '.join(table.names)[:90]}): name them so, or give --input and --response of a log"
        )
    if (table.rows or 0) > MOST_ROWS:
        raise InputRefused(f"{table.source}: more than {MOST_ROWS} rows: average them first")
    blocks = list(table.read((frequency, magnitude, phase)))
    columns = [np.concatenate([block[name] for block in blocks]) for name in (frequency, magnitude, phase)]
    if not all(np.isfinite(column).all() for column in columns) or columns[0].min() <= 0.0:
        raise InputRefused(f"{table.source}: a number is missing, or a frequency is not above 0: correct it")
    hertz = columns[0] * _factor(table, frequency, FREQUENCIES, "rad/s") / (2 * np.pi)
    size = _size(table, magnitude, columns[1])
    angle = columns[2] * _factor(table, phase, PHASES, "rad")
    return _averaged(hertz, np.asarray(size * np.exp(1j * angle), dtype=complex))


def _factor(table: Table, name: str, units: dict[str, str], si: str) -> float:
    unit = table.units.get(name) or units[name.lower().strip()]
    if si == "rad/s" and unit.lower() in ("hz", "khz"):
        return 2 * np.pi * to_si(f"1 {unit}", "Hz")
    try:
        return to_si(f"1 {unit}", si)
    except InputRefused as refusal:
        raise refusal.at(f'{table.source}: column "{name}"') from None


def _size(table: Table, name: str, values: Array) -> Array:
    if table.units.get(name, "").lower() == "db":
        return np.asarray(10.0 ** (values / 20.0), dtype=float)
    if values.min() < 0.0:
        raise InputRefused(
            f'{table.source}: column "{name}" is negative: head it "{name} [dB]" if it is in dB'
        )
    return values


def _averaged(hertz: Array, response: NDArray[np.complex128]) -> FrequencyResponse:
    """Mean of the repeats near their median, for every frequency."""
    order = np.argsort(hertz, kind="stable")
    hertz, response = hertz[order], response[order]
    groups = np.split(np.arange(hertz.size), np.flatnonzero(np.diff(hertz) > SAME * hertz[:-1]) + 1)
    means, errors, left_out = [], [], 0
    for group in groups:
        values = response[group]
        middle = np.median(values.real) + 1j * np.median(values.imag)
        off = np.abs(values - middle)
        keep = off <= max(DEVIATIONS * 1.4826 * float(np.median(off)), 1e-9 * abs(middle))
        left_out += int((~keep).sum())
        kept = values[keep]
        means.append(kept.mean())
        errors.append(
            np.sqrt(np.var(kept) * kept.size / (kept.size - 1) / kept.size) if kept.size > 1 else np.nan
        )
    return FrequencyResponse(
        frequency=np.array([hertz[group].mean() for group in groups]),
        response=np.array(means),
        deviation=np.array(errors),
        coherence=np.ones(len(groups)),
        averages=float(np.mean([group.size for group in groups])),
        left_out=left_out,
    )
