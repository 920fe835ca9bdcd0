"""Modes in the terms of the machine: where their energy is, what mainly moves, and how each is named."""

from functools import cached_property
from math import pi

import numpy as np

from cabledrive.mechanics.holding import DRIVE_PULLEY, LOAD_PULLEY
from cabledrive.modal.elements import ACROSS, ALONG, OUT, Wave
from cabledrive.modal.mode import BOTH, LONGITUDINAL, STRING, TRANSVERSE
from cabledrive.modal.networks import ModalNetwork
from cabledrive.modal.rows import Array
from cabledrive.modal.shapes import Place, Shape, SlopeWave, Values

PLANES = {ACROSS: "w", OUT: "v"}
ALONE = 0.99
"""Share of one section in the strain energy across above which a mode is called its own."""
_AT_REST = 1e-2


class Mode(Shape):
    """One natural frequency, with as many shapes as its multiplicity.

    Attributes
    ----------
    frequency : float
        Natural frequency [Hz].
    multiplicity : int
        Number of independent shapes at this frequency.
    clamped : bool
        Of a machine with routes: a wave of one rope between ends that rest.
    proven : bool
        Whether counts just below and just above prove that it exists, with this multiplicity.
    """

    @cached_property
    def kind(self) -> str:
        """Transverse where ropes across hold more than half of the strain energy, else longitudinal."""
        if not self.ways - {ALONG} or ALONG not in self.ways:
            return TRANSVERSE if self.ways - {ALONG} else LONGITUDINAL
        across = sum(share for (_, way, _), share in self.places.items() if way != ALONG)
        return TRANSVERSE if across > 0.5 else LONGITUDINAL

    @cached_property
    def where(self) -> tuple[str, str, tuple[float, float] | None]:
        """Of a transverse mode: span, direction, section; "both" where it is shared by both spans."""
        shares = {place: share for place, share in self.places.items() if place[1] != ALONG}
        span, way, section = max(shares, key=lambda place: round(shares[place], 9))  # of equal ones the first
        if self.network.by_span:
            return span, way, section
        total = sum(shares.values())
        if shares[span, way, section] >= ALONE * total:
            return span, way, section
        taking = [place for place, share in shares.items() if share > (1.0 - ALONE) * total]
        if len({place[0] for place in taking}) > 1:
            return BOTH, way, None
        return span, way, (min(own[0] for _, _, own in taking), max(own[1] for _, _, own in taking))

    @property
    def span(self) -> str | None:
        """Of a transverse mode the span that vibrates, "both" where sag couples "upper" and "lower"."""
        return self.where[0] if self.kind == TRANSVERSE else None

    @property
    def plane(self) -> str | None:
        """Of a transverse mode "v" (horizontal) or "w" (the plane of the loop)."""
        return PLANES[self.where[1]] if self.kind == TRANSVERSE else None

    @property
    def section(self) -> tuple[float, float] | None:
        """Of a transverse mode of one span: unstretched ends of its section, from where that starts [m]."""
        return self.where[2] if self.kind == TRANSVERSE else None

    @property
    def model(self) -> str | None:
        """Of a transverse mode what the cable is taken for: `STRING`, `HEAVY_STRING`, `SAGGING`, `BEAM`."""
        return self.taken_for(self.where[0], self.where[1]) if self.kind == TRANSVERSE else None

    @property
    def single(self) -> list["Mode"]:
        """Of a machine with routes: modes of one shape each, the first of which moves its span the most."""
        if self.multiplicity == 1 or self.clamped:
            return [self]
        span, way, section = self.where
        turned = np.linalg.svd(self.displacement(span, way, np.linspace(*section or (0.0, 1.0), 33)))[0]
        first, rest = (
            Mode(self.network, self.cut, self.solved._replace(shapes=own, multiplicity=own.shape[1]))
            for own in np.split(self.solved.shapes @ turned, [1], axis=1)
        )
        return [first, *rest.single]

    @cached_property
    def strain_by_span(self) -> dict[tuple[str, str], float]:
        """Share of the strain energy by span and direction; springs hold the rest."""
        found: dict[tuple[str, str], float] = {}
        for (span, way, _), share in self.places.items():
            found[span, way] = found.get((span, way), 0.0) + share
        return found

    @property
    def strain_shares(self) -> dict[str, float]:
        """Of a machine with routes: share of the strain energy by span and direction, "belt 1, along"."""
        found = self.strain_by_span.items() if self.network.by_span else ()
        return {f"{span}, {way}": share for (span, way), share in found if share > 0.0}

    @cached_property
    def joints(self) -> dict[str, Values]:
        """Displacement of each joint, shape (multiplicity,), of unit modal mass [kg^-1/2]; rims: r theta."""
        if self.network.by_span:
            return dict(self.coordinates)
        none = np.zeros(self.multiplicity)
        if self.kind == LONGITUDINAL:
            own = {
                name: value * self.network.units.get(name, 1.0)
                for name, value in self.coordinates.items()
                if not name.endswith((ACROSS, OUT))
            }
            return own | {name: none for name in self.network.rims if name not in own}
        span, way, section = self.where
        found: dict[str, Values] = {}
        for number in sorted({number for number, _ in self.tags}):
            piece = self.network.pieces[number]
            inside = section is None or (section[0] <= piece.start and piece.end <= section[1])
            if span in (BOTH, piece.span) and inside:
                for name in piece.joints:
                    found[name] = self.coordinates.get(f"{name} {way}", none)
        return found

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints that take part, in order."""
        return tuple(self.joints)

    @cached_property
    def kinetic_shares(self) -> dict[str, float]:
        """Share of the kinetic energy in each joint that moves and in the "cable"; mean over the shapes."""
        if self.network.by_span:
            return self.kinetic
        found: dict[str, float] = {}
        for name, share in self.kinetic.items():
            joint = name.removesuffix(f" {ACROSS}").removesuffix(f" {OUT}")
            found[joint] = found.get(joint, 0.0) + share
        return found

    @cached_property
    def family(self) -> str:
        """What mainly moves.

        Of a machine with routes the coordinate with most of the kinetic energy, or "string". Else
        "carriage-dominated" if carriages hold half of the kinetic energy or more; else, of a transverse mode,
        "string"; of a longitudinal one the spring that holds half of the strain energy, else, by the motion
        of both rims, "pulleys out of phase", "pulleys in phase", "pulleys at rest", "drive pulley turning" or
        "load pulley turning" (the other at rest), or "pulleys independent" (a multiple mode that has both).
        """
        shares, kind = self.kinetic_shares, self.kind
        if self.network.by_span:
            parts = {name: share for name, share in shares.items() if name != "cable"}
            if kind == TRANSVERSE and shares["cable"] >= 0.5:
                return "string"
            if not parts:
                return "string" if kind == TRANSVERSE or not self.clamped else "rope between held ends"
            return max(parts, key=lambda name: round(parts[name], 9))  # of equal ones the first
        if sum(share for name, share in shares.items() if name.startswith("carriage")) >= 0.5:
            return "carriage-dominated"
        if kind == TRANSVERSE:
            return "string"
        spring = max(self.springs, key=lambda name: self.springs[name], default="")
        if self.springs.get(spring, 0.0) >= 0.5:
            return spring
        if not self.network.rims:
            return "chain"
        rims = {name: self.joints[name] for name in self.network.rims}
        turning = [name for name, u in rims.items() if np.sum(u**2) * self.mass > _AT_REST**2]
        if len(turning) < 2:
            return f"{turning[0]} turning" if turning else "pulleys at rest"
        drive, load = rims[DRIVE_PULLEY], rims[LOAD_PULLEY]
        product, size = np.sum(drive * load), np.sqrt(np.sum(drive**2) * np.sum(load**2))
        if abs(product) < 0.5 * size:
            return "pulleys independent"
        return "pulleys in phase" if product > 0 else "pulleys out of phase"

    def shape(self, span: str, positions: Array) -> Values:
        """Displacement along a span, from the exact waves: Eqs. (3.11), (3.18), (3.24), (3.28).

        Parameters
        ----------
        span : {"upper", "lower"}
        positions : array_like, shape (p,)
            Unstretched positions from the pulley where the span starts [m].

        Returns
        -------
        ndarray, shape (multiplicity, p)
            Displacements of unit modal mass [kg^-1/2]; zero where this mode does not reach.
        """
        way = self.where[1] if self.kind == TRANSVERSE else ALONG
        return self.displacement(span, way, np.asarray(positions, dtype=float))


class HeldMode(Mode):
    """A harmonic of ropes between ends that rest; ``waves``: with how many ropes have it."""

    def __init__(
        self, network: ModalNetwork, waves: tuple[tuple[Wave, int], ...], number: int, frequency: float
    ) -> None:
        self.network, self.waves, self.number, self.frequency = network, waves, number, frequency
        self.multiplicity, self.clamped, self.proven = sum(n for _, n in waves), network.by_span, True
        self.tags = [wave.tag for wave, _ in waves]
        self.ways = {way for _, way in self.tags}
        self.mass = sum(wave.z * wave.time for wave, _ in waves)
        self.coordinates, self.springs, self.kinetic = {}, {}, {"cable": 1.0}

    @cached_property
    def places(self) -> dict[Place, float]:
        """Share of the strain energy by span, direction and section."""
        found: dict[Place, float] = {}
        for wave, times in self.waves:
            piece = self.network.pieces[wave.tag[0]]
            key = piece.span, wave.tag[1], piece.section
            found[key] = found.get(key, 0.0) + times / self.multiplicity
        return found

    def taken_for(self, span: str, way: str) -> str:
        """A string."""
        return STRING

    def displacement(self, span: str, way: str, positions: Array) -> Values:
        """Sine of n half waves in each span, shape (multiplicity, p), of unit modal mass [kg^-1/2]."""
        rows = []
        for wave, times in self.waves:
            piece = self.network.pieces[wave.tag[0]]
            share = (positions - piece.start) / (piece.end - piece.start)
            inside = (piece.span == span) & (wave.tag[1] == way) & (share >= 0.0) & (share <= 1.0)
            # A rope of impedance Z and travel time tau has the modal mass Z tau.
            values = np.sqrt(2.0 / (wave.z * wave.time)) * np.sin(self.number * pi * share)
            if wave.lag:
                values = values * np.exp(1j * self.number * pi * wave.lag / wave.time * share)
            rows += [np.where(inside, values, 0.0)] * times
        return np.array(rows)

    def slope_waves(self, shape: int = 0) -> tuple[SlopeWave, ...]:
        """The wave of one shape."""
        wave = [own for own, times in self.waves for _ in range(times)][shape]
        piece = self.network.pieces[wave.tag[0]]
        length = piece.end - piece.start
        k = self.number * pi / length
        slope = k * complex(np.sqrt(2.0 / (wave.z * wave.time)), 0.0)
        return (SlopeWave(span=piece.span, start=piece.start, length=length, wave_number=k, slope=slope),)
