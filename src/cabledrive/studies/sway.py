r"""Ropes in a building that sways: how far each moves across, over the places of the car.

The building moves by :math:`a(y)\cos\omega t`, in proportion to the height; the ends of every free span move
with it. Across the span, with the tension T that grows along it by its weight,

.. math:: (T u')' + \rho(\omega^2 - i\omega\Gamma)\,u = 0, \qquad u = a \text{ at both ends},

which Bessel's functions of order 0 of :math:`2\sqrt{\kappa T}/T'`, with
:math:`\kappa = \rho(\omega^2 - i\omega\Gamma)`, solve. The sway of a rope is the largest of :math:`|u - a|`;
it is that of the steady state, reached where the car stands long enough.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

from cabledrive.mechanics.network.statics import statics_of
from cabledrive.parameters import InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import LARGEST
from cabledrive.parameters.keys import varied_together
from cabledrive.studies.pair_thresholds import refuse_running

POINTS = 201
"""Points of a span at which its motion is looked at."""
MOST_PLACES = 2_000
_HALVINGS = 48
_SLOPE = 1e-6
"""Least change of a tension along a span over its mean; at it the solutions are those of a uniform string."""
_LEVEL = 1e-9  # of its extent, by which what stands level is high by round-off
STEEP = 0.02
"""Share of its length beyond which a rope's own stretching, which is left out, limits its sway."""
_LOWEST, _HIGHEST = 0.4, 1.6
"""Range of the first mode over that of a string under the mean tension, whatever the weight: 0.76 to 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SwayingRope:
    """One free span in a building that sways, at every place."""

    name: str
    frequency_hz: Array  # (places,): of its first mode between ends at rest [Hz]
    amplitude: Array  # (places,): largest motion across, from where the building has it [m]
    length: Array  # (places,): of the span [m]

    @property
    def largest_share(self) -> float:
        """Largest amplitude over the length of the span."""
        return float((self.amplitude / self.length).max())


@dataclass(frozen=True, slots=True, kw_only=True)
class Sway:
    """Ropes of a machine in a building that sways."""

    keys: tuple[str, ...]  # what is varied, the first naming the places; empty for the file's own pose
    places: Array  # (places,): [m]; where a rope's mode meets the building's frequency is one of them
    ropes: tuple[SwayingRope, ...]  # the one with the largest amplitude first
    # bottom, top: heights between which the building's motion grows from 0 to ``amplitude`` [m]
    bottom: float
    top: float


def sway(
    drive: Machine, building: float, amplitude: float, vary: Mapping[tuple[str, ...], Array] | None = None
) -> Sway:
    """How far ropes move across in a building that sways by ``amplitude`` [m] at ``building`` [Hz]."""
    from scipy.optimize import brentq

    for word, value, unit in (("building", building, "Hz"), ("amplitude", amplitude, "m")):
        if not 0.0 < value <= LARGEST:
            raise InputRefused(f"{word} = {value:.6g} {unit} must be above 0 and finite")
    for route, rope in zip(drive.route, drive.ropes, strict=True):
        if not rope.transverse_damping > 0.0:
            said = f'route "{route.name}": transverse_damping is 0, and nothing else bounds its sway'
            raise InputRefused(f"{said}: give it in [cable]")
    refuse_running(drive, "sway")
    if vary is not None and len(vary) != 1:
        raise InputRefused(f"{len(vary)} ranges are varied: sway takes the places of one motion")
    keys, rows = next(iter(vary.items())) if vary else ((), np.zeros((0, 1)))
    points = [pulley.at for pulley in drive.pulley] + [anchor.at for anchor in drive.anchor]
    heights = [_height(drive, point) for point in points]
    bottom, top = min(heights), max(heights)
    if not top - bottom > _LEVEL * np.ptp(points, axis=0).max():
        raise InputRefused("the machine has no height: sway is of ropes that hang in a building")
    columns = [np.asarray(column, dtype=float) for column in rows.T]
    if len(columns) > MOST_PLACES:
        raise InputRefused(f"{len(columns)} places, at most {MOST_PLACES} are computed: take fewer")

    def posed(place: Array) -> Machine:
        return varied_together(drive, dict(zip(keys, place.tolist(), strict=True))) if keys else drive

    known = [_at(posed(column), building, amplitude, (bottom, top)) for column in columns]
    for i in range(len(columns) - 1):
        # Between the places the first mode meets the building, or else an odd number of higher ones do.
        met = known[i][3] * known[i + 1][3] < 0.0
        for span in np.flatnonzero(met.any(axis=0)):
            near, far, which = columns[i], columns[i + 1], (int(np.argmax(met[:, span])), int(span))

            def off(s: float, near: Array = near, far: Array = far, which: tuple[int, int] = which) -> float:
                return float(_met(posed(near + s * (far - near)), building)[which])

            share = brentq(off, 0.0, 1.0, xtol=1e-9)
            columns.append(near + share * (far - near))
            known.append(_at(posed(columns[-1]), building, amplitude, (bottom, top)))
    order = np.argsort([column[0] if keys else 0.0 for column in columns], kind="stable")
    hertz, moved, lengths = (np.array([known[i][part] for i in order]) for part in range(3))
    ropes = [
        SwayingRope(name=span.name, frequency_hz=hertz[:, i], amplitude=moved[:, i], length=lengths[:, i])
        for i, span in enumerate(drive.free_spans)
    ]
    ropes.sort(key=lambda rope: -float(f"{rope.amplitude.max():.9g}"))  # alike ones in the file's order
    places = np.array([columns[i][0] for i in order]) if keys else np.array([])
    return Sway(keys=tuple(keys), places=places, ropes=tuple(ropes), bottom=bottom, top=top)


def _height(drive: Machine, at: Sequence[float]) -> float:
    """Height of a point against gravity [m]."""
    return at[0] * sin(drive.layout.inclination) + at[1] * cos(drive.layout.inclination)


def _at(
    own: Machine, building: float, amplitude: float, reach: tuple[float, float]
) -> tuple[Array, Array, Array, Array]:
    """First frequencies [Hz], amplitudes and lengths [m] of all spans in a pose, (spans,); `_met` of it."""
    from scipy.special import hankel1e, hankel2e

    tension, density, damping, length = _strings(own)
    ends = np.array([[_height(own, point) for point in span.contacts] for span in own.free_spans]).T
    floor = amplitude * (ends - reach[0]) / (reach[1] - reach[0])
    omega = 2 * pi * building
    share = np.linspace(0.0, 1.0, POINTS)[:, None]
    stiff = density * (omega**2 - 1j * omega * damping)
    rate = 2 * np.sqrt(stiff) * length / np.abs(tension[1] - tension[0])
    z = rate * np.sqrt(tension[0] + (tension[1] - tension[0]) * share)
    first, second = (  # of Hankel's kind, scaled at the start: on an even rope z is large
        hankel(0, z) * np.exp(sign * 1j * (z - z[0])) for hankel, sign in ((hankel1e, 1), (hankel2e, -1))
    )
    whole = first[0] * second[-1] - first[-1] * second[0]
    motion = (
        first * (floor[0] * second[-1] - floor[1] * second[0])
        + second * (floor[1] * first[0] - floor[0] * first[-1])
    ) / whole
    still = floor[0] + (floor[1] - floor[0]) * share
    met = _met(own, building)
    return met[0] + building, np.abs(motion - still).max(axis=0), length, met


def _strings(drive: Machine) -> tuple[Array, Array, Array, Array]:
    """Tension at both ends, shape (2, spans) [N]; density under it, damping, length of each span, in SI."""
    statics = statics_of(drive)
    change = statics.end - statics.start
    half = 0.5 * np.where(change < 0.0, -1.0, 1.0) * np.maximum(np.abs(change), _SLOPE * statics.mean)
    ropes = [drive.ropes[span.route] for span in drive.free_spans]
    density = np.array([rope.density for rope in ropes])
    density /= 1.0 + statics.mean / np.array([rope.axial_rigidity for rope in ropes])
    damping = np.array([rope.transverse_damping for rope in ropes])
    length = np.array([span.length for span in drive.free_spans])
    return np.array([statics.mean - half, statics.mean + half]), density, damping, length


def _met(drive: Machine, building: float) -> Array:
    """What is zero where modes of spans between ends at rest meet a frequency [Hz], shape (2, spans).

    By how much the first mode, found by halving, lies above it [Hz]; the determinant, of any mode.
    """
    from scipy.special import j0, y0

    def determinant(hertz: float | Array) -> Array:
        near, far = hertz * ends
        return np.asarray(j0(near) * y0(far) - j0(far) * y0(near))

    tension, density, _, length = _strings(drive)
    mean = np.sqrt(tension.mean(axis=0) / density) / (2 * length)
    rate = 4 * pi * np.sqrt(density) * length / np.abs(tension[1] - tension[0])
    ends = rate * np.sqrt(np.sort(tension, axis=0))
    low, high = _LOWEST * mean, _HIGHEST * mean
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        before = determinant(middle) > 0.0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.array([0.5 * (low + high) - building, determinant(building)])
