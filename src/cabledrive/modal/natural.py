"""The natural modes of a drive: every one below a frequency, with a certificate of completeness."""

from collections.abc import Sequence
from math import isfinite, pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import Chain
from cabledrive.mechanics.holding import clamped, held_joints, motor_condition
from cabledrive.mechanics.own_chain import own_chain
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal.band import Band, order_of
from cabledrive.modal.certified import Certificate, Modes
from cabledrive.modal.mode import LONGITUDINAL, Mode
from cabledrive.modal.model_range import INCOMPLETE, mode_warnings, model_limit
from cabledrive.modal.resting_modes import transverse_band
from cabledrive.parameters import Drive, InputRefused, content_hash
from cabledrive.parameters.route.axis import AxisDrive
from cabledrive.parameters.route.drive import RoutedDrive, refuse_route

DEFAULT_COUNT = 10
MOST_MODES = 20_000
LOWEST_BELOW, HIGHEST_BELOW = 1e-30, 1e30


def modes(
    drive: Drive | RoutedDrive | Chain,
    *,
    below: float | None = None,
    count: int | None = None,
    motor: str | None = None,
    hold: Sequence[str] = (),
    at_torque: float = 0.0,
) -> Modes:
    """All natural modes of a drive below a frequency, or those of the first few frequencies of each kind.

    Longitudinal motion by the exact dynamic stiffness of every span, of the taut cable. Transverse motion
    under the tension at rest (`cabledrive.mechanics.rest_state`), hanging carriages as point masses: strings
    out of the plane of gravity, with shallow sag in it. Pulley friction and dampings do not enter.

    Parameters
    ----------
    drive : Drive, RoutedDrive or Chain
        Of a machine with routes each mode has the kind of its larger strain energy. A
        `cabledrive.mechanics.Chain` has the modes of its one direction of motion, listed as longitudinal; its
        own springs and fixed ends say how it is held. Its segments may be different cables.
    below : float, optional
        Upper end [Hz].
    count : int, optional
        The first so many distinct frequencies of each kind instead, whole multiplets; ten where neither is
        given.
    motor : {"free", "held", "holding"}, optional
        How the rotor is held: it turns, it does not (behind a flexible joint the drive pulley still does,
        without ``[motor]`` the drive pulley is held), or it turns on ``motor.holding_stiffness``. Default:
        "holding" where the drive has that stiffness, else "free".
    hold : sequence of str, optional
        Parts that are held as well: "drive pulley", "load pulley", "carriage 0", or a carriage's own name.
    at_torque : float, default 0.0
        Steady torque on the drive pulley that loads the spans, taken up at the load pulley [N m]; positive
        relieves the upper span.

    Returns
    -------
    Modes

    Raises
    ------
    InputRefused
        If both limits are given, or a limit is not positive, or would list more than 20 000 modes, or
        `motor` or `hold` do not fit the drive, or the torque is not finite.
    NotComputed
        If a mode that the count promises could not be refined, or no state of rest is found.

    References
    ----------
    .. [1] Eqs. (3.10)-(3.13), (3.17)-(3.20), (3.24)-(3.26), (3.27), (3.37)-(3.38), generalised.
    """
    if isinstance(drive, AxisDrive):
        drive = drive.machine
    if isinstance(drive, Chain):
        return _of_chain(drive, below, count, motor is not None or bool(hold) or at_torque != 0.0)
    if isinstance(drive, RoutedDrive):
        return _of_routes(drive, below, count, motor, hold, at_torque)
    chains = longitudinal_chains(drive, motor=motor, hold=hold)
    along, across = Band(chains, LONGITUDINAL), transverse_band(clamped(drive, hold), chains, at_torque)
    if below is not None:
        _check_below(below, count, along, across)
        found = [band.below(2 * pi * below) for band in (along, across)]
    else:
        wanted = _checked_count(DEFAULT_COUNT if count is None else count)
        found = [band.first_distinct(wanted) for band in (along, across)]
    bound = min(clear for _, clear in found)
    listed = sorted((mode for part, _ in found for mode in part), key=order_of)
    parts = [band.count(bound) for band in (along, across)]
    complete = all(
        sum(mode.multiplicity for mode in part if 2 * pi * mode.frequency < clear) == band.count(clear)
        for (part, clear), band in zip(found, (along, across), strict=True)
        if isfinite(clear)
    )
    highest = [_reached(clear, below) for _, clear in found]
    certificate = Certificate(
        below=_reached(bound, below),
        longitudinal_below=highest[0],
        transverse_below=highest[1] if isfinite(highest[1]) else _reached(bound, below),
        count=sum(parts),
        longitudinal=parts[0],
        transverse=parts[1],
    )
    proven = complete and all(mode.proven for mode in listed)
    limit = model_limit(drive, listed, across, bound)
    return Modes(
        modes=tuple(listed),
        certified=proven and limit is None,
        certified_reason=limit if proven else INCOMPLETE,
        warnings=mode_warnings(drive, listed, across, bound),
        at_torque=at_torque,
        certificate=certificate,
        rigid_body_modes=along.rigid_body_modes,
        drive_hash=content_hash(drive),
        motor=motor_condition(drive, motor),
        hold=tuple(sorted(held_joints(drive, hold))),
    )


def _reached(bound: float, below: float | None) -> float:
    """A bound [rad/s] in Hz: the one that was asked for, to the last digit, where it is that."""
    return below if below is not None and bound == 2 * pi * below else bound / (2 * pi)


def _of_routes(
    drive: RoutedDrive,
    below: float | None,
    count: int | None,
    motor: str | None,
    hold: Sequence[str],
    at_torque: float,
) -> Modes:
    """Modes of a machine with routes."""
    from cabledrive.modal.network.routed import routed_modes  # other machines do not wait for it

    if at_torque != 0.0:
        refuse_route("a steady torque (at_torque)")
    if below is not None:
        _check_below(below, count)
        return routed_modes(drive, below=below, motor=motor, hold=hold)
    return routed_modes(
        drive, count=_checked_count(DEFAULT_COUNT if count is None else count), motor=motor, hold=hold
    )


def _of_chain(chain: Chain, below: float | None, count: int | None, held: bool) -> Modes:
    """Modes of a chain that is built in Python, certified by the same count."""
    if held:
        raise InputRefused(
            "motor, hold and at_torque are about drives; a chain is held by its own fixed ends and grounds"
        )
    band = Band([own_chain(chain)], LONGITUDINAL)
    if below is not None:
        _check_below(below, count, band)
        found, bound = band.below(2 * pi * below)
    else:
        found, bound = band.first_distinct(_checked_count(DEFAULT_COUNT if count is None else count))
    number = band.count(bound)
    listed = sum(mode.multiplicity for mode in found if 2 * pi * mode.frequency < bound)
    proven = listed == number and all(mode.proven for mode in found)
    clear = _reached(bound, below)
    return Modes(
        modes=tuple(found),
        certified=proven,
        certified_reason=None if proven else INCOMPLETE,
        warnings=(),
        at_torque=0.0,
        certificate=Certificate(
            below=clear,
            longitudinal_below=clear,
            transverse_below=clear,
            count=number,
            longitudinal=number,
            transverse=0,
            enclosure=band.enclosure,
        ),
        rigid_body_modes=band.rigid_body_modes,
        drive_hash="",
        motor="free",
        hold=(),
    )


def natural_frequencies(
    drive: Drive | RoutedDrive,
    *,
    below: float | None = None,
    count: int | None = None,
    motor: str | None = None,
    hold: Sequence[str] = (),
) -> NDArray[np.float64]:
    """Longitudinal natural frequencies of a drive, each repeated by its multiplicity.

    Parameters
    ----------
    drive : Drive or RoutedDrive
    below : float, optional
        Upper end [Hz].
    count : int, optional
        The first so many instead (a multiple one at the end whole); ten where neither is given.
    motor, hold : optional
        How the rotor is held, and what else, see `modes`.

    Returns
    -------
    ndarray, shape (n,)
        Frequencies [Hz], ascending, without the rigid-body mode.

    Raises
    ------
    InputRefused, NotComputed
        As `modes`.
    """
    listed = longitudinal_modes(drive, below=below, count=count, motor=motor, hold=hold)
    return np.repeat([mode.frequency for mode in listed], [mode.multiplicity for mode in listed])


def longitudinal_modes(
    drive: Drive | RoutedDrive,
    *,
    below: float | None = None,
    count: int | None = None,
    motor: str | None = None,
    hold: Sequence[str] = (),
) -> tuple[Mode, ...]:
    """Longitudinal modes of a drive alone, without the transverse ones.

    Parameters
    ----------
    drive : Drive or RoutedDrive
    below : float, optional
        Upper end [Hz].
    count : int, optional
        The first so many instead (a multiple one at the end whole); ten where neither is given.
    motor, hold : optional
        How the rotor is held, and what else, see `modes`.

    Returns
    -------
    tuple of Mode
        Ascending, without the rigid-body mode.

    Raises
    ------
    InputRefused, NotComputed
        As `modes`.
    """
    if isinstance(drive, AxisDrive):
        drive = drive.machine
    if isinstance(drive, RoutedDrive):
        from cabledrive.modal.network.routed import routed_longitudinal

        if below is not None:
            _check_below(below, count)
        wanted = None if below is not None else _checked_count(DEFAULT_COUNT if count is None else count)
        return routed_longitudinal(drive, below=below, count=wanted, motor=motor, hold=hold)
    band = Band(longitudinal_chains(drive, motor=motor, hold=hold), LONGITUDINAL)
    if below is not None:
        _check_below(below, count, band)
        return tuple(band.below(2 * pi * below)[0])
    return tuple(band.first(_checked_count(DEFAULT_COUNT if count is None else count))[0])


def _checked_count(count: int) -> int:
    if not 0 < count <= MOST_MODES:
        raise InputRefused(
            f"count = {count} modes must lie between 1 and {MOST_MODES}: ask for fewer at a time"
        )
    return count


def _check_below(below: float, count: int | None, *bands: Band) -> None:
    if count is not None:
        raise InputRefused(f"below = {below:.9g} Hz and count = {count} are both given: give one of the two")
    if not (isfinite(below) and below > 0.0):
        raise InputRefused(f"below = {below:.9g} Hz must be positive and finite: give the upper end in Hz")
    if not LOWEST_BELOW <= below <= HIGHEST_BELOW:
        raise InputRefused(
            f"below = {below:.9g} Hz must lie between {LOWEST_BELOW:g} and {HIGHEST_BELOW:g} Hz: "
            "outside the range of machines"
        )
    held = sum(band.count(2 * pi * below) for band in bands)
    if held > MOST_MODES:
        about = below * MOST_MODES / held
        raise InputRefused(
            f"below = {below:.9g} Hz holds {held} modes, at most {MOST_MODES} are certified: "
            f"lower it to about {about:.3g} Hz"
        )
