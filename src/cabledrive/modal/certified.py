"""A list of modes with the proof that it is complete."""

from dataclasses import dataclass

from cabledrive.modal.mode import LONGITUDINAL, TRANSVERSE, Mode
from cabledrive.modal.search import ENCLOSURE


@dataclass(frozen=True, slots=True, kw_only=True)
class Certificate:
    """Proof that a list of modes is complete.

    Attributes
    ----------
    below : float
        Every mode of both kinds below this frequency [Hz] is in the list.
    longitudinal_below, transverse_below : float
        Every mode of the one kind below this frequency [Hz] is in the list; neither is less than `below`.
    count : int
        How many lie below `below`, by the count of Wittrick and Williams, multiplicities and both planes
        included.
    longitudinal, transverse : int
        The two parts of `count`.
    enclosure : float
        Relative half-width of the interval in which two counts prove each mode to lie.
    """

    below: float
    longitudinal_below: float
    transverse_below: float
    count: int
    longitudinal: int
    transverse: int
    enclosure: float = ENCLOSURE


@dataclass(frozen=True, kw_only=True, eq=False)
class Modes:
    """Natural modes of a drive, certified.

    Attributes
    ----------
    modes : tuple of Mode
        Ascending in frequency, both kinds, without the rigid-body mode.
    certified : bool
        Whether every mode is proven, the list below the certificate's bound is as long as the count, and no
        model of a listed mode is used outside its range.
    certified_reason : str or None
        Why it is not certified.
    warnings : tuple of str
        Those of the drive's warnings that touch the list, and what sag does to the longitudinal modes.
    at_torque : float
        Steady torque on the drive pulley [N m].
    certificate : Certificate
    rigid_body_modes : int
        Motions that strain nothing.
    drive_hash : str
        Content hash of the drive; empty for a chain.
    motor : {"free", "held", "holding"}
        How the rotor is held.
    hold : tuple of str
        Joints that are held as well.
    """

    modes: tuple[Mode, ...]
    certified: bool
    certified_reason: str | None
    warnings: tuple[str, ...]
    at_torque: float
    certificate: Certificate
    rigid_body_modes: int
    drive_hash: str
    motor: str
    hold: tuple[str, ...]

    @property
    def longitudinal(self) -> tuple[Mode, ...]:
        """The longitudinal modes."""
        return tuple(mode for mode in self.modes if mode.kind == LONGITUDINAL)

    @property
    def transverse(self) -> tuple[Mode, ...]:
        """The transverse modes."""
        return tuple(mode for mode in self.modes if mode.kind == TRANSVERSE)
