"""What a log says against the drive file, and the steps of its encoders against those of the file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import floor, pi
from typing import Any

import numpy as np

from cabledrive.identification.logs.log import Log
from cabledrive.parameters import Drive

ENCODERS = {
    "angle": "motor_encoder",
    "motor_angle": "motor_encoder",
    "drive_angle": "drive_encoder",
    "load_angle": "load_encoder",
}
COARSER = 1.2
"""Step of a log over that of the file from which the two contradict."""
FEWEST_LEVELS = 8
"""Readings that differ, below which their common step may be a multiple of a count."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LogFinding:
    """What a log says against the drive file."""

    id: str  # A quantity of the study, an encoder's key, "delay", "replay" or "identification"
    words: str
    # value, limit: what was found, and what is allowed; None: said in words alone
    value: float | None = None
    limit: float | None = None
    unit: str = ""
    decides: bool = True  # whether the verdict rests on it

    def __str__(self) -> str:
        return self.words

    @property
    def data(self) -> dict[str, Any]:
        """As ``results.json`` has it."""
        found: dict[str, Any] = {"id": self.id, "value": self.value, "limit": self.limit, "unit": self.unit}
        if self.value is None:
            found |= {f"{key}_reason": "the finding is in words" for key in ("value", "limit")}
        return found | {"decides": self.decides, "message": self.words}


def coarser_encoders(drive: Drive, logs: Sequence[Log]) -> dict[str, int]:
    """Counts per revolution of encoders that the logs show coarser than the drive file has them, by key."""
    found: dict[str, int] = {}
    for log in logs:
        for channel, key in ENCODERS.items():
            counts = None if drive.sensors is None else getattr(drive.sensors, key)
            step = log.report.quantum.get(channel, 0.0)
            if not counts or not step or channel not in log.channels:
                continue
            if np.unique(log.channel(channel)).size < FEWEST_LEVELS:
                continue
            seen = floor(2.0 * pi / step + 0.5)
            if seen < counts:
                found[key] = max(min(seen, found.get(key, seen)), 1)
    return found


def encoder_findings(drive: Drive, coarser: Mapping[str, int]) -> tuple[LogFinding, ...]:
    """Encoders of a log that are no longer those of the drive file."""
    found = []
    for key, counts in coarser.items():
        named = getattr(drive.sensors, key)
        if named > COARSER * counts:
            found.append(
                LogFinding(
                    id=key,
                    value=2.0 * pi / counts,
                    limit=COARSER * 2.0 * pi / named,
                    unit="rad",
                    words=f"the {key.replace('_', ' ')} of the log has {counts} counts per revolution, "
                    f"sensors.{key} of the drive file {named}; the coarser one is used",
                )
            )
    return tuple(found)
