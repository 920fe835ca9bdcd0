r"""Exact integrals over mode shapes: how a longitudinal mode and the stretch of transverse modes meet.

Slopes are waves on every piece of cable, Eq. (A.3), so that every product integrates to terms of

.. math:: E(p) = \int_0^l e^{ips}\,\mathrm{d}s = l\,e^{ipl/2}\,\frac{\sin(pl/2)}{pl/2}. \quad \text{Eq. (A.5)}
"""

from cmath import exp, phase
from collections.abc import Iterator, Sequence
from math import ceil, pi, sin

from cabledrive.modal.motion import SlopeWave


def _phase_integral(wave_number: float, length: float) -> complex:
    """E(p) of the module."""
    half = 0.5 * wave_number * length
    return length * exp(1j * half) * _sinc(half)


def _sinc(x: float) -> float:
    return sin(x) / x if abs(x) > 1e-8 else 1.0 - x * x / 6.0


def stretch_by(longitudinal: Sequence[SlopeWave], transverse: Sequence[SlopeWave]) -> float:
    r"""Overlap of longitudinal strain and squared transverse slope, Eq. (A.6).

    .. math:: \int u_s\,w_s^2\,\mathrm{d}s

    With slopes :math:`\operatorname{Re} Ue^{iks}` and :math:`\operatorname{Re} We^{i\kappa s}` each piece
    gives :math:`\tfrac12|W|^2\operatorname{Re} UE(k) + \tfrac14\operatorname{Re}[UW^2E(k+2\kappa) +
    UW^{*2}E(k-2\kappa)]`.

    Returns [m^2] for amplitudes in metres.
    """
    total = 0.0
    for u, w, start, length in _overlaps(longitudinal, transverse):
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
            inside = _passes_crest(turned, wave.wave_number * wave.length)
            found = max(found, *ends, abs(turned) if inside else 0.0)
    return found


def _passes_crest(slope: complex, turn: float) -> bool:
    first = phase(slope)
    return ceil(first / pi) * pi <= first + turn


def _overlaps(
    first: Sequence[SlopeWave], second: Sequence[SlopeWave]
) -> Iterator[tuple[SlopeWave, SlopeWave, float, float]]:
    """Pieces that two sets of waves share: both waves, start and length."""
    for a in first:
        for b in second:
            if a.span == b.span:
                start = max(a.start, b.start)
                end = min(a.start + a.length, b.start + b.length)
                if end > start:
                    yield a, b, start, end - start
