"""Pairs near internal resonance of a machine with the modes that they are of, and its resonance by them."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from cabledrive.mechanics.network import Network, network_of
from cabledrive.mechanics.network.motion import ALONG
from cabledrive.mechanics.network.span_table import strained
from cabledrive.modal import Mode, Modes, modes
from cabledrive.modal.mode import LONGITUDINAL, TRANSVERSE
from cabledrive.modal.route_network import network_of_routes
from cabledrive.modal.spectrum import Spectrum
from cabledrive.modal.tuning import Pair
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.route import Machine, RoutedDrive
from cabledrive.parameters.route.two_pulleys import as_machine
from cabledrive.reduction.waves import waves_of
from cabledrive.studies import pair_thresholds as near
from cabledrive.studies.resonance_detuning import (
    CLOSE_SHARE,
    FAILED,
    REACH,
    SAFE,
    Remedy,
    ResonanceSummary,
    acting_torque,
    first_safe,
    verdict_of,
)

NOT_INCLUDED = "Coulomb friction of shafts and rails, motion of bodies beyond small angles"
MISSING = {
    "threshold_torque": "no pair that the first motor excites is near",
    "threshold_here": "no pair that the first motor excites is near",
    "growth_torque": "is of one cable between two pulleys",
    "coulomb_onset": "Coulomb friction is not included on a machine with routes",
}
_SETTLED, _PASSES = 1e-6, 12
_TURNING = 1e-6
"""Share of the kinetic energy from which a pulley turns in a mode."""
_STRETCHES = 0.1
"""Share of its strain energy in stretch from which a mode across, of a rope that hangs, can excite others."""
_SHORT = 1.0 / 40.0
"""Length of a section over the longest below which its pairs with the pulley mode are not listed as such."""


class MachinePairs(NamedTuple):
    """Pairs near resonance of a machine, and the modes that they are of."""

    pairs: tuple[near.NearPair, ...]
    pulley: Mode  # the first longitudinal mode in which a pulley turns
    nearest: Mode  # of the lowest transverse mode of each span the one nearest to 1:2
    modes: Modes

    @property
    def doubt(self) -> tuple[str, ...]:
        """Why the modes are in doubt."""
        reason = self.modes.certified_reason
        return (f"modes not certified: {reason}",) if reason else ()


def machine_pairs(drive: Machine, tunings: Sequence[Pair] = ()) -> MachinePairs:
    """Pairs near 1:2 and of sum type, and all with ``tunings``, of a machine whose ropes do not run."""
    machine = as_machine(drive, turned=True)
    near.refuse_running(machine, "a pair of modes")
    network = network_of(machine)
    pulley, lowest = _first_modes(network)
    nearest = min(lowest.values(), key=lambda mode: abs(mode.frequency / pulley.frequency - 0.5))
    longest = max((one.section[1] - one.section[0] for one in tunings), default=0.0)
    tunings = [one for one in tunings if one.section[1] - one.section[0] >= _SHORT * longest]
    highest = near.HIGHEST * pulley.frequency
    most = max((one.transverse_frequency for one in tunings), default=0.0)
    found = modes(machine, below=max(highest, most) * 1.0001)
    stretching = [
        mode
        for mode in found.modes
        if not mode.clamped
        and mode.frequency <= highest
        and (
            mode.kind == LONGITUDINAL
            or sum(own for (_, way, _), own in mode.places.items() if way == ALONG) > _STRETCHES
        )
    ]
    reach = max((1.0 + near.NEAR) * max(mode.frequency for mode in stretching), most * 1.0001)
    across = [mode for mode in found.transverse if mode.frequency <= reach]
    waves = waves_of(network, stretching, across, hanging=True)
    pairs = near.pairs_of(waves, drive.spans, pulley.frequency, tunings)
    return MachinePairs(pairs, pulley, nearest, found)


def _first_modes(network: Network) -> tuple[Mode, dict[str, Mode]]:
    """The first longitudinal mode in which a pulley turns, and the first across each span that has one."""
    spectrum, names = Spectrum(network_of_routes(network)), {one.name for one in network.drive.pulley}
    along = (
        one for n in (1, 10) for one in spectrum.first({LONGITUDINAL: n}, distinct=True)[LONGITUDINAL][0]
    )
    shares = ((one, one.kinetic_shares) for one in along)
    turning = (one for one, own in shares if any(own.get(name, 0.0) > _TURNING for name in names))
    pulley = next(turning, None)
    if pulley is None:
        raise InputRefused("no pulley turns in the first longitudinal modes: there is no pulley mode to tune")
    lowest: dict[str, Mode] = {}
    for mode in spectrum.first({TRANSVERSE: 10}, distinct=True)[TRANSVERSE][0]:
        lowest.setdefault(mode.span or "", mode)
    return pulley, lowest


def at_pretensions(drive: Machine, factor: float) -> Any:
    """The machine with all pretensions of its file times a factor."""

    def own(rope: Any) -> Any:
        stated = rope is not None and rope.pretension is not None
        return replace(rope, pretension=factor * rope.pretension) if stated else rope

    cable: Any = own(drive.cable)
    if isinstance(drive, RoutedDrive):
        return replace(drive, cable=cable, route=tuple(map(own, drive.route)))
    return replace(drive, cable=cable)


def pretension_of(machine: RoutedDrive, span: str) -> float:
    """Pretension that the file gives the rope of a span [N]; refused where it gives none."""
    number = next(own.route for own in machine.free_spans if own.name == span)
    if (pretension := machine.ropes[number].pretension) is None:
        raise InputRefused(f"no pretension is given for the rope of {span}: weights and springs make it")
    return pretension


def tuning_factor(machine: RoutedDrive, span: str) -> float:
    """Factor of all pretensions at which the first mode across a span has half the pulley mode's frequency.

    Refused where weights or springs make the tension, or no rope bears it.
    """
    factor = 1.0
    for _ in range(_PASSES):
        pulley, lowest = _first_modes(network_of(at_pretensions(machine, factor)))
        if span not in lowest:
            break
        ratio = lowest[span].frequency / pulley.frequency
        if abs(ratio - 0.5) <= _SETTLED:
            if line := next(strained(at_pretensions(machine, factor)), ""):
                need = factor * pretension_of(machine, span)
                raise InputRefused(f"the rope of {span} would need {need:.4g} N: {line}")
            return factor
        factor *= (0.5 / ratio) ** 2
    raise InputRefused(f"no pretension tunes {span}: weights and springs make most of its tension")


def resonance_of_pairs(
    machine: RoutedDrive, torque: float | None, *, details: bool = True
) -> ResonanceSummary:
    """Resonance by the thresholds of pairs alone, under an amplitude of the torque [N m].

    ``details``: whether to look for the tuned pretension, of the rope of the span nearest to 1:2, with all
    others in proportion, and the threshold there.
    """
    drive = as_machine(machine, turned=True)
    acting, found = acting_torque(drive, torque), machine_pairs(drive)
    thresholds = [(pair.longitudinal_hz, pair.threshold_torque) for pair in found.pairs]
    verdict, reasons = verdict_of(acting, thresholds)
    ratio = found.nearest.frequency / found.pulley.frequency
    here = min((torque for _, torque in thresholds if torque is not None), default=None)
    span, missing, tuned, at_tuning = found.nearest.span or "", dict(MISSING), None, None
    try:
        if not details:
            raise InputRefused("not asked for")
        tuned = pretension_of(drive, span) * (factor := tuning_factor(drive, span))
        tuned_pairs = machine_pairs(at_pretensions(drive, factor))
        own = (
            pair.threshold_torque
            for pair in tuned_pairs.pairs
            if near.alike(pair.longitudinal_hz, tuned_pairs.pulley.frequency)
        )
        at_tuning = min((torque for torque in own if torque is not None), default=None)
    except (InputRefused, NotComputed) as refusal:
        missing |= dict.fromkeys(("tuned_pretension", "threshold_torque"), str(refusal))
    return ResonanceSummary(
        pairs=found.pairs,
        pulley_frequency=found.pulley.frequency,
        nearest_span=span,
        tuned_pretension=tuned,
        threshold_here=here,
        frequency_ratio=ratio,
        detuning=ratio - 0.5,
        motor=found.modes.motor,
        certified=found.modes.certified,
        left_out=(f"not included: {NOT_INCLUDED}", *found.doubt),
        threshold_torque=at_tuning,
        torque=None if acting is None else acting.amplitude,
        verdict=verdict,
        reasons=reasons,
        missing=missing,
    )


_FEW = 12
"""Pretensions tried of a machine whose pairs take long."""


def pair_remedies(machine: RoutedDrive, found: ResonanceSummary) -> tuple[Remedy, ...]:
    """Changes, each by itself, that make a machine safe that by one of its pairs is not."""

    def safe(trial: RoutedDrive) -> bool:
        try:
            judged = resonance_of_pairs(trial, found.torque, details=False)
            return judged.verdict == SAFE and not any(strained(trial))
        except (InputRefused, NotComputed):
            return False

    changes, span = list[Remedy](), found.nearest_span or ""
    for words, sign in (("raise", 1.0), ("lower", -1.0)):
        share = first_safe(partial(_at_share, machine, sign), safe, _FEW)
        if share is None:
            text = f"{FAILED}: to {words} all pretensions, to x{(1.0 + REACH) ** sign:.3g}"
            changes.append(Remedy(change=f"{words} pretension", value=None, text=text))
            continue
        factor = (1.0 + share) ** sign
        try:
            value = factor * pretension_of(machine, span)
        except InputRefused:  # its tension is made by weights, that of another rope by the file
            value = factor
        text = (
            f"{words} all pretensions by {100.0 * abs(factor - 1.0):.3g} %, that of {span} to {value:.4g} N"
        )
        changes.append(Remedy(change=f"{words} pretension", value=value, text=text))
    lowest = found.threshold_here or 0.0
    text = f"keep the torque at the frequencies of the pairs below {CLOSE_SHARE * lowest:.3g} N m"
    return (*changes, Remedy(change="limit torque", value=CLOSE_SHARE * lowest, text=text))


def _at_share(machine: RoutedDrive, sign: float, share: float) -> RoutedDrive:
    changed: RoutedDrive = at_pretensions(machine, (1.0 + share) ** sign)
    return changed
