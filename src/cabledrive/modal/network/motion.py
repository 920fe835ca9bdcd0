"""Shapes of a network's mode: on every coordinate and span, with its energies."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.assembly import DIRECTIONS, Network
from cabledrive.mechanics.network.motion import ACROSS, ALONG, OUT_OF_PLANE, Array
from cabledrive.modal.chain_motion import LONGITUDINAL, TRANSVERSE
from cabledrive.modal.network.component import HeldWaves
from cabledrive.modal.network.stiffness import CutComponent, assembled
from cabledrive.modal.solver import Proven
from cabledrive.parameters.route.drive import refuse_route

STRING = "string"


@dataclass(frozen=True, eq=False)
class NetworkMotion:
    """Shapes of a mode in which coordinates take part.

    Attributes
    ----------
    network : Network
    solved : Proven
        Its frame is a `CutComponent`.
    """

    network: Network
    solved: Proven

    @property
    def _cut(self) -> CutComponent:
        cut: CutComponent = self.solved.frame
        return cut

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the coordinates that take part."""
        names = self.network.motion.names  # slopes of carriages are numbered behind them
        return tuple(names[column] for column in self._cut.component.columns if column < len(names))

    @property
    def joints(self) -> dict[str, Array]:
        """Each coordinate, shape (multiplicity,), of unit modal mass: m, or rad of what turns [kg^-1/2]."""
        return dict(zip(self.joint_names, self.solved.shapes[: len(self.joint_names)], strict=True))

    @cached_property
    def kinetic_shares(self) -> dict[str, float]:
        """Share of the kinetic energy by coordinate, and of the "cable"; mean over the shapes.

        Where a mass moves by several coordinates, each has the part of its momentum.
        """
        own = self._cut.component
        x = self.solved.shapes[: own.size]
        momentum = own.mass[:, None] * (own.mass_rows @ x)
        energy = np.mean((x.conj() * (own.mass_rows.T @ momentum)).real, axis=1)
        total = self._energies[1]
        shares = {
            name: float(value / total) for name, value in zip(self.joint_names, energy, strict=False) if value
        }
        return shares | {"cable": float(1.0 - sum(shares.values()))}

    @cached_property
    def strain_by_span(self) -> dict[tuple[str, str], float]:
        """Share of the strain energy by span and direction; springs and turning bodies hold the rest."""
        stored, _ = self._energies
        total = self._potential
        found: dict[tuple[str, str], float] = {}
        elastic = [
            number
            for segments in self._cut.component.segments
            for link in segments.links
            for number in link.covers
        ]
        places = self.network.places
        for link, energy in zip(
            [*self._cut.component.links.tolist(), *elastic], stored.tolist(), strict=True
        ):
            found[places[link]] = found.get(places[link], 0.0) + energy / total
        return found

    def _span_of(self, link: int) -> str:
        return self.network.drive.free_spans[self.network.pieces[self.network.piece[link]].span].name

    @cached_property
    def _energies(self) -> tuple[Array, float]:
        """Four times the strain energy of each link, and 2/omega^2 times the kinetic energy of all.

        Heavy strings and beams stand behind the strings.

        With the terms k of the stiffness over omega and r of its rate, the strain energy is (omega k +
        omega^2 r)/4 and the kinetic energy (omega^2 r - omega k)/4.
        """
        omega, cut = self.solved.omega, self._cut
        state, x = assembled(cut, omega), self.solved.shapes
        squares = [_mean_square(rows @ x) for rows in (state.stretch, cut.start, cut.end)]
        stiff = state.link * squares[0] + state.edge * (squares[1] + squares[2])
        rate = state.link_rate * squares[0] + state.edge_rate * (squares[1] + squares[2])
        if cut.component.moving:
            product = np.mean(((cut.end @ x).conj() * 1j * (state.turned @ x)).real, axis=1)
            rate = rate + 2.0 * state.link * cut.lag * product
        own = cut.component
        stored = omega * stiff + omega**2 * rate
        strain = np.bincount(cut.link, stored, own.links.size).astype(np.float64)
        masses = _mean_square(own.mass_rows @ x[: own.size])
        kinetic = float(np.sum(omega**2 * rate - omega * stiff)) / omega**2 / 2.0 + float(own.mass @ masses)
        for segments in own.segments:
            stored, own_kinetic = segments.energies(omega, x[: own.size])
            kinetic += own_kinetic
            strain = np.append(strain, stored)
        return strain, kinetic

    @property
    def _potential(self) -> float:
        """Four times the strain energy of all."""
        own, x = self._cut.component, self.solved.shapes[: self._cut.component.size]
        springs = own.spring @ _mean_square(own.spring_rows @ x)
        turning = np.sum((x.conj() * (own.geometric @ x)).real) / x.shape[1]
        return float(self._energies[0].sum() + 2.0 * springs + 2.0 * turning)

    @cached_property
    def kind(self) -> str:
        """Transverse where strings hold more than half of the strain energy, else longitudinal."""
        across = sum(share for (_, way), share in self.strain_by_span.items() if way != ALONG)
        return TRANSVERSE if across > 0.5 else LONGITUDINAL

    @property
    def place(self) -> tuple[str, str]:
        """Span and direction that hold most of the strain energy."""
        return max(self.strain_by_span, key=lambda key: self.strain_by_span[key])

    def family(self, kind: str) -> str:
        """What mainly moves: the coordinate with most of the kinetic energy, or "string"."""
        if kind == TRANSVERSE and self.kinetic_shares["cable"] >= 0.5:
            return STRING
        parts = {name: share for name, share in self.kinetic_shares.items() if name != "cable"}
        return max(parts, key=lambda name: parts[name]) if parts else STRING

    def shape(self, span: str, positions: Array) -> Array:
        """Displacement along a span in the direction of the mode's kind, see `displacement`."""
        way = self.place[1] if self.kind == TRANSVERSE else ALONG
        return self.displacement(span, way, positions)

    def displacement(self, span: str, direction: str, positions: Array) -> Array:
        """Displacement of a span in one direction, from the exact waves.

        ``direction``, {"along", "across", "out of plane"}; ``positions``, shape (p,): under tension, from the
        start of the span [m].
        Returns shape (multiplicity, p), of unit modal mass [kg^-1/2]; complex where the rope runs.
        """
        out = np.zeros((self.solved.multiplicity, positions.size), dtype=self.solved.shapes.dtype)
        way, own = DIRECTIONS.index(direction), self._cut.component
        for link in np.flatnonzero(self.network.direction[own.links] == way):
            piece = self.network.pieces[self.network.piece[own.links[link]]]
            if self.network.drive.free_spans[piece.span].name != span:
                continue
            place = piece.start
            for part in np.flatnonzero(self._cut.link == link):
                length = self._cut.share[part] * piece.length
                here = (positions >= place - 1e-12) & (positions <= place + length + 1e-12)
                out[:, here] = self._wave(int(part), (positions[here] - place) / length)
                place += length
        for segments in own.segments:
            for number, elastic in enumerate(segments.links):
                piece = self.network.pieces[self.network.piece[elastic.link]]
                ways = self.network.direction[list(elastic.covers)]
                if way not in ways or self._span_of(elastic.link) != span:
                    continue
                here = (positions >= piece.start - 1e-12) & (positions <= piece.end + 1e-12)
                inside = positions[here] - piece.start + elastic.element.before
                x = self.solved.shapes[: own.size]
                out[:, here] = segments.displacement(number, self.solved.omega, x, inside, way)
        return out

    def _wave(self, part: int, share: Array) -> NDArray[Any]:
        """Displacement at shares of one part's length: sines, with the phase of a running rope."""
        cut, omega = self._cut, self.solved.omega
        alpha, phi = omega * cut.time[part], omega * cut.lag[part]
        near, far = cut.start[part] @ self.solved.shapes, cut.end[part] @ self.solved.shapes
        turned = np.exp(1j * phi * share) if phi else 1.0
        back = np.exp(-1j * phi) if phi else 1.0
        sines = np.outer(near, np.sin(alpha * (1.0 - share))) + np.outer(back * far, np.sin(alpha * share))
        return np.asarray(turned * sines / np.sin(alpha))

    def slopes_at(self, joint: str) -> tuple[Array, Array]:
        """Refused: a carriage of a network has waves in three directions."""
        refuse_route(f"the slope at {joint}")


@dataclass(frozen=True, eq=False)
class HeldMotion:
    """A wave between ends that rest.

    Attributes
    ----------
    network : Network
    waves : tuple of HeldWaves
        Links that have this frequency.
    number : int
        Half waves n.
    """

    network: Network
    waves: tuple[HeldWaves, ...]
    number: int

    @property
    def joint_names(self) -> tuple[str, ...]:
        """None: no coordinate takes part."""
        return ()

    @property
    def joints(self) -> dict[str, Array]:
        """None."""
        return {}

    @property
    def kinetic_shares(self) -> dict[str, float]:
        """All in the cable."""
        return {"cable": 1.0}

    @property
    def place(self) -> tuple[str, str]:
        """Span and direction."""
        link = self.waves[0].link
        piece = self.network.pieces[self.network.piece[link]]
        return self.network.drive.free_spans[piece.span].name, DIRECTIONS[self.network.direction[link]]

    @property
    def strain_by_span(self) -> dict[tuple[str, str], float]:
        """All in its spans."""
        share = 1.0 / sum(wave.count for wave in self.waves)
        return {
            HeldMotion(self.network, (wave,), self.number).place: share * wave.count for wave in self.waves
        }

    def family(self, kind: str) -> str:
        """What mainly moves."""
        return STRING if kind == TRANSVERSE else "rope between held ends"

    def shape(self, span: str, positions: Array) -> Array:
        """Sine of n half waves in each span, shape (multiplicity, p), of unit modal mass [kg^-1/2]."""
        rows = []
        for wave in self.waves:
            piece = self.network.pieces[self.network.piece[wave.link]]
            own = self.network.drive.free_spans[piece.span].name == span
            share = (positions - piece.start) / piece.length
            inside = own & (share >= 0.0) & (share <= 1.0)
            # A running rope of impedance Z and travel time tau has the modal mass Z tau.
            size = np.sqrt(2.0 / (self.network.impedance[wave.link] * wave.time))
            phase = self.number * np.pi * self.network.lag[wave.link] / wave.time
            values = size * np.sin(self.number * np.pi * share) * np.exp(1j * phase * share)
            values = np.where(inside, values if phase else values.real, 0.0)
            rows += [values] * wave.count
        return np.array(rows)

    def slopes_at(self, joint: str) -> tuple[Array, Array]:
        """Refused, as of `NetworkMotion`."""
        refuse_route(f"the slope at {joint}")


PLANES = {ACROSS: "w", OUT_OF_PLANE: "v"}


def _mean_square(values: NDArray[Any]) -> Array:
    """Mean square over the shapes of a mode, shape (rows,)."""
    squares = np.abs(values) ** 2
    return np.asarray(squares[:, 0] if squares.shape[1] == 1 else np.mean(squares, axis=1))
