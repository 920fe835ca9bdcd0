r"""The input shaper that a measured vibration asks for, by the rules of Klipper's calibration.

Of a shaper, the remaining vibration is the part of the density, above 5 % of its largest, that passes it:
:math:`\sum\max(V\,S - S_{max}/20, 0) / \sum\max(S - S_{max}/20, 0)`, the worst of the damping
ratios 0.075, 0.1 and 0.15, as the printer's is not known to the firmware. See "Measuring resonances" of
Klipper's documentation, https://www.klipper3d.org/Measuring_Resonances.html; the weights of the score are
Klipper's, without a meaning of their own.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.printer_spectrum import PrinterSpectrum
from cabledrive.parameters import InputRefused
from cabledrive.trajectories.input_shaping import (
    LARGEST_DAMPING,
    TOLERANCE,
    InputShaper,
    highest_acceleration,
    input_shaper,
    insensitive_band,
    residual_vibration,
    smoothing,
)

Array = NDArray[np.float64]

HIGHEST_FREQUENCY = 150.0
"""Highest frequency of a shaper, as in the firmware [Hz]."""
LOWEST_FREQUENCY = {"zv": 21.0, "mzv": 23.0, "ei": 29.0, "2hump_ei": 39.0, "3hump_ei": 48.0}
"""Types that are compared, and the frequency [Hz] below which each would allow about 1.5 m/s^2 only."""
STEP = 0.2
"""Between the frequencies that are tried [Hz]."""
DAMPING_RATIOS = np.array([0.075, 0.1, 0.15])
"""Of the mode, for the worst of which the remaining vibration is stated."""

CELLS = 50_000
"""Designs times lines of a spectrum that are computed at a time."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShaperFit:
    """A shaper at the frequency that suits a vibration best."""

    shaper: InputShaper
    vibration: float  # remaining vibration, from 0 to about 1
    smoothing: float  # at 5 m/s^2 [m]
    max_acceleration: float  # up to which the smoothing stays within 0.12 mm [m/s^2]
    score: float  # by which types are compared, the smaller the better; in the unit of the smoothing [m]

    @property
    def type(self) -> str:
        """Name of the type, as the printer's configuration calls it."""
        return self.shaper.type

    @property
    def frequency(self) -> float:
        """Frequency of the design [Hz]."""
        return self.shaper.frequency

    @property
    def band(self) -> tuple[float, float] | None:
        """Frequencies between which it leaves 5 % of the amplitude at most [Hz]."""
        return insensitive_band(self.shaper)


def remaining_vibration(
    unit: InputShaper,
    frequencies: Array,
    spectra: Sequence[PrinterSpectrum],
    ratios: Array = DAMPING_RATIOS,
) -> Array:
    """Share of the vibration above 5 % of its largest that passes a type, the worst of spectra and dampings.

    ``unit``: shaper of the type for 1 Hz; ``frequencies``, shape (n,): of the designs [Hz]; ``ratios``:
    damping ratios of the mode.
    Returns shape (n,).
    """
    worst = np.zeros(frequencies.size)
    for spectrum in spectra:
        floor = TOLERANCE * spectrum.density.max()
        counts = spectrum.density > floor  # no shaper raises an amplitude: the others remain below
        lines, density = spectrum.frequency[counts], spectrum.density[counts]
        whole = (density - floor).sum()
        parts = -(-frequencies.size * density.size // CELLS)
        start = 0
        for designs in np.array_split(frequencies, parts):
            # Residual vibration depends on the frequency of the mode over that of the design only.
            passed = residual_vibration(unit, lines / designs[:, None], ratios[:, None, None])
            kept = np.maximum(passed * density - floor, 0.0).sum(axis=2).max(axis=0) / whole
            place = slice(start, start + designs.size)
            worst[place] = np.maximum(worst[place], kept)
            start += designs.size
    return worst


def fit_shapers(
    spectra: Sequence[PrinterSpectrum],
    *,
    damping: float,
    corner_speed: float,
    max_smoothing: float | None = None,
) -> tuple[tuple[ShaperFit, ...], ShaperFit]:
    """Fit every type, and choose one.

    ``spectra``: of one axis, at one or several places; ``damping``: ratio of the design; ``corner_speed``
    [m/s]; ``max_smoothing``: larger smoothing is not tried [m].
    Returns the fits in the order of the types; the recommended one, which may have another frequency.
    Raises `InputRefused` if no shaper is as smooth as asked.
    """
    fits: list[ShaperFit] = []
    best: ShaperFit | None = None
    for type in LOWEST_FREQUENCY:
        if damping > LARGEST_DAMPING[type]:
            continue
        tried = _tried(type, spectra, damping, corner_speed, max_smoothing)
        if not tried:
            continue
        fit = _suitable(tried)
        if best is None or _is_better(fit, best):
            best = fit
        for other in tried:  # from the lowest frequency up
            if other.vibration < best.vibration and other.smoothing < best.smoothing:
                best = fit = other
        fits.append(fit)
    if best is None:
        raise InputRefused(
            f"no shaper has a smoothing within {1e3 * (max_smoothing or 0.0):.3g} mm at 5 m/s^2: allow more"
        )
    if best.type == "zv":
        best = next((fit for fit in fits[1:] if 1.1 * fit.vibration < best.vibration), best)
    return tuple(fits), best


def _tried(
    type: str,
    spectra: Sequence[PrinterSpectrum],
    damping: float,
    corner_speed: float,
    max_smoothing: float | None,
) -> list[ShaperFit]:
    """A type at every frequency, upwards."""
    frequencies = np.round(np.arange(LOWEST_FREQUENCY[type], HIGHEST_FREQUENCY, STEP), 6)
    shapers = [input_shaper(type, float(frequency), damping) for frequency in frequencies]
    rounding = np.array([smoothing(shaper, corner_speed=corner_speed) for shaper in shapers])
    allowed = np.flatnonzero(rounding <= (np.inf if max_smoothing is None else max_smoothing))
    if allowed.size == 0:
        return []
    left = remaining_vibration(input_shaper(type, 1.0, damping), frequencies[allowed], spectra)
    return [
        ShaperFit(
            shaper=shapers[k],
            vibration=float(passed),
            smoothing=float(rounding[k]),
            max_acceleration=highest_acceleration(shapers[k], corner_speed),
            score=float(rounding[k] * (passed**1.5 + 0.2 * passed + 0.01)),
        )
        for k, passed in zip(allowed, left, strict=True)
    ]


def _suitable(tried: list[ShaperFit]) -> ShaperFit:
    """The best score among those whose vibration is near the least."""
    # At equal vibration the higher frequency counts as least, which is the smoother one.
    least = min(reversed(tried), key=lambda fit: fit.vibration)
    near = [fit for fit in tried if fit.vibration < 1.1 * least.vibration + 5e-4]
    return min([least, *near], key=lambda fit: fit.score)


def _is_better(fit: ShaperFit, than: ShaperFit) -> bool:
    """Whether its score is better by 20 %, or by 5 % with a smoothing better by 10 %."""
    if 1.2 * fit.score < than.score:
        return True
    return 1.05 * fit.score < than.score and 1.1 * fit.smoothing < than.smoothing
