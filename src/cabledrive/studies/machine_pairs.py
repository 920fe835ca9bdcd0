"""Pairs near internal resonance of a machine with the modes that they are of, and its resonance by them."""

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.motion import ALONG
from cabledrive.modal import Mode, Modes, modes
from cabledrive.modal.mode import LONGITUDINAL, TRANSVERSE
from cabledrive.modal.tuning import Pair, at_pretensions, first_modes, pretension_of, tuning_factor
from cabledrive.parameters import InputRefused, Machine, NotComputed
from cabledrive.parameters.fields import LARGEST
from cabledrive.reduction.threshold import NEAR, SAFE, joint_threshold
from cabledrive.reduction.waves import waves_of
from cabledrive.studies import pair_thresholds as near
from cabledrive.studies.resonance_detuning import ResonanceSummary, acting_torque, verdict_of

NOT_INCLUDED = "Coulomb friction of shafts and rails, motion of bodies beyond small angles"
MISSING = {
    "threshold_torque": "no pair that the first motor excites is near",
    "threshold_here": "no pair that the first motor excites is near",
    "growth_torque": "is of one straight cable between two pulleys",
    "coulomb_onset": "Coulomb friction is included for one straight cable between two pulleys",
}
SLACKENS = "from {:.4g} N m of steady torque at {:.4g} Hz on a rope goes slack"
_STRETCHES = 0.1
"""Share of its strain energy in stretch from which a mode across, of a rope that hangs, can excite others."""
_APART = 0.95
"""Share of the lowest threshold of pairs below which modes near each other are said to grow together."""
_STRONG = 0.3
"""Share of its tension by which a rope swings from which a threshold, of first order in it, is in doubt."""
_SHORT = 1.0 / 40.0
"""Length of a section over the longest below which its pairs with the pulley mode are not listed as such."""


class MachinePairs(NamedTuple):
    """Pairs near resonance of a machine, and the modes that they are of."""

    # longitudinal frequency [Hz], and torque from which pairs of modes near each other grow together [N m]
    together: tuple[tuple[float, float], ...]
    pairs: tuple[near.NearPair, ...]
    pulley: Mode  # the first longitudinal mode in which a pulley turns
    nearest: Mode  # of the lowest transverse mode of each span the one nearest to 1:2
    # longitudinal frequency [Hz] and torque there that slackens a rope [N m], of all that the motor turns in
    slack: tuple[tuple[float, float], ...]
    modes: Modes

    @property
    def doubt(self) -> tuple[str, ...]:
        """Why the modes are in doubt."""
        reason = self.modes.certified_reason
        found = (
            f"modes across grow together: at {hertz:.4g} Hz from {torque:.4g} N m on, earlier than any "
            "listed pair of that frequency by itself"
            for hertz, torque in self.together
        )
        slack = dict(self.slack)
        swings = (
            (own, own / slack[hertz], hertz) for hertz, own in self.thresholds if own and hertz in slack
        )
        strong = (
            f"thresholds are of first order in the swing of tension, {share:.0%} of it at {torque:.4g} N m "
            f"and {hertz:.4g} Hz: they may be off, and modes across near that frequency may grow earlier"
            for torque, share, hertz in sorted(own for own in swings if own[1] > _STRONG)[:1]
        )
        across = {mode.frequency for mode in self.modes.modes if mode.kind == TRANSVERSE}
        bent = (
            f"from {torque:.4g} N m at {hertz:.4g} Hz on: ropes vibrate mostly across there, which stiffens "
            "them and is left out, so that growth may begin later"
            for torque, hertz in sorted((own, at) for at, own in self.thresholds if own and at in across)[:1]
        )
        return (*found, *strong, *bent, *((f"modes not certified: {reason}",) if reason else ()))

    @property
    def thresholds(self) -> list[tuple[float, float | None]]:
        """Longitudinal frequency [Hz] and threshold torque [N m] of pairs, by themselves and together."""
        return [*self.together, *((pair.longitudinal_hz, pair.threshold_torque) for pair in self.pairs)]


def machine_pairs(drive: Machine, tunings: Sequence[Pair] = ()) -> MachinePairs:
    """Pairs near 1:2 and of sum type, and all with ``tunings``, of a machine whose ropes do not run."""
    machine = drive.plain
    near.refuse_running(machine, "a pair of modes")
    network = network_of(machine)
    pulley, lowest = first_modes(network)
    nearest = min(lowest.values(), key=lambda mode: abs(mode.frequency / pulley.frequency - 0.5))
    longest = max((one.section[1] - one.section[0] for one in tunings), default=0.0)
    tunings = [one for one in tunings if one.section[1] - one.section[0] >= _SHORT * longest]
    highest = near.HIGHEST * pulley.frequency
    most = max((one.transverse_frequency for one in tunings), default=0.0)
    found = modes(machine, below=max(highest, most) * 1.0001)
    listed = [own for mode in found.modes for own in mode.single]
    stretching = [
        mode
        for mode in listed
        if not mode.clamped
        and mode.frequency <= highest
        and (
            mode.kind == LONGITUDINAL
            or sum(own for (_, way, _), own in mode.places.items() if way == ALONG) > _STRETCHES
        )
    ]
    reach = max((1.0 + near.NEAR) * max(mode.frequency for mode in stretching), most * 1.0001)
    across = [mode for mode in listed if mode.kind == TRANSVERSE and mode.frequency <= reach]
    beside = [  # which dampings tie to them
        mode
        for mode in listed
        if not (mode.clamped or mode.plane == "v" or mode in stretching)
        and any(abs(mode.frequency - own.frequency) < near.NEAR * own.frequency for own in stretching)
    ]
    waves, count = waves_of(network, [*stretching, *beside], across, hanging=True), len(stretching)
    pairs = near.pairs_of(waves, drive.spans, pulley.frequency, tunings, count)
    slack = [(mode.frequency, float(waves.slack_torques[i])) for i, mode in enumerate(stretching)]
    together = list[tuple[float, float]]()
    for number, (hertz, most) in enumerate(slack):
        most = min([most, *(_APART * pair.least for pair in pairs if pair.longitudinal_hz == hertz)])
        if 0.0 < most < LARGEST and (joint := joint_threshold(waves, number, most)) < inf:
            together.append((hertz, joint))
    slack = [own for own in slack if own[1] < LARGEST]
    return MachinePairs(tuple(together), pairs, pulley, nearest, tuple(slack), found)


def resonance_of_pairs(drive: Machine, torque: float | None, *, details: bool = True) -> ResonanceSummary:
    """Resonance by the thresholds of pairs alone, under an amplitude of the torque [N m].

    ``details``: whether to look for the tuned pretension, of the rope of the span nearest to 1:2, with all
    others in proportion, and the threshold there.
    """
    acting, found = acting_torque(drive, torque), machine_pairs(drive)
    verdict, reasons = verdict_of(acting, found.thresholds)
    reached = [own for own in found.slack if acting is not None and acting.reaches(own[0]) is not None]
    if found.slack:
        hertz, slack = min(reached or found.slack, key=lambda own: own[1])
        reasons = (*reasons, SLACKENS.format(slack, hertz))
        pushed = acting.amplitude or 0.0 if acting is not None and reached else 0.0
        verdict = NEAR if verdict == SAFE and pushed >= slack else verdict
    ratio = found.nearest.frequency / found.pulley.frequency
    here = min((torque for _, torque in found.thresholds if torque is not None), default=None)
    machine = drive.plain
    number = machine.spans.index(found.nearest.span or "")
    missing, tuned, at_tuning = dict(MISSING), None, None
    try:
        if not details:
            raise InputRefused("not asked for")
        tuned = pretension_of(machine, number) * (factor := tuning_factor(drive, number))
        there = machine_pairs(at_pretensions(drive, factor))
        hertz = there.pulley.frequency
        own = [torque for own, torque in there.thresholds if torque is not None and near.alike(own, hertz)]
        at_tuning = min(own, default=None)
    except (InputRefused, NotComputed) as refusal:
        missing |= dict.fromkeys(("tuned_pretension", "threshold_torque"), str(refusal))
    return ResonanceSummary(
        pairs=found.pairs,
        pulley_frequency=found.pulley.frequency,
        nearest_span=drive.spans[number],
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
