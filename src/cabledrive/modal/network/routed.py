"""The certified modes of a machine with routes."""

from collections.abc import Sequence
from math import isfinite, pi

from cabledrive.mechanics.network import Network, network_of
from cabledrive.modal.certified import Certificate, Modes
from cabledrive.modal.mode import LONGITUDINAL, TRANSVERSE, Mode
from cabledrive.modal.model_range import INCOMPLETE
from cabledrive.modal.network.hanging_range import hanging_limit
from cabledrive.modal.network.range import ALLOWED, range_limit, range_warnings
from cabledrive.modal.network.sag_coupling import sag_coupling_limit
from cabledrive.modal.network.spectrum import NetworkSpectrum, order_of
from cabledrive.modal.solver import ENCLOSURE
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.hashing import content_hash
from cabledrive.parameters.route import RoutedDrive

DEFAULT_COUNT = 10
MOST_MODES = 20_000
MOST_CHECKED = 2_000
"""Modes of a response or a chain among which those are looked for that sag moves."""
LOOKED_THROUGH = 400
"""Modes of a network among which the first longitudinal ones are looked for."""


def routed_modes(
    drive: RoutedDrive,
    *,
    below: float | None = None,
    count: int | None = None,
    motor: str | None = None,
    hold: Sequence[str] = (),
    hanging: bool = True,
) -> Modes:
    """All natural modes of a machine with routes; parameters as of `cabledrive.modal.modes`.

    ``hanging``: whether ropes sag; else they are straight, for what is computed of straight ropes, and the
    list is certified where sag moves none of its modes.
    """
    spectrum = NetworkSpectrum(network_of(drive, motor=motor, hold=hold), hanging=hanging)
    if below is not None:
        top = _clear(spectrum, 2 * pi * below)
        return _certified(spectrum, spectrum.below(top), (top, top), below)
    wanted = DEFAULT_COUNT if count is None else count
    parts = [spectrum.first_distinct(kind, wanted, LOOKED_THROUGH) for kind in (LONGITUDINAL, TRANSVERSE)]
    listed = sorted((mode for part, _ in parts for mode in part), key=order_of)
    along, across = (clear for _, clear in parts)
    return _certified(spectrum, listed, (along, across), below)


def routed_longitudinal(
    drive: RoutedDrive,
    *,
    below: float | None = None,
    count: int | None = None,
    motor: str | None = None,
    hold: Sequence[str] = (),
) -> tuple[Mode, ...]:
    """Longitudinal modes alone; parameters as of `cabledrive.modal.longitudinal_modes`."""
    spectrum = NetworkSpectrum(network_of(drive, motor=motor, hold=hold))
    if below is not None:
        listed = spectrum.below(_clear(spectrum, 2 * pi * below))
    else:
        assert count is not None
        listed = first_longitudinal(spectrum, count)
    return tuple(mode for mode in listed if mode.kind == LONGITUDINAL)


def _certified(
    spectrum: NetworkSpectrum, listed: list[Mode], tops: tuple[float, float], below: float | None
) -> Modes:
    """A list with its certificate; ``tops``: up to where each kind, along and across, is listed [rad/s]."""
    top = min(tops)
    if below is None:
        top = _off_modes(spectrum, top)
    along, across = (max(top, own) if isfinite(own) else top for own in tops)
    number = spectrum.count(top)
    under = [mode for mode in listed if 2 * pi * mode.frequency < top]
    parts = {
        kind: sum(mode.multiplicity for mode in under if mode.kind == kind)
        for kind in (LONGITUDINAL, TRANSVERSE)
    }
    proven = sum(parts.values()) == number and all(mode.proven for mode in listed)
    network = spectrum.network
    limit = _limit(spectrum, listed)
    return Modes(
        modes=tuple(listed),
        certified=proven and limit is None,
        certified_reason=limit if proven else INCOMPLETE,
        warnings=tuple(range_warnings(network, spectrum.straight)),
        at_torque=0.0,
        certificate=Certificate(
            below=_hertz(top, below),
            longitudinal_below=_hertz(along, below),
            transverse_below=_hertz(across, below),
            count=number,
            longitudinal=parts[LONGITUDINAL],
            transverse=number - parts[LONGITUDINAL],
            enclosure=spectrum.enclosure,
        ),
        rigid_body_modes=spectrum.rigid_body_modes,
        drive_hash=content_hash(network.drive),
        motor=network.motion.motor,
        hold=tuple(sorted(network.motion.hold)),
    )


def _hertz(omega: float, below: float | None) -> float:
    """A bound in Hz: the one that was asked for, to the last digit, where it is that."""
    return below if below is not None and omega == 2 * pi * below else omega / (2 * pi)


def straight_limit(network: Network, below: float, *, kind: str | None = None) -> str | None:
    """Why straight ropes are in doubt as a model of a machine below a frequency; None where they are not.

    ``below``: [rad/s]; ``kind``: of the modes that matter, {"longitudinal", "transverse"} or None for all.
    """
    spectrum = NetworkSpectrum(network, hanging=False)
    number = spectrum.count(below)
    if number > MOST_CHECKED:
        return (
            f"straight ropes: {number} modes below {below / (2 * pi):.4g} Hz, more than {MOST_CHECKED}: "
            "whether sag moves one was not checked"
        )
    listed = [mode for mode in spectrum.below(below) if kind in (None, mode.kind)]
    return _limit(spectrum, listed)


def _limit(spectrum: NetworkSpectrum, listed: Sequence[Mode]) -> str | None:
    """Why a list is not certified although the count agrees."""
    network, straight = spectrum.network, spectrum.straight
    return (
        hanging_limit(network, spectrum.hung, listed, ALLOWED)
        or range_limit(network, listed, straight)
        or sag_coupling_limit(network, listed, spectrum.below, ALLOWED, straight)
    )


def _clear(spectrum: NetworkSpectrum, omega: float) -> float:
    """The frequency, or one just below it, at which the count does not depend on round-off [rad/s]."""
    _check_number(spectrum, omega)
    return _off_modes(spectrum, omega)


def _off_modes(spectrum: NetworkSpectrum, omega: float) -> float:
    """As `_clear`, of a frequency to which few modes are known to lie [rad/s]."""
    step = 4 * ENCLOSURE
    while spectrum.count(omega * (1 - ENCLOSURE)) != spectrum.count(omega * (1 + ENCLOSURE)):
        omega, step = omega * (1 - step), 2 * step
    return omega


def _check_number(spectrum: NetworkSpectrum, omega: float) -> None:
    held = spectrum.count(omega)
    if held > MOST_MODES:
        below = omega / (2 * pi)
        raise InputRefused(
            f"below = {below:.9g} Hz holds {held} modes, at most {MOST_MODES} are certified: lower "
            "it to about "
            f"{below * MOST_MODES / held:.3g} Hz"
        )


def first_longitudinal(spectrum: NetworkSpectrum, count: int) -> list[Mode]:
    """The first longitudinal modes, ascending; fewer where so many are not among the first of each part."""
    return spectrum.first(LONGITUDINAL, count, LOOKED_THROUGH)
