"""The response between two channels of one log, by windowed segments."""

from pathlib import Path

from cabledrive.identification.frequency_response import FrequencyResponse, response_by_segments
from cabledrive.identification.logs.column_map import ColumnMap
from cabledrive.identification.logs.log import Log
from cabledrive.identification.response_inputs import compensated_torque, read_pair, speed_of
from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import LARGEST

OVERLAP = 0.2
"""Of neighbouring windows [s], at most half of one."""


def response(
    log: Log | str | Path,
    input: str,
    output: str,
    *,
    columns: ColumnMap | None = None,
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
    columns : ColumnMap, optional
        Which columns of a file hold which channel; recognised by their heads unless given.
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
        Frequencies [Hz], magnitude, phase [deg], coherence; the records left out, each with its reason.

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
        log, input, output = read_pair(log, columns or ColumnMap(), input, output)
    source, target = log.channel(input), speed_of(log, output) if differentiate else log.channel(output)
    if coulomb is not None:
        source = compensated_torque(source, speed_of(log, output), coulomb, offset)
    return response_by_segments(
        source,
        target,
        log.interval,
        segment=segment,
        overlap=min(OVERLAP, 0.5 * segment) if overlap is None else overlap,
        estimator=estimator,
        robust=robust,
    )
