"""Pairs near internal resonance of a machine with the modes that they are of, and its resonance by them."""

from collections.abc import Sequence
from typing import NamedTuple

from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.motion import ALONG
from cabledrive.modal import Mode, Modes, modes
from cabledrive.modal.mode import LONGITUDINAL
from cabledrive.modal.tuning import Pair, at_pretensions, first_modes, pretension_of, tuning_factor
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.route import Machine, RoutedDrive
from cabledrive.parameters.route.two_pulleys import as_machine
from cabledrive.reduction.waves import waves_of
from cabledrive.studies import pair_thresholds as near
from cabledrive.studies.resonance_detuning import ResonanceSummary, acting_torque, verdict_of

NOT_INCLUDED = "Coulomb friction of shafts and rails, motion of bodies beyond small angles"
MISSING = {
    "threshold_torque": "no pair that the first motor excites is near",
    "threshold_here": "no pair that the first motor excites is near",
    "growth_torque": "is of one cable between two pulleys",
    "coulomb_onset": "Coulomb friction is not included on a machine with routes",
}
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
    pulley, lowest = first_modes(network)
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
