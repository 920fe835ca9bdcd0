r"""What a network is made of: waves in closed form, and ropes as polynomials. Both give rows.

A `Wave` is a straight string or rod of even tension, of any length. A `Rope` is everything else, one form

.. math:: 2V = \int A\,(c\,u' + s\,w')^2 + R\,(c\,w' - s\,u')^2 + B\,w''^2\,\mathrm{d}x, \qquad
          2T = \int \rho\,(\dot u^2 + \dot w^2)\,\mathrm{d}x \qquad \text{Eq. (M.11)}

with A = EA, R = T/(1 + T/EA), B = EI and the direction (c, s) of the rope at rest, which change along it: a
heavy string has only R, a beam R and B, a rope that sags, however deep, A, R and (c, s). On segments of less
than half a wave polynomials of degree 11 leave out less than round-off. The inner ones are condensed to modes
between held ends (Craig and Bampton [1]_), each of which is one row. A rope that runs has
:math:`\rho v^2` less of A and R, and the momentum that it carries along, Eq. (M.12); its modes are two rows.

References
----------
.. [1] R. R. Craig and M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA J. 6 (1968)
   1313-1319.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise
from math import ceil, inf, log, pi, sqrt
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial, legendre
from numpy.typing import NDArray

from cabledrive.modal.rows import MASS, ONE_WAY, POLE, SPRING, TURN, Array, Integers
from cabledrive.parameters import InputRefused

Values = NDArray[Any]

ALONG, ACROSS, OUT = "along", "across", "out of plane"

DEGREE = 11
"""Of the polynomials on a segment."""
PHASE = 2.0
"""Of the shortest wave along a segment [rad]: below half a turn, so that none has a mode of its own."""
MOST_SEGMENTS = 20_000
"""Of one hanging rope: some hundred megabytes."""
STEEPER = 2.0
"""Largest ratio of the tensions at the ends of a segment."""
LAYER = 4.0
"""Length of the first segment of a beam over sqrt(EI/T); those behind it are twice as long each."""

Row = tuple[
    tuple[int, float], ...
]  # how an end moves in one direction: coordinates with factors; none: at rest
Tag = tuple[int, str]  # number of the piece of a span, and direction


@dataclass(frozen=True, slots=True)
class Wave:
    """A straight rope of even tension in one direction.

    ``z``: impedance of one rope [kg/s]; ``time``, ``lag``: [s]; ``ropes``: side by side; ``ring``: ring
    frequency of a rope that is curved, along [rad/s]; ``cosine``: of its slope at its ends.
    """

    start: Row
    end: Row
    z: float
    time: float
    tag: Tag
    lag: float = 0.0
    ropes: int = 1
    ring: float = 0.0
    cosine: tuple[float, float] = (1.0, 1.0)

    @property
    def tags(self) -> tuple[Tag, ...]:
        """Where it is."""
        return (self.tag,)

    def time_at(self, omega: float) -> float:
        """Travel time of a wave of a frequency [rad/s]."""
        return self.time / sqrt(1.0 + (self.ring / omega) ** 2)

    def held(self, number: int) -> float:
        """Frequency of a harmonic between ends at rest [rad/s]."""
        straight = (number * pi / self.time) ** 2
        return sqrt(0.5 * straight + sqrt(0.25 * straight**2 + straight * self.ring**2))

    @property
    def rows(self) -> tuple[Row, ...]:
        """How both its ends move."""
        return self.start, self.end


@dataclass(frozen=True, eq=False)
class Rope:
    r"""A rope whose force or direction changes along it, or which bends; lengths as of its coordinate x.

    ``start``, ``end``: rows of its ends in the order u, w, w'; ``hold``: R at places [N]; ``density``:
    [kg/m]; ``tags``: of the directions that it covers; ``vanishes``: the place in the complex plane where R
    would [m], infinite of an even one; ``direction``: (c, s) at places, of one that moves along as well;
    ``pull``: A [N]; ``bend``: B [N m^2]; ``speed``: at which it runs, unstretched [m/s], with R and A less
    by :math:`\rho v^2`; ``longer``: its length over that between the places where it is stretched;
    ``inside``: shares of it at which its piece starts and ends; ``taut``: what it is without sag;
    ``straight``: above ``edge`` [rad/s], where that moves no mode any more.
    """

    start: tuple[Row, ...]
    end: tuple[Row, ...]
    length: float
    hold: Callable[[Array], Array]
    density: float
    tags: tuple[Tag, ...]
    vanishes: complex
    direction: Callable[[Array], tuple[Array, Array]] | None = None
    pull: float = 0.0
    bend: float = 0.0
    speed: float = 0.0
    ropes: int = 1
    longer: float = 1.0
    inside: tuple[float, float] = (0.0, 1.0)
    taut: tuple["Wave | Rope", ...] = ()
    straight: tuple["Wave | Rope", ...] = ()
    edge: float = inf

    @property
    def rows(self) -> tuple[Row, ...]:
        """How both its ends move."""
        return (*self.start, *self.end)

    @cached_property
    def time(self) -> float:
        """Travel time of a wave across [s]."""
        held = self.hold(np.linspace(0.0, self.length, 33)) + self.bend / self.length**2
        slow = np.sqrt(self.density * (held + self.density * self.speed**2)) / held
        return float(self.length * slow.mean())

    def places(self, top: float) -> Array:
        """Ends of segments that have no mode of their own up to a frequency [rad/s], as shares."""
        marks, layer = {0.0, 1.0}, self.length
        if self.bend:
            first = layer = LAYER * sqrt(self.bend / float(self.hold(np.array([0.0, self.length])).min()))
            while layer < 0.5 * self.length:
                marks |= {layer / self.length, 1.0 - layer / self.length}
                layer = 2.0 * layer + first
        if np.isfinite(self.vanishes):  # at most doubled from place to place, where it is |x - vanishes|
            lowest, near = self.vanishes.real / self.length, max(abs(self.vanishes.imag) / self.length, 1e-9)
            marks |= {lowest} if near < lowest < 1.0 - near else set()
            for a, b in pairwise(sorted(marks)):
                steep = np.arcsinh((np.array((a, b)) - lowest) / near)
                steps = ceil(float(steep[1] - steep[0]) / log(STEEPER))
                marks.update(
                    (lowest + near * np.sinh(np.linspace(steep[0], steep[1], steps + 1)[1:-1])).tolist()
                )
        places = np.array(sorted(marks))
        least = self.hold(self.length * places)
        least = np.minimum(least[:-1], least[1:])
        wave = top * np.sqrt(
            2.0 * self.density / (least + np.sqrt(least**2 + 4.0 * self.bend * self.density * top**2))
        )
        if self.speed:  # of its two waves the shorter one, as if it did not bend
            flow = self.density * self.speed**2
            wave = top * np.sqrt(self.density) * (np.sqrt(flow) + np.sqrt(flow + least)) / least
        counts = np.maximum(1.0, np.ceil(wave * self.length * np.diff(places) / PHASE))
        if not counts.sum() <= MOST_SEGMENTS:
            raise InputRefused(
                f"a hanging rope of {self.length:.4g} m needs {counts.sum():.3g} segments up to "
                f"{top / (2 * pi):.4g} Hz, at most {MOST_SEGMENTS} are taken: ask for fewer modes"
            )
        parts = zip(places, places[1:], counts.astype(int), strict=False)
        return np.concatenate([a + (b - a) * np.arange(n) / n for a, b, n in parts] + [[1.0]])

    @cached_property
    def _made(self) -> dict[bytes, "Segments"]:
        return {}

    def segments(self, top: float) -> "Segments":
        """Its segments up to a frequency [rad/s]: springs and inertia at rest, modes between held ends."""
        places = self.places(top)
        if (key := places.tobytes()) not in self._made:
            self._made[key] = self._divided(places)
        return self._made[key]

    def _divided(self, places: Array) -> "Segments":
        along, beam = self.direction is not None, self.bend > 0.0
        nodes, weight, shapes = _gauss(along, beam)
        size = self.length * np.diff(places)
        x = self.length * places[:-1, None] + 0.5 * size[:, None] * (1.0 + nodes)
        measure, rate = 0.5 * size[:, None] * weight, (2.0 / size)[:, None, None]
        root = np.sqrt(measure * self.hold(x))[:, :, None]
        strains, moved = [root * rate * shapes[3]], [np.sqrt(measure * self.density)[:, :, None] * shapes[2]]
        if self.direction is not None:
            full = np.sqrt(measure * self.pull * self.longer)[:, :, None]
            c, s = (own[..., None] for own in self.direction(x))
            strains = [root * rate * (c * shapes[3] - s * shapes[1])]
            strains.append(full * rate * (c * shapes[1] + s * shapes[3]))
            moved.append(np.sqrt(measure * self.density / self.longer)[:, :, None] * shapes[0])
        if beam:
            strains.append(np.sqrt(measure * self.bend)[:, :, None] * rate**2 * shapes[4])
        ends = 2 * (1 + along + beam)
        strain, motion = np.concatenate(strains, 1), np.concatenate(moved, 1)
        turned, factor = np.linalg.qr(strain[:, :, ends:])
        inverse = np.linalg.inv(factor)
        inner = motion[:, :, ends:] @ inverse
        still = -inverse @ (turned.swapaxes(1, 2) @ strain[:, :, :ends])
        at_rest = strain[:, :, :ends] + strain[:, :, ends:] @ still
        mass = motion[:, :, :ends] + motion[:, :, ends:] @ still
        if self.speed:
            base = np.zeros((size.size, strain.shape[2], strain.shape[2]))
            base[:, :ends, :ends], base[:, ends:, :ends], base[:, ends:, ends:] = np.eye(ends), still, inverse
            values, slopes = (np.concatenate(shapes[i : i + 3 : 2]) for i in (0, 1))
            moves = (values * np.tile(weight, 2)[:, None]).T @ slopes
            turn = 1j * self.density * self.speed * (base.swapaxes(1, 2) @ (moves - moves.T) @ base)
            kinds, b, value, waves = _modes_of_flow(turn, mass, inner)
        else:
            _, give, vectors = np.linalg.svd(inner, full_matrices=False)
            waves = vectors.swapaxes(1, 2) / give[:, None, :]  # of unit modal mass
            kinds, b = [MASS] * ends + [POLE] * give.shape[1], np.pad(1.0 / give, ((0, 0), (ends, 0)))
            value = np.concatenate((np.linalg.qr(mass, mode="r"), (inner @ waves).swapaxes(1, 2) @ mass), 1)
        value = np.concatenate((np.linalg.qr(at_rest, mode="r"), value), 1)
        if beam:  # the polynomials count slopes times the length
            for own in (value, still):
                own[:, :, [ends // 2 - 1, ends - 1]] *= size[:, None, None]
        return Segments(
            rope=self,
            places=places,
            x=x,
            size=size,
            kind=np.tile([SPRING] * ends + kinds, (size.size, 1)),
            b=np.pad(b, ((0, 0), (ends, 0))),
            value=value,
            still=still,
            waves=inverse @ waves,
        )


@dataclass(frozen=True, eq=False)
class Segments:
    """The segments of a rope, p of them with r rows each by the motion of their ends.

    ``places``: their ends as shares; ``kind``, ``b``, shape (p, r), ``value``, shape (p, r, ends): rows;
    ``still``, ``waves``: inner polynomials by the ends at rest, and by the modes between held ends.
    """

    rope: Rope
    places: Array
    x: Array
    size: Array
    kind: Integers
    b: Array
    value: Values
    still: Array
    waves: Values

    def factors(self, omega: float | Array, ends: Values) -> Values:
        """Factors of all polynomials, shape (p, n, k), by the motion of their ends, shape (p, ends, k).

        ``omega``: of all columns, or of each, (k,) [rad/s].
        """
        k, number = ends.shape[1], self.waves.shape[2]
        pole, b = self.value[:, -number:], self.b[:, -number:, None]
        share = b * omega / (omega - b) if self.rope.speed else omega**2 / (b**2 - omega**2)
        inside = self.still @ ends + self.waves @ (share * (pole @ ends))
        if self.rope.bend:
            ends = ends.copy()
            ends[:, [k // 2 - 1, k - 1]] *= self.size[:, None, None]
        return np.asarray(np.concatenate((ends, inside), axis=1))

    def share_across(self, omega: Array, ends: Values, modes: int) -> Array:
        """Share of the strain energy that turns or bends it, with half of what mixes both, shape (modes,).

        ``omega``, ``ends``: of columns as in `factors`, as many of each mode.
        """
        q = self.factors(omega, ends)
        whole, across = (np.sum((q.conj() * (form @ q)).real, axis=(0, 1)) for form in self._forms)
        across, whole = (own.reshape(modes, -1).sum(1) for own in (across, whole))
        return np.asarray(np.clip(across / np.maximum(whole, 1e-300), 0.0, 1.0))

    @cached_property
    def _forms(self) -> tuple[Array, Array]:
        """Twice the strain energy of each segment in its polynomials, and that across, shape (p, n, n)."""
        rope, (_, weight, shapes) = self.rope, _gauss(True, self.rope.bend > 0.0)
        rate = (2.0 / self.size)[:, None, None]
        measure = (0.5 * self.size[:, None] * weight)[:, :, None]
        c, s = (own[..., None] for own in rope.direction(self.x))  # type: ignore[misc]  # of what moves along
        along, across, bent = rate * shapes[1], rate * shapes[3], rate**2 * shapes[4]
        stretched, pull = c * along + s * across, measure * rope.pull * rope.longer
        turned, hold = c * across - s * along, measure * rope.hold(self.x)[:, :, None]
        bends = rope.bend * (bent * measure).swapaxes(1, 2) @ bent
        whole = (stretched * pull).swapaxes(1, 2) @ stretched + (turned * hold).swapaxes(1, 2) @ turned
        own = (s * across * pull).swapaxes(1, 2) @ stretched + (c * across * hold).swapaxes(1, 2) @ turned
        return whole + bends, own + bends

    def displacement(self, omega: float, ends: Values, share: Array) -> tuple[Values, Values]:
        """Along and across at shares of the rope, shape (k, q) each."""
        at = np.clip(np.searchsorted(self.places, share, "right") - 1, 0, self.places.size - 2)
        local = 2.0 * (share - self.places[at]) / np.diff(self.places)[at] - 1.0
        q = self.factors(omega, ends)[at]
        both = _legendre(self.rope.direction is not None, self.rope.bend > 0.0)
        shown = legendre.legvander(local, both[0].shape[0] - 1)
        along, across = (np.einsum("qn,qnk->kq", shown @ own, q) for own in both)
        return along, across


def _modes_of_flow(turn: Values, mass: Array, inner: Array) -> tuple[list[int], Array, Values, Values]:
    r"""Rows of a rope that runs behind its springs: kinds, b and rows; its modes by the inner polynomials.

    ``turn``: the momentum that it carries along, by the ends first, with the inner ones of unit stiffness.
    With :math:`\nu = 1/b` they satisfy :math:`(\nu^2 + \nu H - M)\,z = 0`, a symmetric problem of twice the
    size, the frequencies of waves that go one way and, below zero, the other.
    """
    ends, n = mass.shape[2], inner.shape[2]
    whole = np.zeros((mass.shape[0], 2 * n, 2 * n), dtype=complex)
    whole[:, :n, :n] = -turn[:, ends:, ends:]
    whole[:, n:, :n] = np.linalg.qr(inner, mode="r")
    slow, vectors = np.linalg.eigh(whole)  # of the lower half
    waves, coupled = vectors[:, :n], turn[:, ends:, :ends]
    back = waves.conj().swapaxes(1, 2)
    pole = back @ coupled - back @ (inner.swapaxes(1, 2) @ mass) / slow[:, :, None]
    inertia = np.linalg.qr(np.concatenate((mass, coupled.imag), 1), mode="r")
    carried, ways = np.linalg.eigh(turn[:, :ends, :ends])
    flow = np.sqrt(np.abs(carried))[:, :, None] * ways.conj().swapaxes(1, 2)
    b = np.concatenate((np.zeros(carried.shape), np.sign(carried), 1.0 / slow), 1)
    kinds = [MASS] * ends + [TURN] * ends + [ONE_WAY] * (2 * n)
    return kinds, b, np.concatenate((inertia, flow, pole), 1), waves


@cache
def _legendre(along: bool, beam: bool) -> tuple[Array, Array]:
    """Coefficients of u and w of all polynomials in those of Legendre, (degrees, n)."""
    u, _, w, _, _ = _polynomials(along, beam)
    degrees = max(own.degree() for own in (*u, *w)) + 1
    first, second = np.zeros((2, degrees, len(u)))
    for total, part in ((first, u), (second, w)):
        for row, own in zip(total.T, part, strict=True):
            row[: own.degree() + 1] = own.convert(kind=legendre.Legendre).coef
    return first, second


@cache
def _gauss(along: bool, beam: bool) -> tuple[Array, Array, tuple[Array, ...]]:
    """Points, weights, and at them u, u', w, w', w'' of all polynomials, those of the ends first."""
    nodes, weights = legendre.leggauss(DEGREE + 6)
    values = (np.stack([own(nodes) for own in part], -1) for part in _polynomials(along, beam))
    return nodes, weights, tuple(values)


@cache
def _polynomials(along: bool, beam: bool) -> tuple[list[Polynomial], ...]:
    """u, u', w, w', w'' on -1..1."""
    zero, near, far = Polynomial([0.0]), Polynomial([0.5, -0.5]), Polynomial([0.5, 0.5])
    bubbles = [legendre.Legendre.basis(k).integ(lbnd=-1) * np.sqrt(k + 0.5) for k in range(1, DEGREE)]
    held, first, last = bubbles, [near], [far]
    if beam:
        held = [
            legendre.Legendre.basis(k).integ(lbnd=-1).integ(lbnd=-1) * (k + 0.5) ** 1.5
            for k in range(2, DEGREE - 1)
        ]
        first = [Polynomial([0.5, -0.75, 0.0, 0.25]), Polynomial([0.125, -0.125, -0.125, 0.125])]
        last = [Polynomial([0.5, 0.75, 0.0, -0.25]), Polynomial([-0.125, -0.125, 0.125, 0.125])]
    none = [zero] * len(first)
    u, w = [zero] * (2 * len(first) + len(held)), [*first, *last, *held]
    if along:
        u = [near, *none, far, *none, *bubbles, *[zero] * len(held)]
        w = [zero, *first, zero, *last, *[zero] * len(bubbles), *held]
    return u, [own.deriv() for own in u], w, [own.deriv() for own in w], [own.deriv(2) for own in w]
