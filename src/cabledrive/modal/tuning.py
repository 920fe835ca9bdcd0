r"""How far a drive is from the 1:2 resonance, and the pretension that would bring it there.

With the cable's mass and unstretched lengths kept, longitudinal frequencies do not depend on the
pretension and transverse ones are proportional to :math:`\sqrt{R}`, :math:`R = T_0/(1+\varepsilon_0)`,
carried masses included. The tuned pretension is therefore explicit,

.. math:: R^* = R\,\Big(\frac{f_p}{2 f_t}\Big)^2, \qquad T_0^* = \frac{R^*}{1 - R^*/EA},
          \qquad \text{Eq. (A.4)}

and does not exist where :math:`R^* \ge EA`. A drive given by its pulley distance is cut to another length at
every pretension; there the formula is repeated until it stands. Weights on a slope and carriages add to the
tension of each section what no pretension changes; there the same formula gives the tension that the section
needs, and the pretension follows by as much, again until it stands. Of any machine all pretensions of the
file are scaled, its geometry kept, until the first mode across one span has half the frequency.
"""

from dataclasses import dataclass, replace
from functools import cache, lru_cache
from math import exp, log, pi
from typing import Any

import numpy as np

from cabledrive.mechanics.chain import LabelledChain
from cabledrive.mechanics.holding import DRIVE_PULLEY, LOAD_PULLEY, MOTOR
from cabledrive.mechanics.network import Network, network_of
from cabledrive.mechanics.network.span_table import strained
from cabledrive.mechanics.rest import rest_state
from cabledrive.mechanics.spans import transverse_chains
from cabledrive.modal.elements import ACROSS, ALONG
from cabledrive.modal.mode import LONGITUDINAL, TRANSVERSE
from cabledrive.modal.motion import Mode
from cabledrive.modal.networks import network_of_chain
from cabledrive.modal.route_network import network_at_rest, network_of_routes
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters import Drive, InputRefused, Machine, NotComputed
from cabledrive.parameters.arrays import Array

TURNING = 1e-6
"""Rim displacement, relative to a rigid motion of all masses, above which a pulley turns in a mode."""

HIGHEST_SEARCHED = 200
FEWEST_NUMBERS, MOST_NUMBERS = 3, 12
SETTLED = 1e-11
"""Relative change of the pretension at which the search for a tuned section at rest ends."""

_PASSES = 60


@dataclass(frozen=True, kw_only=True, eq=False)
class PulleyMode:
    """The lowest longitudinal mode of the taut drive in which a pulley turns."""

    omega: float  # natural frequency [rad/s]
    mode: Mode
    shape: int  # which of its shapes turns the pulleys most


@dataclass(frozen=True, kw_only=True, eq=False)
class Pair:
    """A transverse mode beside the pulley mode."""

    span: str  # {"upper", "lower"}
    section: tuple[float, float]  # unstretched ends of the vibrating section [m]
    number: int  # number m of the transverse mode of its section, from 1
    # transverse_frequency, pulley_frequency: [Hz]
    transverse_frequency: float
    pulley_frequency: float
    ratio: float  # transverse over pulley frequency
    tuned_pretension: float | None  # pretension that makes the ratio one half [N]
    reason: str = ""  # why there is none


@lru_cache(maxsize=8)  # a resonance asks for that of one drive several times
def pulley_mode(drive: Drive) -> PulleyMode:
    """Find the lowest longitudinal mode in which a pulley turns; refused if none can."""
    if all(pulley.fixed for pulley in drive.pulley):
        raise InputRefused(
            "pulley.0.fixed and pulley.1.fixed are true: no pulley turns, there is no pulley mode; free one"
        )
    spectrum = Spectrum(network_at_rest(drive.machine, taut=True)[0])
    seen, wanted = 0, 2
    while seen < HIGHEST_SEARCHED:
        found = spectrum.first({LONGITUDINAL: wanted}, distinct=False)[LONGITUDINAL][0]
        for mode in found[seen:]:
            rims = [mode.joints[name] for name in (DRIVE_PULLEY, LOAD_PULLEY) if name in mode.joints]
            turning = np.asarray(np.sqrt(mode.mass * np.sum(np.square(rims), axis=0)))
            if np.max(turning) > TURNING:
                return PulleyMode(omega=2 * pi * mode.frequency, mode=mode, shape=int(np.argmax(turning)))
        seen, wanted = len(found), 2 * wanted
    raise InputRefused(
        f"no pulley turns in the {seen} lowest longitudinal modes: there is no pulley mode in range"
    )


def rims_of(mode: Mode, shape: int = 0) -> Array:
    """Displacement of drive pulley, load pulley and motor, on a rigid joint as its pulley, shape (3,)."""
    at = {name: float(values[shape]) for name, values in mode.joints.items()}
    rim = at.get(DRIVE_PULLEY, 0.0)
    return np.array([rim, at.get(LOAD_PULLEY, 0.0), at.get(MOTOR, rim)])


def span_frequency(drive: Drive) -> float:
    """Lowest transverse frequency of an empty span, c_w / (2 Le), whatever it carries [Hz]."""
    return drive.cable.transverse_wave_speed / (2.0 * drive.pulley_distance)


def tuned_pretension(drive: Drive) -> float:
    r"""Pretension that tunes an empty span's lowest mode to half the pulley mode, Eq. (A.4).

    Returns [N].
    Raises `InputRefused` if no pulley can turn, or no pretension reaches the ratio.
    """
    rigidity, current = drive.cable.axial_rigidity, drive
    for _ in range(_PASSES):  # the formula, to a standstill where the unstretched length is not given
        cable = current.cable
        force = cable.pretension / (1.0 + cable.prestrain)
        wanted = force * (pulley_mode(current).omega / (4 * pi * span_frequency(current))) ** 2
        if wanted >= rigidity:
            raise InputRefused(_no_tuning(wanted, rigidity))
        tension = wanted / (1.0 - wanted / rigidity)
        done = abs(tension - cable.pretension) <= 1e-14 * tension
        if done or drive.layout.span_length is not None:
            return tension
        current = replace(current, cable=replace(cable, pretension=tension))
    raise InputRefused(
        "no pretension tunes this pair: the search for it does not settle; give layout.span_length"
    )


def resonant_pairs(drive: Drive, numbers: int | None = None) -> tuple[Pair, ...]:
    """Each transverse mode at rest beside the pulley mode: ratio, and the pretension that tunes it to 1:2.

    ``numbers``: how many transverse modes of each section; by default three, or as many as reach half the
    frequency of the pulley mode, up to `MOST_NUMBERS`.
    Returns section after section, each ascending in frequency; both planes of a pair tune together.
    Raises `InputRefused` if no pulley can turn; `NotComputed` if a section hangs slack at rest.
    """
    pulley = pulley_mode(drive).omega / (2 * pi)
    pairs = []
    for place, chain in enumerate(transverse_chains(drive, rest=rest_state(drive))):
        section = (chain.stretches[0].start, chain.stretches[-1].end)
        turns = pulley * float(chain.chain.travel_times.sum())  # up to half the pulley mode
        kept = numbers or max(FEWEST_NUMBERS, min(MOST_NUMBERS, int(turns + 1.0)))
        for number, omega in enumerate(section_frequencies(chain, kept), start=1):
            tuned, reason = None, ""
            try:
                tuned = _tuned_at_rest(drive, place, number)
            except (InputRefused, NotComputed) as refusal:
                reason = str(refusal)
            pairs.append(
                Pair(
                    span=chain.stretches[0].span,
                    section=section,
                    number=number,
                    transverse_frequency=omega / (2 * pi),
                    pulley_frequency=pulley,
                    ratio=omega / (2 * pi) / pulley,
                    tuned_pretension=tuned,
                    reason=reason,
                )
            )
    return tuple(pairs)


def section_frequencies(chain: LabelledChain, numbers: int) -> list[float]:
    """Lowest transverse frequencies of one section [rad/s]."""
    return [2 * pi * mode.frequency for mode in section_modes(chain, numbers)]


def section_modes(chain: LabelledChain, numbers: int) -> list[Mode]:
    """Lowest transverse modes of one section."""
    spectrum = Spectrum(network_of_chain(chain, ACROSS))
    return spectrum.first({TRANSVERSE: numbers}, distinct=False)[TRANSVERSE][0][:numbers]


def _tuned_at_rest(drive: Drive, place: int, number: int) -> float:
    """Pretension that tunes one mode of a section at rest: what its own tension lacks is added to it."""
    rigidity, current = drive.cable.axial_rigidity, drive
    for _ in range(_PASSES):
        string = transverse_chains(current, rest=rest_state(current))[place]
        own, force = section_frequencies(string, number)[number - 1], float(string.chain.rigidity)
        wanted = force * (pulley_mode(current).omega / (2 * own)) ** 2
        if wanted >= rigidity:
            raise InputRefused(_no_tuning(wanted, rigidity))
        lacking = wanted / (1.0 - wanted / rigidity) - force / (1.0 - force / rigidity)
        tension = current.cable.pretension + lacking
        if abs(lacking) <= SETTLED * tension:
            return current.cable.pretension
        if tension <= 0.0:
            raise InputRefused(
                "no pretension tunes this pair: the weights alone hold the section tighter than that"
            )
        current = replace(current, cable=replace(current.cable, pretension=tension))
    raise InputRefused("no pretension tunes this pair: the search for it does not settle")


def _no_tuning(wanted: float, rigidity: float) -> str:
    return (
        f"no pretension tunes this pair: T0/(1 + eps0) = {wanted:.4g} N would have to reach "
        f"EA = {rigidity:.4g} N; make a pulley heavier"
    )


_TURNING = 1e-6
"""Share of the kinetic energy from which a pulley turns in a mode."""
_STRETCHES, _MAINLY = 0.1, 0.25
"""Share of the strain energy along ropes, and of the kinetic energy in pulleys, from which a mode is one of
pulleys though most of its strain is across."""
_SETTLED, _VEERS = 1e-6, 0.02
"""Of the logarithm of the pretension, where the search ends; of that of the ratio, by which modes veer."""


def first_modes(network: Network) -> tuple[Mode, dict[str, Mode]]:
    """The first mode in which a pulley turns and stretches ropes, and the first across each span."""
    spectrum, names = Spectrum(network_of_routes(network)), {one.name for one in network.drive.pulley}

    def turns(mode: Mode) -> bool:
        along = sum(own for (_, way, _), own in mode.places.items() if way == ALONG)
        own = [share for one, share in mode.kinetic_shares.items() if one in names]
        swings = sum(share for one, share in mode.kinetic_shares.items() if one.endswith(f" {ACROSS}"))
        stretches = mode.kind == LONGITUDINAL or (along > _STRETCHES and sum(own) > _MAINLY)
        return stretches and max(own, default=0.0) > _TURNING and swings <= sum(own)

    for count in (1, 10):
        found = spectrum.first({LONGITUDINAL: count, TRANSVERSE: 10}, distinct=True)
        modes = sorted((mode for own, _ in found.values() for mode in own), key=lambda mode: mode.frequency)
        pulley = next(filter(turns, modes), None)
        if pulley is not None and 2 * pi * pulley.frequency <= found[LONGITUDINAL][1]:
            break
    if pulley is None:
        raise InputRefused("no pulley turns in the first longitudinal modes: there is no pulley mode to tune")
    lowest: dict[str, Mode] = {}
    for mode in found[TRANSVERSE][0]:
        lowest.setdefault(mode.span or "", mode)
    return pulley, lowest


def at_pretensions(machine: Machine, factor: float) -> Machine:
    """The machine with all pretensions of its file times a factor."""

    def own(rope: Any) -> Any:
        stated = rope is not None and rope.pretension is not None
        return replace(rope, pretension=factor * rope.pretension) if stated else rope

    listed: Any = machine.listed
    routes = {"route": tuple(map(own, listed.route))} if listed.route else {}
    changed: Machine = replace(listed, cable=own(listed.cable), **routes).machine
    return changed


def pretension_of(machine: Machine, number: int) -> float:
    """Pretension that the file gives the rope of a span [N]; refused where it gives none."""
    span = machine.free_spans[number]
    if (pretension := machine.ropes[span.route].pretension) is None:
        raise InputRefused(f"no pretension is given for the rope of {span.name}: weights and springs make it")
    return pretension


def tuning_factor(drive: Machine, number: int) -> float:
    """Factor of all pretensions at which the first mode across a span has half the pulley mode's frequency.

    Refused where weights or springs make the tension, or no rope bears it.
    """
    from scipy.optimize import brentq

    span = drive.spans[number]
    none = InputRefused(f"no pretension tunes {span}: weights and springs make most of its tension")

    def at(power: float) -> Machine:
        return at_pretensions(drive, exp(power))

    @cache
    def off(power: float) -> float:
        """Logarithm of twice the ratio, by that of the factor."""
        pulley, lowest = first_modes(network_of(at(power)))
        if span not in lowest:
            raise none
        return log(2.0 * lowest[span].frequency / pulley.frequency)

    before, here = 0.0, -2.0 * off(0.0)  # of a straight rope without weights the answer
    while abs(off(here)) > _SETTLED and off(here) * off(before) > 0.0:
        if abs(off(here)) > 0.5 * abs(off(before)):
            raise none
        before, here = here, here - 2.0 * off(here)
    if abs(off(here)) > _SETTLED:
        here = brentq(off, here, before, xtol=_SETTLED, rtol=_SETTLED)
        if abs(off(here)) > _VEERS:
            raise none
    if line := next(strained(at(here)), ""):
        raise InputRefused(f"at {pretension_of(at(here), number):.4g} N {line}")
    return exp(here)
