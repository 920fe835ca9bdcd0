"""One axis of a machine with routes, as the loop round two pulleys that has the same lumped chain."""

from dataclasses import dataclass, field
from typing import Any

from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route.drive import RoutedDrive


@dataclass(frozen=True, kw_only=True)
class AxisDrive(Drive):
    """The chain that a motor of a machine with routes drives, for control: it has no spans of its own.

    Its cable has the chain's stiffness, no mass, and the pretension of a loop slack at the same torque.
    """

    machine: RoutedDrive  # where it comes from
    load: str  # coordinate that is the load
    gain: float  # its motion per motor angle [m/rad], [rad/rad]
    slides: bool  # whether the load slides: its "load angle" is then its place over the gain
    words: dict[str, Any] = field(compare=False)  # how the chain was found, for results


def require_own_spans(drive: object, what: str) -> None:
    """Refuse an axis of a machine with routes where the spans themselves are needed; ``what``: by whom."""
    if isinstance(drive, AxisDrive):
        raise InputRefused(
            f'kind = "route": {what} needs the spans, and the axis of {drive.load} is a lumped chain: '
            "take a lumped plant"
        )
