"""The natural modes of a machine: every one below a frequency, with a certificate of completeness."""

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite, pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import Chain, own_chain
from cabledrive.mechanics.datasheet import warnings_of_rest
from cabledrive.mechanics.network import Network
from cabledrive.modal.mode import LONGITUDINAL, TRANSVERSE, Certificate, Modes
from cabledrive.modal.motion import Mode
from cabledrive.modal.networks import network_of_chain
from cabledrive.modal.ranges import ALLOWED, INCOMPLETE, lifted_limit, range_limit, route_range_warnings
from cabledrive.modal.route_network import network_at_rest, network_of_routes
from cabledrive.modal.search import ENCLOSURE
from cabledrive.modal.spectrum import Spectrum, order_of
from cabledrive.parameters import Drive, InputRefused, Machine, content_hash

DEFAULT_COUNT = 10
MOST_MODES = 20_000
MOST_CHECKED = 2_000
"""Modes of straight ropes among which those are looked for that sag moves."""
BEYOND = 1.5
"""Times the highest of them, up to where the same modes of ropes that hang are looked for."""
LOWEST_BELOW, HIGHEST_BELOW = 1e-30, 1e30


def modes(
    drive: Machine | Drive | Chain,
    *,
    below: float | None = None,
    count: int | None = None,
    motor: str | None = None,
    hold: Sequence[str] = (),
    at_torque: float = 0.0,
) -> Modes:
    """All natural modes of a drive below a frequency, or those of the first few frequencies of each kind.

    By the exact dynamic stiffness of every span about the state of rest (`cabledrive.mechanics.rest_state`),
    carriages as point masses: strings and rods where a span is straight, ropes about their catenaries where
    it sags, along and across together. Each mode has the kind of its larger strain energy. Above a frequency
    at which sag moves no mode by more than 1e-4 of it a rope counts as straight. Friction and dampings do
    not enter.

    Parameters
    ----------
    drive : Machine, Drive or Chain
        A `cabledrive.mechanics.Chain` has the modes of its one direction of motion, listed as longitudinal;
        its own springs and fixed ends say how it is held. Its segments may be different cables.
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
    drive = drive if isinstance(drive, Chain) else drive.machine
    if not isfinite(at_torque):
        raise InputRefused(f"at_torque = {at_torque} N m is not finite: give the steady torque in N m")
    spectrum, network = spectrum_of(drive, motor, hold, at_torque)
    listed = _listed(spectrum, below, count)
    if isinstance(drive, Chain) or network is None:
        return listed
    found = replace(_limited(listed, spectrum, network), at_torque=at_torque, drive_hash=content_hash(drive))
    slack = (f"{one}; its transverse modes are not listed" for one in spectrum.network.slack[:1])
    words = "without the torque " * bool(at_torque)
    at_rest = (f"{words}{line}" for line in warnings_of_rest(drive))
    return replace(found, warnings=(*found.warnings, *at_rest, *slack))


def spectrum_of(
    drive: Machine | Chain,
    motor: str | None = None,
    hold: Sequence[str] = (),
    at_torque: float = 0.0,
    taut: bool = False,
) -> tuple[Spectrum, Network | None]:
    """The modes of any machine, and its network; a chain has none."""
    if isinstance(drive, Chain):
        if motor is not None or hold or at_torque:
            raise InputRefused(
                "motor, hold and at_torque are about drives; a chain is held by its fixed ends and grounds"
            )
        return Spectrum(network_of_chain(own_chain(drive))), None
    held = (hold,) if isinstance(hold, str) else hold
    own, network = network_at_rest(drive, motor=motor, hold=held, at_torque=at_torque, taut=taut)
    return Spectrum(own), network


def straight_limit(network: Network, below: float, *, kind: str | None = None) -> str | None:
    """Why straight ropes are in doubt as a model of a machine below a frequency; None where they are not.

    ``below``: [rad/s]; ``kind``: of the modes that matter, {"longitudinal", "transverse"} or None for all.
    """
    spectrum = Spectrum(network_of_routes(network, hanging=False))
    number = spectrum.count(below)
    if number > MOST_CHECKED:
        said = f"straight ropes: {number} modes below {below / (2 * pi):.4g} Hz, more than {MOST_CHECKED}"
        return f"{said}: whether sag moves one was not checked"
    listed = [mode for mode in spectrum.below(below) if kind in (None, mode.kind)]
    return range_limit(network, listed) or _moved_by_sag(network, listed, spectrum)


def _moved_by_sag(network: Network, listed: Sequence[Mode], spectrum: Spectrum) -> str | None:
    """Why a list of straight ropes, part of a spectrum, is in doubt: where ropes hang a mode is elsewhere."""
    hanging = Spectrum(network_of_routes(network))
    edges = hanging.network.edges
    if not edges or not listed:
        return None
    top = min(2 * pi * max(mode.frequency for mode in listed) * (1.0 + ENCLOSURE), edges[-1])
    straight, truth = (
        np.repeat([m.frequency for m in found], [m.multiplicity for m in found])
        for found in (spectrum.below(top), hanging.below(BEYOND * top))
    )
    truth = np.append(truth, np.full(straight.size, np.inf))[: straight.size]
    moved = dict(zip(straight.tolist(), np.abs(truth / straight - 1.0).tolist(), strict=True))
    worst = max(listed, key=lambda mode: moved.get(mode.frequency, 0.0))
    error = moved.get(worst.frequency, 0.0)
    if error <= ALLOWED:
        return None
    return (
        f"sag, which is left out, moves the mode at {worst.frequency:.5g} Hz by {error:.2g} of it, more "
        f"than {ALLOWED:g}: raise the pretension"
    )


def _limited(listed: Modes, spectrum: Spectrum, network: Network) -> Modes:
    """A list of a machine, certified where its models hold."""
    slack = spectrum.network.slack
    limit = slack[0] if slack else lifted_limit(network) or range_limit(network, listed.modes)
    steep = [own.direction(start) for own in network.pieces for start in (True, False)]
    slope = max(abs(sine / cosine) for cosine, sine in steep)
    return replace(
        listed,
        certificate=replace(listed.certificate, slope=slope),
        certified=listed.certified and limit is None,
        certified_reason=limit if listed.certified else listed.certified_reason,
        warnings=tuple(route_range_warnings(network)),
        motor=network.motion.motor,
        hold=tuple(sorted(network.motion.hold)),
    )


def _listed(spectrum: Spectrum, below: float | None, count: int | None) -> Modes:
    """A list with its certificate, as if its models held."""
    wanted = _checked_count(below, count)
    if below is not None:
        top = _clear(spectrum, 2 * pi * below)
        found, tops = spectrum.below(top), (top, top)
    else:
        parts = spectrum.first(dict.fromkeys((LONGITUDINAL, TRANSVERSE), wanted), distinct=True)
        found = sorted((mode for own, _ in parts.values() for mode in own), key=order_of)
        tops = parts[LONGITUDINAL][1], parts[TRANSVERSE][1]
        top = _off_modes(spectrum, min(tops))
    along, across = (max(top, own) if isfinite(own) else top for own in tops)
    # bounds in Hz: the one that was asked for, to the last digit, where it is that
    hertz = [below if below and own == 2 * pi * below else own / (2 * pi) for own in (top, along, across)]
    number = spectrum.count(top)
    under = [mode for mode in found if 2 * pi * mode.frequency < top]
    held = {
        kind: sum(mode.multiplicity for mode in under if mode.kind == kind)
        for kind in (LONGITUDINAL, TRANSVERSE)
    }
    proven = sum(held.values()) == number and all(mode.proven for mode in found)
    return Modes(
        modes=tuple(found),
        certified=proven,
        certified_reason=None if proven else INCOMPLETE,
        warnings=(),
        at_torque=0.0,
        certificate=Certificate(
            below=hertz[0],
            longitudinal_below=hertz[1],
            transverse_below=hertz[2],
            count=number,
            longitudinal=held[LONGITUDINAL],
            transverse=number - held[LONGITUDINAL],
            enclosure=spectrum.enclosure,
        ),
        rigid_body_modes=spectrum.rigid_body_modes,
        drive_hash="",
        motor="free",
        hold=(),
    )


def _clear(spectrum: Spectrum, omega: float) -> float:
    """The frequency, or one just below it, at which the count does not depend on round-off [rad/s]."""
    held, below = spectrum.count(omega), omega / (2 * pi)
    if held > MOST_MODES:
        said = f"below = {below:.9g} Hz holds {held} modes, at most {MOST_MODES} are certified"
        raise InputRefused(f"{said}: lower it to about {below * MOST_MODES / held:.3g} Hz")
    return _off_modes(spectrum, omega)


def _off_modes(spectrum: Spectrum, omega: float) -> float:
    """As `_clear`, of a frequency to which few modes are known to lie [rad/s]."""
    step = 4 * ENCLOSURE
    while spectrum.count(omega * (1 - ENCLOSURE)) != spectrum.count(omega * (1 + ENCLOSURE)):
        omega, step = omega * (1 - step), 2 * step
    return omega


def natural_frequencies(
    drive: Machine | Drive,
    *,
    below: float | None = None,
    count: int | None = None,
    motor: str | None = None,
    hold: Sequence[str] = (),
    taut: bool = False,
) -> NDArray[np.float64]:
    """Longitudinal natural frequencies of a drive, each repeated by its multiplicity.

    Parameters
    ----------
    drive : Machine or Drive
    below : float, optional
        Upper end [Hz].
    count : int, optional
        The first so many instead (a multiple one at the end whole); ten where neither is given.
    motor, hold : optional
        How the rotor is held, and what else, see `modes`.
    taut : bool, default False
        Of a loop or line that is straight under its pretension alone, without weights, as formulas have it.

    Returns
    -------
    ndarray, shape (n,)
        Frequencies [Hz], ascending, without the rigid-body mode.

    Raises
    ------
    InputRefused, NotComputed
        As `modes`.
    """
    listed = longitudinal_modes(drive, below=below, count=count, motor=motor, hold=hold, taut=taut)
    return np.repeat([mode.frequency for mode in listed], [mode.multiplicity for mode in listed])


def longitudinal_modes(
    drive: Machine | Drive,
    *,
    below: float | None = None,
    count: int | None = None,
    motor: str | None = None,
    hold: Sequence[str] = (),
    taut: bool = False,
) -> tuple[Mode, ...]:
    """Longitudinal modes alone, ascending, without the rigid-body mode; as `natural_frequencies`."""
    spectrum, _ = spectrum_of(drive.machine, motor, hold, taut=taut)
    wanted = _checked_count(below, count)
    if below is None:
        return tuple(spectrum.first({LONGITUDINAL: wanted}, distinct=False)[LONGITUDINAL][0])
    found = spectrum.below(_clear(spectrum, 2 * pi * below))
    return tuple(mode for mode in found if mode.kind == LONGITUDINAL)


def _checked_count(below: float | None, count: int | None) -> int:
    """How many frequencies are asked for; 0 where the upper end is given [Hz]."""
    if below is None:
        count = DEFAULT_COUNT if count is None else count
        if not 0 < count <= MOST_MODES:
            raise InputRefused(
                f"count = {count} modes must lie between 1 and {MOST_MODES}: ask for fewer at a time"
            )
        return count
    if count is not None:
        raise InputRefused(f"below = {below:.9g} Hz and count = {count} are both given: give one of the two")
    if not (isfinite(below) and below > 0.0):
        raise InputRefused(f"below = {below:.9g} Hz must be positive and finite: give the upper end in Hz")
    if not LOWEST_BELOW <= below <= HIGHEST_BELOW:
        said = f"below = {below:.9g} Hz must lie between {LOWEST_BELOW:g} and {HIGHEST_BELOW:g} Hz"
        raise InputRefused(f"{said}: outside the range of machines")
    return 0
