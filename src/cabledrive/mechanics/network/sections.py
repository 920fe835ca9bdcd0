"""Sections of routes along which the tension is passed on, and the weights that change it on the way."""

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters.arrays import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.route.geometry import FreeSpan

_BALANCED = 1e-6


def gravity(drive: RoutedDrive) -> Array:
    """Gravity in the plane of the machine, shape (2,) [m/s^2]."""
    slope = drive.layout.inclination
    return -drive.layout.gravity * np.array([np.sin(slope), np.cos(slope)])


def sections_of(drive: RoutedDrive) -> list[list[int]]:
    """Numbers of the free spans of each section, in order of travel."""
    visits = [place.pulley for places in drive.places for place in places if place.pulley is not None]
    passing = {
        number
        for number, pulley in enumerate(drive.pulley)
        if not pulley.fixed and number not in drive.driven and visits.count(number) == 1
    }
    found: list[list[int]] = []
    for route, data in enumerate(drive.route):
        own = [number for number, span in enumerate(drive.free_spans) if span.route == route]
        breaks = [i for i, number in enumerate(own) if drive.free_spans[number].start.pulley not in passing]
        if data.closed:
            first = breaks[0] if breaks else 0
            own, breaks = own[first:] + own[:first], [i - first for i in breaks] or [0]
        elif 0 not in breaks:
            breaks.insert(0, 0)
        found += [own[i:j] for i, j in zip(breaks, [*breaks[1:], len(own)], strict=True)]
    return found


def section_numbers(walks: list[list[int]], spans: int) -> NDArray[np.intp]:
    """Number of the section of each span."""
    section = np.zeros(spans, dtype=np.intp)
    for number, walk in enumerate(walks):
        section[walk] = number
    return section


class Offsets:
    """What the tensions of the sections leave open: weights of ropes and carriages along every span.

    ``constant`` and ``unit``, shape (spans, 2, 2): forces at both ends without and per unit of section
    tension.
    """

    def __init__(self, drive: RoutedDrive, walks: list[list[int]], strain: Array) -> None:
        n, g = len(drive.free_spans), gravity(drive)
        self.start, self.end = np.zeros(n), np.zeros(n)
        self.line_load = np.zeros((n, 2))
        self.constant, self.unit = np.zeros((n, 2, 2)), np.zeros((n, 2, 2))
        for walk in walks:
            reached = 0.0
            for number in walk:
                reached = self._add(drive, number, g, float(strain[number]), reached)
            self._check_closed(drive, walk, reached)

    def _add(self, drive: RoutedDrive, number: int, g: Array, strain: float, at_start: float) -> float:
        """One more span of a section, which starts with a tension; returns that at its end."""
        span = drive.free_spans[number]
        rope, route = drive.ropes[span.route], drive.route[span.route]
        along, across = np.array(span.along), np.array(span.across)
        density = rope.density / (1.0 + strain)
        load = density * g
        weight_along, moment_across, total_across = _carried(drive, number, span, g)
        at_end = at_start - float(load @ along) * span.length - weight_along
        self.start[number], self.end[number], self.line_load[number] = at_start, at_end, load
        momentum = density * route.speed**2
        hanging = float(load @ across) * span.length / 2.0
        push = (
            (at_start - momentum) * along + (hanging + total_across - moment_across) * across,
            -(at_end - momentum) * along + (hanging + moment_across) * across,
        )
        self.constant[number] = route.ropes * np.array(push)
        self.unit[number] = route.ropes * np.array((along, -along))
        return at_end

    def _check_closed(self, drive: RoutedDrive, walk: list[int], reached: float) -> None:
        """Where a rope runs round free pulleys alone, nothing holds weights that pull it one way."""
        first, last = drive.free_spans[walk[0]], drive.free_spans[walk[-1]]
        driven = first.start.pulley in drive.driven or first.start.sense == 0
        if not drive.route[first.route].closed or driven or drive.pulley[first.start.pulley or 0].fixed:
            return
        if last.end == first.start and abs(reached) > _BALANCED * (1.0 + np.abs(self.end[walk]).max()):
            raise InputRefused(
                f'route "{drive.route[first.route].name}": no static solution, weights on it pull '
                f"{abs(reached):.4g} "
                "N one way and every pulley turns freely: drive a pulley by [[motor]], or fix one"
            )


def _carried(drive: RoutedDrive, number: int, span: FreeSpan, g: Array) -> tuple[float, float, float]:
    """Weights of a span's carriages: along it, at its end and in total across it [N]."""
    along = at_end = total = 0.0
    for carriage, (own, place) in zip(drive.carriage, drive.carriage_places, strict=True):
        if own == number:
            along += carriage.mass * float(g @ np.array(span.along))
            if not carriage.guided:
                across = carriage.mass * float(g @ np.array(span.across))
                total, at_end = total + across, at_end + across * place / span.length
    return along, at_end, total
