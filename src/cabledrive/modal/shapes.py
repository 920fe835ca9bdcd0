"""Shapes of the modes of a network: on every span and joint, and where their energy is."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import atan2, ceil, cos, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.modal.cuts import Cut
from cabledrive.modal.elements import ALONG, Tag
from cabledrive.modal.mode import BEAM, BOTH, HEAVY_STRING, SAGGING, STRING
from cabledrive.modal.networks import ModalNetwork
from cabledrive.modal.rows import MASS, SPRING, Array
from cabledrive.modal.search import Solved

_EDGE = 1e-12

Values = NDArray[Any]
Place = tuple[str, str, tuple[float, float]]  # span, direction, places between which it is held across


@dataclass(frozen=True, slots=True, kw_only=True)
class SlopeWave:
    r"""The slope of a mode on one piece of cable, :math:`\operatorname{Re} S e^{ik(s - s_0)}`, Eq. (A.3).

    ``start``, ``length``: from the pulley where the span starts [m]; ``wave_number``: k [rad/m]; ``slope``:
    S.
    """

    span: str
    start: float
    length: float
    wave_number: float
    slope: complex

    def slope_at(self, position: float) -> complex:
        """Complex slope with its phase at another position of the piece [m]."""
        phase = self.wave_number * (position - self.start)
        return self.slope * complex(cos(phase), sin(phase))

    @property
    def largest_displacement(self) -> float:
        """Largest displacement on the piece."""
        first = atan2(self.slope.imag, self.slope.real) - pi / 2
        amplitude, last = abs(self.slope) / self.wave_number, first + self.wave_number * self.length
        if ceil(first / pi) * pi <= last:
            return amplitude
        return amplitude * max(abs(cos(first)), abs(cos(last)))


class Shape:
    """Shapes of a mode that a table of rows has given."""

    def __init__(self, network: ModalNetwork, cut: Cut, solved: Solved) -> None:
        self.network, self.cut, self.solved = network, cut, solved
        self.multiplicity, self.frequency = solved.multiplicity, solved.omega / (2.0 * pi)
        self.clamped = network.by_span and not cut.own.size  # one rope between ends at rest
        self.proven = solved.enclosure is not None
        self.tags, self.ways = cut.own.tags, cut.own.ways

    def taken_for(self, span: str, way: str) -> str:
        """What the rope of a span is taken for in one direction."""
        for rope in self.cut.own.ropes:
            number, own = rope.tags[-1]
            if own == way and span in (BOTH, self.network.pieces[number].span):
                return SAGGING if rope.direction is not None else BEAM if rope.bend else HEAVY_STRING
        return STRING

    @cached_property
    def _natural(self) -> Values:
        return self.cut.natural(self.solved.shapes)

    @cached_property
    def coordinates(self) -> dict[str, Values]:
        """Each coordinate of the network that takes part, shape (multiplicity,)."""
        names = [self.network.names[c] for c in self.cut.own.columns]
        return dict(zip(names, self._natural, strict=False))

    @cached_property
    def row_energies(self) -> tuple[Array, Array]:
        """Strain and kinetic energy of every row, times four."""
        return self.cut.energies([self.solved])[0]

    @cached_property
    def across(self) -> Array:
        """Share across in the strain energy of each rope that moves along as well."""
        return self.cut.across([self.solved])[0]

    @cached_property
    def places(self) -> dict[Place, float]:
        """Share of the strain energy by span, direction and section."""
        cut, own, strain = self.cut, self.cut.own, self.row_energies[0]
        total, found = float(strain.sum()), dict[Place, float]()

        def add(tag: Tag, value: float) -> None:
            piece = self.network.pieces[tag[0]]
            key = piece.span, tag[1], piece.section
            found[key] = found.get(key, 0.0) + value / total

        parts = np.bincount(cut.wave, strain[: 3 * cut.wave.size].reshape(-1, 3).sum(axis=1), len(own.waves))
        for wave, value in zip(own.waves, parts.tolist(), strict=True):
            add(wave.tag, value)
        for number, (segments, base, _) in enumerate(cut.segments):
            rope = segments.rope
            whole = across = float(strain[base : base + segments.kind.size].sum())
            if len(rope.tags) > 1:
                across = whole * float(self.across[number])
                add(rope.tags[0], whole - across)
            add(rope.tags[-1], across)
        return found

    @cached_property
    def springs(self) -> dict[str, float]:
        """Share of the strain energy by name of the spring."""
        own, strain, first = self.cut.own, self.row_energies[0], 3 * self.cut.wave.size
        total, found = float(strain.sum()), dict[str, float]()
        for one, value in zip(own.fixed, strain[first : first + len(own.fixed)].tolist(), strict=True):
            if one.kind == SPRING:
                found[one.name] = found.get(one.name, 0.0) + value / total
        return found

    @cached_property
    def kinetic(self) -> dict[str, float]:
        """Share of the kinetic energy by coordinate, and of the "cable"; mean over the shapes."""
        own = self.cut.own
        x = self._natural[: own.size]
        row, column, value = own.fixed_rows
        moved = np.zeros((own.factor.size, x.shape[1]), x.dtype)
        np.add.at(moved, row, value[:, None] * x[column])
        momentum = np.where(own.fixed_kind == MASS, own.factor, 0.0)[row, None] * value[:, None] * moved[row]
        energy = np.bincount(column, np.mean((x[column].conj() * momentum).real, axis=1), own.size)
        whole = 0.5 * float(self.row_energies[1].sum()) / self.solved.omega**2
        names = [self.network.names[c] for c in own.columns]
        shares = {name: value / whole for name, value in zip(names, energy.tolist(), strict=True) if value}
        return shares | {"cable": 1.0 - sum(shares.values())}

    @cached_property
    def mass(self) -> float:
        """Of all that takes part, waves and masses, what turns as felt at its rim [kg]."""
        own, (row, column, value) = self.cut.own, self.cut.own.fixed_rows
        arm = np.array([self.network.units.get(self.network.names[c], 1.0) for c in own.columns])
        felt = own.factor[row] * (value / arm[column]) ** 2
        return float(felt[own.fixed_kind[row] == MASS].sum() + own.z @ own.time)

    def displacement(self, span: str, way: str, positions: Array) -> Values:
        """Displacement of a span in one direction, shape (multiplicity, p), of unit modal mass [kg^-1/2]."""
        x, omega = self.solved.shapes, self.solved.omega
        out = np.zeros((self.solved.multiplicity, positions.size), x.dtype)
        y, times, phases = self.cut.waves(omega, self.solved.placed, x)
        for i, number, first, last in self._parts(times):
            piece = self.network.pieces[self.cut.own.waves[number].tag[0]]
            if (piece.span, self.cut.own.waves[number].tag[1]) != (span, way):
                continue
            here = (positions >= first - _EDGE) & (positions <= last + _EDGE)
            share, alpha = (positions[here] - first) / (last - first), phases[i]
            wave = self.cut.own.waves[number]
            late = 1j * omega * wave.lag * times[i] / wave.time if wave.lag else 0.0
            # A curved wave is moved along itself by the cosine of what moves along the line of the pulleys.
            cosine = np.interp(positions[here], (piece.start, piece.end), wave.cosine)
            far = np.outer(y[3 * i + 2] * np.exp(-late), np.sin(alpha * share))
            near = np.outer(y[3 * i + 1], np.sin(alpha * (1 - share)))
            out[:, here] = (near + far) * np.exp(late * share) / np.sin(alpha) / cosine
        for number, (segments, _, _) in enumerate(self.cut.segments):
            rope = segments.rope
            piece = self.network.pieces[rope.tags[0][0]]
            if piece.span != span or way not in [own for _, own in rope.tags]:
                continue
            here = (positions >= piece.start - _EDGE) & (positions <= piece.end + _EDGE)
            share = np.interp(positions[here], (piece.start, piece.end), rope.inside)
            ends = self.cut.rope_ends(number, self._natural)
            out[:, here] = segments.displacement(omega, ends, share)[way != ALONG]
        return out

    def _parts(self, times: Array) -> Iterator[tuple[int, int, float, float]]:
        """Parts of waves: number, number of the wave, start and end on its span."""
        reached: dict[int, float] = {}
        for i, number in enumerate(self.cut.wave.tolist()):
            wave = self.cut.own.waves[number]
            piece = self.network.pieces[wave.tag[0]]
            first = reached.get(number, piece.start)
            last = first + (piece.end - piece.start) * times[i] / wave.time
            reached[number] = last
            yield i, number, first, last if abs(last - piece.end) > 1e-12 * piece.end else piece.end

    def slope_waves(self, shape: int = 0) -> tuple[SlopeWave, ...]:
        """The waves of one shape of a mode whose ropes are straight and do not run, piece by piece."""
        omega = self.solved.omega
        y, times, phases = self.cut.waves(omega, self.solved.placed, self.solved.shapes)
        found = []
        for i, number, first, last in self._parts(times):
            wave = self.cut.own.waves[number]
            phase = float(phases[i])
            near, far = float(y[3 * i + 1, shape]), float(y[3 * i + 2, shape])
            k = phase / (last - first)
            slope = k * complex((far - near * cos(phase)) / sin(phase), near)
            span = self.network.pieces[wave.tag[0]].span
            found.append(SlopeWave(span=span, start=first, length=last - first, wave_number=k, slope=slope))
        return tuple(found)
