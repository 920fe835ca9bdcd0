r"""Vibrating sections of the spans, and exact integrals over mode shapes.

Slopes are waves on every piece of cable, Eq. (A.3), so that every product integrates to terms of

.. math:: E(p) = \int_0^l e^{ips}\,\mathrm{d}s = l\,e^{ipl/2}\,\frac{\sin(pl/2)}{pl/2}. \quad \text{Eq. (A.5)}
"""

from cmath import exp, phase
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import ceil, inf, pi, sin, sqrt

import numpy as np

from cabledrive.mechanics.chain import LabelledChain
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal import Mode
from cabledrive.modal.shapes import SlopeWave
from cabledrive.modal.tuning import section_modes
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array


def _phase_integral(wave_number: float, length: float) -> complex:
    """E(p) of the module."""
    half = 0.5 * wave_number * length
    sinc = sin(half) / half if abs(half) > 1e-8 else 1.0 - half * half / 6.0
    return length * exp(1j * half) * sinc


def stretch_by(longitudinal: Sequence[SlopeWave], transverse: Sequence[SlopeWave]) -> float:
    r"""Overlap of longitudinal strain and squared transverse slope, Eq. (A.6).

    .. math:: \int u_s\,w_s^2\,\mathrm{d}s

    With slopes :math:`\operatorname{Re} Ue^{iks}` and :math:`\operatorname{Re} We^{i\kappa s}` each piece
    gives :math:`\tfrac12|W|^2\operatorname{Re} UE(k) + \tfrac14\operatorname{Re}[UW^2E(k+2\kappa) +
    UW^{*2}E(k-2\kappa)]`.

    Returns [m^2] for amplitudes in metres.
    """
    total = 0.0
    for u, w in product(longitudinal, transverse):
        start, end = max(u.start, w.start), min(u.start + u.length, w.start + w.length)
        length = end - start
        if u.span != w.span or not length > 0.0:
            continue
        a, b, k, kappa = u.slope_at(start), w.slope_at(start), u.wave_number, w.wave_number
        mean = 0.5 * abs(b) ** 2 * (a * _phase_integral(k, length)).real
        double = a * b**2 * _phase_integral(k + 2 * kappa, length)
        double += a * b.conjugate() ** 2 * _phase_integral(k - 2 * kappa, length)
        total += mean + 0.25 * double.real
    return total


def squared_slope(transverse: Sequence[SlopeWave]) -> float:
    r"""Extra length per squared amplitude, twice: :math:`\int w_s^2\,\mathrm{d}s` [1/m], Eq. (A.7)."""
    return sum(
        0.5
        * (abs(w.slope) ** 2 * w.length + (w.slope**2 * _phase_integral(2 * w.wave_number, w.length)).real)
        for w in transverse
    )


def fourth_power_of_slope(transverse: Sequence[SlopeWave]) -> float:
    r"""Unevenness of the tension, :math:`\int w_s^4\,\mathrm{d}s` of unit amplitude [1/m^3], Eq. (A.8)."""
    total = 0.0
    for w in transverse:
        square = abs(w.slope) ** 2
        twice = (w.slope**2 * _phase_integral(2 * w.wave_number, w.length)).real
        fourfold = (w.slope**4 * _phase_integral(4 * w.wave_number, w.length)).real
        total += 0.375 * square**2 * w.length + 0.5 * square * twice + 0.125 * fourfold
    return total


def largest_slope(longitudinal: Sequence[SlopeWave], span: str) -> float:
    """Largest strain of a longitudinal mode on one span per unit amplitude [1/m]."""
    found = 0.0
    for wave in longitudinal:
        if wave.span == span:
            ends = [abs(wave.slope_at(wave.start + share * wave.length).real) for share in (0.0, 1.0)]
            turned = wave.slope_at(wave.start)
            first = phase(turned)
            crest = ceil(first / pi) * pi <= first + wave.wave_number * wave.length
            found = max(found, *ends, abs(turned) if crest else 0.0)
    return found


PLANES = ("w", "v")
HIGHEST_NUMBER = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class TransverseMode:
    """Where one transverse mode of the model lives."""

    span: str  # "upper" or "lower"
    plane: str  # "w" or "v"
    section: tuple[float, float]  # unstretched ends of the vibrating section [m]
    number: int  # number of the mode of its section, from 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """One vibrating section: its mode of unit largest amplitude."""

    label: TransverseMode
    omega: float
    mass: float
    cable_share: float  # of its kinetic energy
    waves: tuple[SlopeWave, ...]


def nearest_section(chain: LabelledChain, pulley: float, number: int | None) -> Section:
    """One transverse mode of a section: the given number, or the first to grow by the pulley mode [rad/s]."""
    # no more modes reach beyond half the pulley mode than of a string without masses
    turns = 0.5 * pulley * float(chain.chain.travel_times.sum()) / pi
    enough = min(HIGHEST_NUMBER, ceil(turns) + chain.chain.masses.size - 1)
    found = section_modes(chain, number or enough)

    def swing(mode: Mode) -> tuple[float, float]:
        """Of the tension, from which it grows without damping (A.22), scaled; its distance from 1:2."""
        square = (2 * pi * mode.frequency / pulley) ** 2
        inside = 1.5 - 2.0 * square
        grows = abs(1.0 - 0.25 / square) / (1.0 + sqrt(inside)) if inside >= 0.0 else inf
        return grows, abs(sqrt(square) - 0.5)

    chosen = found[number - 1] if number else min(found, key=swing)
    pieces = chosen.slope_waves()
    largest = max(wave.largest_displacement for wave in pieces)
    label = TransverseMode(
        span=chain.stretches[0].span,
        plane=PLANES[0],
        section=(chain.stretches[0].start, chain.stretches[-1].end),
        number=found.index(chosen) + 1,
    )
    unit = tuple(replace(wave, slope=wave.slope / largest) for wave in pieces)
    share = chosen.kinetic_shares["cable"]
    return Section(
        label=label, omega=2 * pi * chosen.frequency, mass=largest**-2, cable_share=share, waves=unit
    )


def coupling_of(drive: Drive, along: Sequence[SlopeWave], sections: Sequence[Section]) -> Array:
    r"""Coupling of the pulley mode with each section, Eq. (A.10).

    .. math:: G_j = \frac{EA}{2}\int U_x w_x^2\,\mathrm{d}x
                  = \frac{EA}{2(1+\varepsilon_0)^2}\int U_s w_s^2\,\mathrm{d}s

    EA, not K: the cubic part of the energy is :math:`(K - T_0)/2\int u_x(v_x^2 + w_x^2)\,\mathrm{d}x`.

    ``along``: of the pulley mode, per q.
    Returns shape (sections,): positive where a positive q stretches the section [N/m^2].
    """
    scale = 0.5 * drive.cable.axial_rigidity / (1.0 + drive.cable.prestrain) ** 2
    return scale * np.array([stretch_by(along, section.waves) for section in sections])


def fixed_length(drive: Drive) -> float:
    """Length that the longitudinal motion cannot change, the whole loop; infinite where an end is free."""
    chains = [chain.chain for chain in longitudinal_chains(drive)]
    if len(chains) == 1 and not chains[0].closed and not all(chains[0].fixed):
        return inf
    return (1.0 + drive.cable.prestrain) * sum(float(chain.lengths.sum()) for chain in chains)


def stiffening_of(
    drive: Drive, coupling: Array, sections: Sequence[Section], pulley_stiffness: float
) -> tuple[Array, Array]:
    r"""Tension that the transverse motion makes itself, Eq. (A.11).

    .. math:: \tfrac14 N_{jk} = \frac{EA\,T_0}{8K}\,\delta_{jk} F_j + \frac{EA^2}{8K\Lambda} S_j S_k
                              + \frac{G_j G_k}{2MW^2}

    with :math:`F_j = \int w_x^4\,\mathrm{d}x` and :math:`S_j = \int w_x^2\,\mathrm{d}x`. The first term is
    the unevenness along the span; in the other two every longitudinal mode but the pulley mode follows
    without inertia. :math:`\Lambda` is the length that these cannot change, the whole loop; infinite where an
    end is free.

    ``coupling``, shape (sections,): G [N/m^2]; ``pulley_stiffness``: M W^2 [N/m].
    Returns ``uneven``, shape (sections,): first term, the diagonal of a matrix [N/m^3]; ``shared``, shape
    (sections, sections): the other two [N/m^3].
    """
    cable, stretch = drive.cable, 1.0 + drive.cable.prestrain
    rigidity, stiffness = cable.axial_rigidity, cable.axial_rigidity * stretch
    squared = np.array([squared_slope(section.waves) for section in sections]) / stretch
    fourth = np.array([fourth_power_of_slope(section.waves) for section in sections]) / stretch**3
    carried = rigidity**2 / (8 * stiffness * fixed_length(drive)) * np.outer(squared, squared)
    turned = np.outer(coupling, coupling) / (2 * pulley_stiffness)
    return rigidity * cable.pretension / (2 * stiffness) * fourth, 4.0 * (carried + turned)


def frequency_shift(tension: Array | float, rest: Array | float, rigidity: float) -> Array:
    r"""Factor on a transverse frequency when a span bears another tension, Eq. (A.12).

    .. math:: w^2 = \kappa^2\,T(1 + T/EA)/\rho_0 \quad\text{at a fixed distance of the pulleys}

    ``tension``, ``rest``: tension, and the pretension it differs from [N]; ``rigidity``: EA [N].
    """
    return np.sqrt(tension * (1.0 + tension / rigidity) / (rest * (1.0 + rest / rigidity)))


def span_tensions(drive: Drive, load_torque: float) -> dict[str, float]:
    """Tension of each span [N] under a steady torque on the load pulley [N m], positive pulls the upper one.

    Refused if a span goes slack.
    """
    force = load_torque / drive.load_pulley.radius / len(drive.spans)
    tensions = {span: drive.cable.pretension + (force if span == "upper" else -force) for span in drive.spans}
    slack = min(tensions, key=lambda span: tensions[span])
    if tensions[slack] <= 0.0:
        limit = drive.cable.pretension * drive.load_pulley.radius * len(drive.spans)
        said = f"load_torque = {load_torque:.4g} N m leaves the {slack} span without tension"
        raise InputRefused(f"{said}: stay below {limit:.4g} N m or raise cable.pretension")
    return tensions
