"""Stage 1: the drive and the data: what follows from the file, what is odd, what the logs hold."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cabledrive.identification.logs.log import Log
from cabledrive.mechanics import drive_warnings
from cabledrive.mechanics.holding import left_out_under_torque
from cabledrive.mechanics.network.span_table import route_warnings
from cabledrive.modal.lowest import derived_with_lowest, lowest_frequencies
from cabledrive.parameters import Drive
from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.rig.laws.fitting import SHAFTS
from cabledrive.studies.study.carriage_machine import missing_for_carriage


@dataclass(frozen=True, slots=True, kw_only=True)
class LogWords:
    """One log in short.

    Attributes
    ----------
    name : str
    sha256 : str
    rows : int
    duration : float
        [s].
    sample_rate : float
        [Hz].
    channels : dict of str to str
        SI unit by channel.
    repaired, findings : tuple of str
    """

    name: str
    sha256: str
    rows: int
    duration: float
    sample_rate: float
    channels: dict[str, str]
    repaired: tuple[str, ...]
    findings: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckResult:
    """What the check found.

    Attributes
    ----------
    derived : dict of str to float or None
        Closed formulas of the datasheet, SI.
    warnings : tuple of str
        Warnings about the drive.
    missing : tuple of str
        What a controller needs and the file does not give, with the remedy.
    logs : tuple of LogWords
    """

    derived: dict[str, float | None]
    warnings: tuple[str, ...]
    missing: tuple[str, ...]
    logs: tuple[LogWords, ...]


def check(drive: Drive, logs: Sequence[Log], hashes: Sequence[str]) -> CheckResult:
    """Check a drive and its logs.

    ``hashes``: SHA-256 of each log's file.
    """
    derived, warnings = _of_the_file(drive)
    left_out = left_out_under_torque(drive)
    return CheckResult(
        derived={k: v for k, v in derived.items() if v is None or isinstance(v, float)},
        warnings=(*warnings, *([left_out] if left_out else [])),
        missing=missing_for_control(drive),
        logs=tuple(_in_short(log, digest) for log, digest in zip(logs, hashes, strict=True)),
    )


def _of_the_file(drive: Drive) -> tuple[dict[str, Any], Sequence[str]]:
    """Derived quantities and warnings; of an axis those of its machine, whose spans the axis has not."""
    if not isinstance(drive, AxisDrive):
        return derived_with_lowest(drive), drive_warnings(drive)
    lowest = lowest_frequencies(drive.machine).as_dict()
    sag = [drive.words["sag"]] if drive.words["sag"] else []
    return lowest | {"slack_torque": drive.words["slack_torque"]}, [*route_warnings(drive.machine), *sag]


def missing_for_control(drive: Drive) -> tuple[str, ...]:
    """What stands between a drive file and a controller.

    Returns empty where a controller can be designed.
    """
    if drive.carriage:
        return missing_for_carriage(drive)
    found = []
    sensors = drive.sensors
    if sensors is None or sensors.sample_rate is None:
        found.append('sensors.sample_rate is missing: give it, such as "5 kHz"')
    if sensors is not None and all(getattr(sensors, f"{shaft}_encoder") is None for shaft in SHAFTS[:2]):
        found.append("neither sensors.motor_encoder nor sensors.drive_encoder is given: fit one")
    if any(pulley.fixed for pulley in drive.pulley):
        found.append("a pulley is fixed: the controller stages need two rotating pulleys")
    return tuple(found)


def _in_short(log: Log, digest: str) -> LogWords:
    report = log.report
    return LogWords(
        name=Path(log.source).name,
        sha256=digest,
        rows=report.rows,
        duration=float(report.duration),
        sample_rate=float(log.sample_rate),
        channels=dict(log.units),
        repaired=report.repaired,
        findings=report.findings,
    )
