r"""A machine at rest: its tensions, bodies that turn under them, pulleys that they would turn.

A section is a piece of a route along which the tension is passed on: between clamps, drums, guides, driven
pulleys, and pulleys that several ropes turn. Its tension grows against gravity by the weight of its rope.
Each coordinate of a body without a spring must be in balance. A pretension is that of the straight,
weightless machine, whose unstretched lengths the ropes keep (`cabledrive.mechanics.network.rest_forces`);
bodies are where the file has them. A drum at the end of a rope that nothing drives keeps its torque, so that
the tension there stays.
"""

from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.motion import Motion, Row, gravity, sections_of
from cabledrive.mechanics.network.rest_forces import SINGULAR, RestingStretch, Ropes, solved
from cabledrive.parameters import Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.route.drive import body_number, carried_by
from cabledrive.parameters.route.geometry import Place, Point

_BALANCED = 1e-6
_ROUND_OFF = 1e-12


@described
@dataclass(frozen=True, eq=False, kw_only=True)
class Statics:
    """Forces of a machine at rest."""

    drive: Machine = meaning("the machine")
    stretches: tuple[tuple[RestingStretch, ...], ...] = meaning("one rope of each span, cut at carriages")
    preload: dict[str, float] = meaning(
        "what the springs of the bodies hold at rest, by coordinate [N] or [N m]", factory=dict
    )

    @cached_property
    def start(self) -> Array:
        """Tension of one rope at the start of each free span, shape (spans,) [N]."""
        return np.array([own[0].tensions[0] for own in self.stretches])

    @cached_property
    def end(self) -> Array:
        """At its end, shape (spans,) [N]."""
        return np.array([own[-1].tensions[1] for own in self.stretches])

    @cached_property
    def forces(self) -> Array:
        """Force of all ropes of a span on what carries its start and its end, shape (spans, 2, 2) [N]."""
        frames = np.array([(span.along, span.across) for span in self.drive.free_spans])
        ropes = np.array([self.drive.route[span.route].ropes for span in self.drive.free_spans])
        ends = np.array([(own[0].force, np.negative(own[-1].end_force)) for own in self.stretches])
        return np.einsum("sea,sax,s->sex", ends, frames.reshape(-1, 2, 2), ropes)

    @property
    def torques(self) -> Array:
        """Torque of the ropes on each pulley about its centre, shape (pulleys,) [N m]."""
        total = np.zeros(len(self.drive.pulley))
        for span, own in zip(self.drive.free_spans, self.stretches, strict=True):
            ropes = self.drive.route[span.route].ropes
            for place, sign, piece in ((span.start, 1.0, own[0]), (span.end, -1.0, own[-1])):
                if place.pulley is not None:
                    total[place.pulley] += (
                        sign * ropes * place.rim * _passed(piece, place.rim, start=sign > 0.0)
                    )
        return total

    @property
    def mean(self) -> Array:
        """Mean tension of one rope of each span, shape (spans,) [N]."""
        return 0.5 * (self.start + self.end)


def _passed(piece: RestingStretch, rim: float, *, start: bool) -> float:
    """Pull [N] where a straight rope leaves its wheel, of sense times radius [m]: rope beyond weighs."""
    (along, across), tension = (piece.force if start else piece.end_force), piece.tensions[not start]
    size = np.hypot(along, across)
    if piece.straight or not size:
        return along
    weighs = piece.load[0] * across / size + piece.load[1] * (1.0 - along / size)
    return float(size + rim * weighs / (1.0 + tension / piece.axial_rigidity))


def statics_of(
    drive: Machine,
    *,
    held: tuple[int, ...] | None = None,
    torques: Mapping[int, float] | None = None,
    pushes: bool = False,
) -> Statics:
    """Tensions at rest; ``held``: numbers of pulleys that something holds, by default `Machine.held`.

    ``torques``: on top of what stands on some pulleys [N m]; ``pushes``: whether a straight rope may, for
    those who say that it is slack.
    Raises `InputRefused` if no tensions balance the bodies, they are not determined, or one is not positive;
    `NotComputed` if none are found.
    """
    return _kept_statics(drive, held, tuple((torques or {}).items()), pushes)


@lru_cache(maxsize=64)  # the network of a machine and its warnings ask for the same
def _kept_statics(
    drive: Machine, held: tuple[int, ...] | None, torques: tuple[tuple[int, float], ...], pushes: bool
) -> Statics:
    motion = Motion(drive, hold=tuple(drive.pulley[i].name for i in (drive.held if held is None else held)))
    stretches, total = at_rest(drive, motion, dict(torques))
    for span, own in zip(drive.free_spans, stretches, strict=True):
        lowest = min(one.pull for one in own)
        if not (lowest > 0.0 or pushes):
            said = f"span {span.name}: its tension at rest is {lowest:.4g} N, a rope cannot push"
            raise InputRefused(f"{said}: raise pretension, or change masses and loads")
        if not all(one.straight or min(one.pull, one.length) > 0.0 for one in own):
            raise NotComputed(f"no state of rest found in which span {span.name} pulls: raise the pretension")
    sprung = {body.name for body in drive.body if body.stiffness > 0.0}
    preload = {
        name: -float(force)
        for name, force in zip(motion.names, total, strict=True)
        if name.rpartition(".")[0] in sprung
    }
    return Statics(drive=drive, stretches=stretches, preload=preload)


def applied_forces(drive: Machine, motion: Motion) -> Array:
    """Weights and loads on the coordinates, without the ropes, shape (n,)."""
    total = Row()
    for force, at, body in _loads(drive):
        x, y = motion.point(at, body)
        total += force[0] * x + force[1] * y
    return motion.dense(total)[0]


def _loads(drive: Machine) -> list[tuple[Array, Point, int | None]]:
    """Weights and loads [N] with the point they act on and the body that carries it."""
    g = gravity(drive)
    bodies = [(body.mass * g + np.array(body.load), body.at, i) for i, body in enumerate(drive.body)]
    return bodies + [
        (pulley.mass * g, pulley.at, body_number(drive, pulley.on, pulley.name)) for pulley in drive.pulley
    ]


def at_rest(
    drive: Machine,
    motion: Motion,
    torques: Mapping[int, float] | None = None,
) -> tuple[tuple[tuple[RestingStretch, ...], ...], Array]:
    """One rope of each span at rest, and the force on each coordinate that no spring holds yet, (n,).

    Pulleys that ``motion`` holds hand the moment of their rope to what carries them; ``torques``: on pulleys,
    on top of what stands there [N m].
    """
    torques, spans, names = torques or {}, drive.free_spans, motion.names
    visits = [place.pulley for places in drive.places for place in places]
    turning = {number for number in range(len(drive.pulley)) if motion.turns(number)}
    ends = {drum for drum, _, _ in _standing(drive)}
    several = {i for i in turning if visits.count(i) > 1 or (i in torques and i not in ends)}
    sections = sections_of(drive, turning - several)
    ropes = _ropes(drive, sections, torques)
    ends_in_order = (
        motion.end_rows(at, own.along, own.across) for own in spans for at in (own.start, own.end)
    )
    carriers = motion.dense(*(row for pair in ends_in_order for row in pair))
    carriers = carriers.reshape(len(spans), 2, 2, len(names))
    rims = motion.dense(*(motion.rim(at) for own in spans for at in (own.start, own.end)))
    rims = rims.reshape(len(spans), 2, len(names))
    first = np.array([np.flatnonzero(ropes.span == i)[0] for i in range(len(spans))], dtype=np.intp)
    last = first + np.bincount(ropes.span) - 1
    parallel = ropes.ropes[first]
    applied = applied_forces(drive, motion)
    for number, torque in torques.items():
        applied += motion.dense(torque * motion.angle(number))[0]

    def ends_of(start: Array, now: Ropes) -> Array:
        """Force on the coordinates, (n,), by that at the start of each piece, (p, 2)."""
        both = np.stack((start[first], now.weight[last] - start[last]), axis=1) * parallel[:, None, None]
        over = np.stack((now.over[first, 0], -now.over[last, 1]), axis=1) * parallel[:, None]
        return np.asarray(np.einsum("sea,sean->n", both, carriers) + np.einsum("se,sen->n", over, rims))

    bodies = {body.name for body in drive.body if body.stiffness == 0.0}
    shared = {drive.pulley[i].name for i in several}
    rows = [i for i, name in enumerate(names) if name in shared or name.rpartition(".")[0] in bodies]
    along, across = np.zeros((len(names), len(sections))), np.zeros((len(names), ropes.hangs.size))
    bound = np.zeros_like(along)
    for i, section in enumerate(ropes.section[first]):
        share = parallel[i] * carriers[i, :, 0] * np.array(((1.0,), (-1.0,)))
        along[:, section] += share.sum(axis=0)
        bound[:, section] += np.abs(share).sum(axis=0)
        across[:, ropes.run[first[i]]] += parallel[i] * carriers[i, 0, 1]
        across[:, ropes.run[last[i]]] -= parallel[i] * carriers[i, 1, 1]
    along[np.abs(along) <= _ROUND_OFF * bound] = 0.0  # round-off times 1e19 N would hold a motion
    across[:, ~ropes.hangs] = 0.0

    def rest(now: Ropes) -> Array:
        """What the ropes must add to each balance."""
        return -(applied + ends_of(now.fallen, now))[rows]

    _refuse_open(drive, ropes, along[rows], turning - several)
    with np.errstate(all="ignore"):  # of what runs away, which is refused
        ropes, tension, shear = solved(ropes, along[rows], across[rows], rest)
    for row, wanted in zip(rows, (rest(ropes) - across[rows] @ shear).tolist(), strict=True):
        pulls = along[row] * tension
        if abs(wanted - pulls.sum()) > _BALANCED * max(abs(wanted) + np.abs(pulls).sum(), 1e-9):
            _refuse_unbalanced(names[row], wanted - float(pulls.sum()), pulls, wanted)
    force = ropes.forces(tension, shear)
    found = tuple(
        _stretches(span.name, ropes, force, np.arange(a, b + 1))
        for span, a, b in zip(spans, first.tolist(), last.tolist(), strict=True)
    )
    return found, applied + ends_of(force, ropes)


def _stretches(name: str, ropes: Ropes, force: Array, own: NDArray[np.intp]) -> tuple[RestingStretch, ...]:
    """The pieces of a span."""
    ends = (ropes.wound[own[0], 0] + np.append(0.0, ropes.length[own].cumsum())).tolist()
    return tuple(
        RestingStretch(
            span=name,
            start=start,
            end=end,
            force=(float(force[i, 0]), float(force[i, 1])),
            load=(float(ropes.load[i, 0]), float(ropes.load[i, 1])),
            axial_rigidity=float(ropes.rigidity[i]),
            flow=float(ropes.flow[i]),
        )
        for i, (start, end) in zip(own.tolist(), pairwise(ends), strict=True)
    )


def _ropes(drive: Machine, sections: list[list[int]], torques: Mapping[int, float]) -> Ropes:
    """Pieces of rope between joints, straight under their pretension."""
    g, pieces, run = gravity(drive), [], -1
    for section, walk in enumerate(sections):
        for number in walk:
            span, held, start = drive.free_spans[number], True, 0.0
            rope, route = drive.ropes[span.route], drive.route[span.route]
            own = [i for i, (at, _) in enumerate(drive.carriage_places) if at == number]
            pull = np.array((span.along, span.across)) @ g
            pull[np.abs(pull) <= _ROUND_OFF * np.abs(pull).max()] = 0.0
            for i in (*sorted(own, key=lambda i: drive.carriage_places[i][1]), None):
                end = span.length if i is None else drive.carriage_places[i][1]
                run, held = run + held, i is None or drive.carriage[i].guided
                jump = (0.0 if i is None else drive.carriage[i].mass) * pull * (1.0, float(not held))
                tension = np.nan if rope.pretension is None else rope.pretension
                running = rope.density * route.speed**2
                rims = span.start.rim * (start == 0.0), span.end.rim * (i is None)
                values = end - start, rope.axial_rigidity, route.ropes, running, tension, *rims
                pieces.append((number, section, run, *values, *(rope.density * pull), *jump))
                start = end
    span_of, section_of, run_of, *columns = np.array(pieces).T
    distance, rigidity, ropes, running, pretension = columns[:5]
    none = np.zeros((distance.size, 2))
    strain = np.nan_to_num(pretension) / rigidity
    found = Ropes(
        span=span_of.astype(np.intp),
        section=section_of.astype(np.intp),
        run=run_of.astype(np.intp),
        distance=distance,
        cut=distance / (1.0 + strain),
        rigidity=rigidity,
        load=np.column_stack(columns[7:9]),
        jump=np.column_stack(columns[9:]),
        ropes=ropes,
        running=running,
        flow=running / (1.0 + strain) ** 2,
        pretension=pretension,
        standing=np.full(len(sections), np.nan),
        far=np.zeros(len(sections), dtype=np.bool_),
        rim=np.column_stack(columns[5:7]),
        wound=none,
        bow=none,
        over=none,
    )
    for drum, place, number in _standing(drive):
        last = place is drive.free_spans[number].end
        more = torques.get(drum, 0.0) / place.rim * (1.0 if last else -1.0)
        section = int(found.section[span_of == number][0])
        found.standing[section] = (pretension - running / (1.0 + strain))[span_of == number][0] + more
        found.far[section] = last
    return found


def _standing(drive: Machine) -> Iterator[tuple[int, Place, int]]:
    """Drums at whose open end a standing torque holds the pretension: number, place, span."""
    for number, data in enumerate(drive.route):
        own = [i for i, span in enumerate(drive.free_spans) if span.route == number]
        for i, place in ((own[0], drive.free_spans[own[0]].start), (own[-1], drive.free_spans[own[-1]].end)):
            drum = place.pulley if not data.closed else None
            stands = set(drive.turned) - set(drive.loads)
            if drum is not None and drum not in stands and not drive.pulley[drum].fixed:
                yield drum, place, i


def _refuse_open(drive: Machine, ropes: Ropes, along: Array, passing: Set[int]) -> None:
    """Weights that pull a rope one way round free pulleys; tensions that the balance leaves open."""
    for number, route in enumerate(drive.route):
        own = [i for i, span in enumerate(drive.free_spans) if span.route == number]
        at = np.isin(ropes.span, own)
        pull = float(ropes.drop[at, 0].sum())
        spans, rope = [drive.free_spans[i] for i in own], drive.ropes[number]
        if route.closed:  # the weight that the rope on its pulleys would add
            strain = (rope.pretension or 0.0) / rope.axial_rigidity
            falls = [np.subtract(b.contacts[0], a.contacts[1]) for a, b in pairwise([*spans, spans[0]])]
            pull += rope.density / (1.0 + strain) * float(np.sum(falls, axis=0) @ gravity(drive))
        passed = all(span.start.pulley in passing for span in spans) and np.ptp(ropes.section[at]) == 0
        if route.closed and passed and abs(pull) > _BALANCED * (1.0 + np.abs(ropes.fallen[at, 0]).max()):
            raise InputRefused(
                f'route "{route.name}": no static solution, weights on it pull {abs(pull):.4g} N one way and '
                "every pulley turns freely: drive a pulley by [[motor]], or fix one"
            )
    scale = np.abs(along).max(axis=1, initial=0.0)
    balance = along / np.where(scale > 0.0, scale, 1.0)[:, None]
    free = np.eye(along.shape[1]) - np.linalg.pinv(balance, rcond=SINGULAR) @ balance
    for number in np.unique(ropes.section[np.isnan(ropes.pretension)]).tolist():
        if np.abs(free[number]).max() > 1e-6:
            span = drive.free_spans[int(ropes.span[ropes.section == number][0])]
            raise InputRefused(
                f'route "{drive.route[span.route].name}": the balance of bodies and weights leaves the '
                f"tension of {span.name} open: give pretension [N], in [cable] or in the route"
            )


def _refuse_unbalanced(name: str, missing: float, pulls: Array, rest: float) -> None:
    """What a coordinate of a body, "car.y", or a pulley that several ropes turn lacks of its balance."""
    body, _, move = name.rpartition(".")
    unit, way = ("N m", "about its pivot") if move == "turn" else ("N", f"along {move}")
    who = f"body {body}"
    if not body:
        who, unit, way = f"pulley {name}", "N m", "about its axle"
    both = [*pulls, -rest]
    ahead, back = sum(p for p in both if p > 0.0), -sum(p for p in both if p < 0.0)
    raise InputRefused(
        f"{who}: no static solution, {abs(missing):.4g} {unit} {way} are missing; ropes, weights and "
        f"loads pull {ahead:.4g} {unit} one way and {back:.4g} {unit} the other: change loads, masses or the "
        "routes, or give it stiffness"
    )


def geometric_stiffness(motion: Motion, statics: Statics) -> Array:
    r"""Stiffness of turning bodies under constant forces, Eq. (N.4), shape (n, n).

    .. math:: K_{ij} = -\sum F \cdot \frac{\partial^2 c}{\partial q_i\,\partial q_j}, \qquad
              \frac{\partial^2 c}{\partial q_a\,\partial q_b} = e_z \times \frac{\partial c}{\partial q_b}

    where a turns and carries b, or is b itself; zero else.
    """
    drive, total = motion.drive, np.zeros((len(motion.names), len(motion.names)))
    loads = _loads(drive)
    for number, span in enumerate(drive.free_spans):
        for end, place in enumerate((span.start, span.end)):
            loads.append((statics.forces[number, end], place.centre, motion.body_of(place)))
    for force, at, body in loads:
        x, y = motion.point(at, body)
        turned = force[1] * x - force[0] * y  # F . (e_z x dc/dq)
        chain = carried_by(drive, body)
        for position, outer in enumerate(chain):
            for a in motion.unit(f"{drive.body[outer].name}.turn"):
                for inner in chain[: position + 1]:
                    for move in drive.body[inner].moves:
                        for b in motion.unit(f"{drive.body[inner].name}.{move}"):
                            for entry in {(a, b), (b, a)} if inner != outer else {(a, b)}:
                                total[entry] -= turned.get(b, 0.0)
    return total


def unheld_words(motion: Motion, statics: Statics) -> list[str]:
    """A warning for each pulley that nothing in the file holds at rest, such as the far drum of a line."""
    drive = motion.drive
    largest = float(np.abs(statics.forces).max(initial=0.0))
    return [
        f"the ropes at rest turn pulley {pulley.name} by {abs(torque):.4g} N m and nothing in the file holds "
        "it: what is computed holds where a load does; else give it a motor, or fixed = true where a brake "
        "does"
        for number, (pulley, torque) in enumerate(zip(drive.pulley, statics.torques, strict=True))
        if motion.turns(number)
        and number not in set(drive.turned) - set(drive.loads)
        and abs(torque) > pulley.coulomb_friction + _BALANCED * largest * pulley.radius
    ]
