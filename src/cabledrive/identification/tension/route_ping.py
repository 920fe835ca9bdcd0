"""Tension of named spans of a machine with routes from pings, and the comparison of two."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot, isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension.answers import PingTension, SpanTension
from cabledrive.identification.tension.from_ping import PingedString, channels_of, tension_of_string, widened
from cabledrive.identification.tension.prepared_recording import PARTIALS
from cabledrive.mechanics.network import statics_of
from cabledrive.modal import modes
from cabledrive.modal.mode import TRANSVERSE
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.route import RoutedDrive

Array = NDArray[np.float64]

ROOM = 0.25
"""Largest relative distance of a mode of a span from that of a string between resting ends."""
COUPLED = 1e-3
"""The same from which a finding says that the ends of the span move with it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TensionComparison:
    """Tensions of two spans against each other."""

    spans: tuple[str, str]
    difference: Estimate  # first minus second [N]
    relative: float  # the same over their mean

    def as_dict(self) -> dict[str, Any]:
        """The comparison as JSON has it."""
        return {
            "spans": list(self.spans),
            "difference": self.difference.as_dict(),
            "relative": self.relative,
            "differ": not self.difference.low <= 0.0 <= self.difference.high,
        }


def tension_of_route_span(
    log: Log, drive: RoutedDrive, span: str, *, channel: str | None = None
) -> PingTension:
    """Tension of a named span of a machine with routes from a recording of its ping.

    The ratio of each mode of the span to that of a string between resting ends is taken from the certified
    modes at the tension of the file. Where it is not 1 (ends on bodies that move), it changes with the
    tension, and the interval grows by what that could make.

    ``log``: from `read_ping`; ``channel``: default as of `tension_from_ping`.
    Raises `InputRefused` for an unknown span or channel, `NotComputed` where no tone is found.
    """
    number = _span_number(drive, span)
    string, ratios = _string(drive, number)
    name = channel if channel is not None else channels_of(log)[0]
    log.channel(name)
    found = tension_of_string(log, string, name)
    return PingTension(
        spans={span: _with_doubt(found, drive, number, ratios)}, report=log.report, drive=drive.name
    )


def compared(found: Mapping[str, SpanTension]) -> TensionComparison:
    """The first two of some tensions against each other."""
    (first, a), (second, b) = list(found.items())[:2]
    value = a.tension.value - b.tension.value
    error = hypot(a.tension.standard_error, b.tension.standard_error)
    half = hypot(a.tension.high - a.tension.value, b.tension.high - b.tension.value)
    return TensionComparison(
        spans=(first, second),
        difference=Estimate(value=value, unit="N", standard_error=error, low=value - half, high=value + half),
        relative=2.0 * value / (a.tension.value + b.tension.value),
    )


def tensions_of_spans(logs: Sequence[Log], drive: RoutedDrive, spans: Sequence[str]) -> list[PingTension]:
    """Tension of each span from its own recording, in order."""
    if len(logs) != len(spans) or len(set(spans)) < len(spans):
        raise InputRefused(
            f"--ping: {len(logs)} recordings and {len(set(spans))} different spans: give one --span for each "
            "recording, in their order"
        )
    return [tension_of_route_span(log, drive, span) for log, span in zip(logs, spans, strict=True)]


def _span_number(drive: RoutedDrive, span: str) -> int:
    names = [one.name for one in drive.free_spans]
    if span not in names:
        known = nearest(span[:80], names) or f": it has {', '.join(names[:6])}" + (
            " and more" if len(names) > 6 else ""
        )
        raise InputRefused(f'span "{span[:80]}" is no span of {drive.name}{known}')
    return names.index(span)


def _string(drive: RoutedDrive, number: int) -> tuple[PingedString, Array]:
    """The span as its ping is read, and its modes over those of a string between resting ends."""
    span, rope = drive.free_spans[number], drive.ropes[drive.free_spans[number].route]
    speed = drive.route[span.route].speed
    if any(own == number for own, _ in drive.carriage_places):
        raise InputRefused(f"span {span.name} has a carriage on it: its ping is not read; pluck another span")

    def clamped(tension: float) -> float:
        """Fundamental between resting ends [Hz]."""
        wave = rope.wave_speed(tension)
        return (wave**2 - speed**2) / wave / (2.0 * span.length)

    first = clamped(float(statics_of(drive).mean[number]))
    ratios = _ratios(drive, span.name, first)

    def tension_for(mode: int, hertz: float) -> float:
        return _solved(clamped, hertz / (mode * ratios[mode - 1]), rope.axial_rigidity)

    return PingedString(
        drive=drive,
        span=span.name,
        modes=first * ratios * np.arange(1, ratios.size + 1),
        tension_for=tension_for,
        bare=lambda hertz: rope.density * (2.0 * span.length * hertz) ** 2,
        remedy="does another span vibrate? Damp it",
    ), ratios


def _ratios(drive: RoutedDrive, span: str, first: float) -> Array:
    """Each of the first modes of a span in the plane over that of a string between resting ends."""
    listed = [
        mode.frequency
        for mode in modes(drive, below=(PARTIALS + 0.5) * first).modes
        if mode.kind == TRANSVERSE and mode.span == span and mode.plane == "w"
    ]
    found = []
    for number in range(1, PARTIALS + 1):
        near = min(listed, key=lambda own: abs(own - number * first), default=np.inf)
        if abs(near / (number * first) - 1.0) > ROOM / number:
            break
        found.append(near / (number * first))
    if not found:
        raise NotComputed(f"span {span} has no first mode of its own near {first:.5g} Hz: pluck another span")
    return np.array(found)


def _solved(clamped: Any, hertz: float, rigidity: float) -> float:
    """Tension at which a string between resting ends has a fundamental [N]; it rises with the tension."""
    from scipy.optimize import brentq

    low, high = 1e-12 * rigidity, 0.5 * rigidity
    if not clamped(low) < hertz < clamped(high):
        raise NotComputed(f"no tension of this rope makes its fundamental {hertz:.5g} Hz")
    tension = brentq(lambda own: clamped(own) - hertz, low, high, rtol=1e-13, xtol=1e-12)
    assert isfinite(tension)
    return float(tension)


def _with_doubt(found: SpanTension, drive: RoutedDrive, number: int, ratios: Array) -> SpanTension:
    """The tension with an interval that holds what moving ends could make, and a finding where they move."""
    coupled = float(np.abs(ratios - 1.0).max())
    away = abs(found.tension.value / float(statics_of(drive).mean[number]) - 1.0)
    extra = 2.0 * coupled * away * found.tension.value / float(stats.norm.ppf(0.975))
    words = (
        f"the ends of {found.span} move with it: its modes are off those of a string between resting ends by "
        f"up to {100 * coupled:.2g} %"
    )
    findings = (*found.findings, words) if coupled > COUPLED else found.findings
    return replace(found, tension=widened(found.tension, extra), findings=findings)
