"""Pairs near internal resonance of a machine with the modes that they are of, and its resonance by them."""

from collections.abc import Sequence
from typing import NamedTuple

from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.motion import ALONG
from cabledrive.modal import Mode, Modes, modes
from cabledrive.modal.mode import LONGITUDINAL, TRANSVERSE
from cabledrive.modal.route_network import network_of_routes
from cabledrive.modal.spectrum import Spectrum
from cabledrive.modal.tuning import Pair
from cabledrive.parameters import InputRefused
from cabledrive.parameters.route import Machine
from cabledrive.parameters.route.two_pulleys import as_machine
from cabledrive.reduction.waves import waves_of
from cabledrive.studies import pair_thresholds as near
from cabledrive.studies.resonance_detuning import ResonanceSummary, acting_torque, verdict_of

NOT_INCLUDED = "Coulomb friction of shafts and rails, motion of bodies beyond small angles"
MISSING = {
    **dict.fromkeys(
        ("tuned_pretension", "threshold_here", "growth_torque"),
        "on a machine with routes the tensions follow from statics",
    ),
    "threshold_torque": "no pair that the first motor excites is near",
    "coulomb_onset": "Coulomb friction is not included on a machine with routes",
}
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
    network, names = network_of(machine), {one.name for one in machine.pulley}
    spectrum = Spectrum(network_of_routes(network))
    along = (
        one for n in (1, 10) for one in spectrum.first({LONGITUDINAL: n}, distinct=True)[LONGITUDINAL][0]
    )
    shares = ((one, one.kinetic_shares) for one in along)
    turning = (one for one, own in shares if any(own.get(name, 0.0) > _TURNING for name in names))
    pulley = next(turning, None)
    if pulley is None:
        raise InputRefused("no pulley turns in the first longitudinal modes: there is no pulley mode to tune")
    lowest: dict[str, Mode] = {}  # of each span, across
    for mode in spectrum.first({TRANSVERSE: 10}, distinct=True)[TRANSVERSE][0]:
        lowest.setdefault(mode.span or "", mode)
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


def resonance_of_pairs(drive: Machine, torque: float | None) -> ResonanceSummary:
    """Resonance by the thresholds of pairs alone, under an amplitude of the torque [N m]."""
    acting, found = acting_torque(drive, torque), machine_pairs(drive)
    thresholds = [(pair.longitudinal_hz, pair.threshold_torque) for pair in found.pairs]
    verdict, reasons = verdict_of(acting, thresholds)
    ratio = found.nearest.frequency / found.pulley.frequency
    return ResonanceSummary(
        pairs=found.pairs,
        pulley_frequency=found.pulley.frequency,
        nearest_span=found.nearest.span or "",
        frequency_ratio=ratio,
        detuning=ratio - 0.5,
        motor=found.modes.motor,
        certified=found.modes.certified,
        left_out=(f"not included: {NOT_INCLUDED}", *found.doubt),
        threshold_torque=min((torque for _, torque in thresholds if torque is not None), default=None),
        torque=None if acting is None else acting.amplitude,
        verdict=verdict,
        reasons=reasons,
        missing=MISSING,
    )
