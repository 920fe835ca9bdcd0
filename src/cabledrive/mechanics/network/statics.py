r"""A machine at rest: its tensions, bodies that turn under them, pulleys that they would turn.

A section is a piece of a route along which the tension is passed on: between clamps, drums, guides, driven
pulleys, and pulleys that several ropes turn. Its tension grows against gravity by :math:`\rho g` per metre of
height. Unknown is one tension a section; each coordinate of a body without a spring must be in balance. A
pretension is that of the straight, weightless machine, whose unstretched lengths the ropes keep. With n
ropes, mean tensions T of the spans and the shear V of what hangs on them the tensions are those of the least
complementary energy, of shallow sag,

.. math:: \sum_{spans} n \int \frac{(T - T_0)^2}{2EA} + \frac{V^2}{2(T - \rho v^2)}\,dx \to \min .
          \qquad \text{Eq. (N.10)}

A drum at the end of a rope that nothing drives keeps its torque, so that the tension there stays.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.motion import Motion, Offsets, gravity, section_numbers, sections_of
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.route.geometry import Point

_BALANCED = 1e-6
_SINGULAR = 1e-10
_ROUND_OFF = 1e-12
_ROUNDS = 4
_STEPS, _SETTLED = 100, 1e-13


@described
@dataclass(frozen=True, eq=False, kw_only=True)
class Statics:
    """Forces of a machine at rest."""

    start: Array = meaning("(spans,): tension of one rope at the start of each free span [N]")
    end: Array = meaning("(spans,): at its end [N]")
    line_load: Array = meaning("(spans, 2): weight of one rope per metre [N/m]")
    forces: Array = meaning(
        "(spans, 2, 2): force of all parallel ropes of a span on what carries its start and its end [N]"
    )
    preload: dict[str, float] = meaning(
        "what the springs of the bodies hold at rest, by coordinate [N] or [N m]"
    )

    @property
    def mean(self) -> Array:
        """Mean tension of one rope of each span, shape (spans,) [N]."""
        return 0.5 * (self.start + self.end)


def statics_of(drive: RoutedDrive) -> Statics:
    """Tensions at rest.

    Parameters
    ----------
    drive : RoutedDrive

    Returns
    -------
    Statics

    Raises
    ------
    InputRefused
        If no tensions balance the bodies, they are not determined, or one is not positive.
    NotComputed
        If none are found.
    """
    motion = Motion(drive)
    walks = sections_of(drive)
    sections, count = section_numbers(walks, len(drive.free_spans)), len(walks)
    strain = np.zeros(len(drive.free_spans))
    pulls = Pulls.of(drive, motion)
    weightless = drive.layout.gravity == 0.0 and not any(route.speed for route in drive.route)
    for _ in range(1 if weightless else _ROUNDS):  # the weight of a rope depends on its strain, slightly
        offsets = Offsets(drive, walks, strain)
        tension = _balanced(drive, motion, pulls, sections, count, offsets)
        start = tension[sections] + offsets.start
        end = tension[sections] + offsets.end
        rigidity = np.array([drive.ropes[span.route].axial_rigidity for span in drive.free_spans])
        strain = 0.5 * (start + end) / rigidity
    for number, span in enumerate(drive.free_spans):
        lowest = min(start[number], end[number])
        if not lowest > 0.0:
            said = f"span {span.name}: its tension at rest is {lowest:.4g} N, a rope cannot push"
            raise InputRefused(f"{said}: raise pretension, or change masses and loads")
    forces = offsets.constant + tension[sections][:, None, None] * offsets.unit
    total = applied_forces(drive, motion) + pulls.forces(forces)
    sprung = {body.name for body in drive.body if body.stiffness > 0.0}
    return Statics(
        start=start,
        end=end,
        line_load=offsets.line_load,
        forces=forces,
        preload={
            name: -float(force)
            for name, force in zip(motion.names, total, strict=True)
            if name.rpartition(".")[0] in sprung
        },
    )


def applied_forces(drive: RoutedDrive, motion: Motion) -> Array:
    """Weights and loads on the coordinates, without the ropes, shape (n,)."""
    g, total = gravity(drive), np.zeros(len(motion.names))
    for number, body in enumerate(drive.body):
        total += (body.mass * g + np.array(body.load)) @ motion.point(body.at, number)
    for pulley in drive.pulley:
        total += pulley.mass * g @ motion.point(pulley.at, drive.body_number(pulley.on, pulley.name))
    return total


@dataclass(frozen=True, eq=False)
class Pulls:
    """How the coordinates of bodies move the ends of all spans."""

    ends: Array  # (spans, 2 ends, 2 directions, n): motion of what carries the ends: the centres of pulleys
    shafts: Array
    """(spans, 2 ends, n): motion of the shafts that take the moment of each end, per unit tension."""
    along: Array  # (spans, 2): directions of travel

    @classmethod
    def of(cls, drive: RoutedDrive, motion: Motion) -> "Pulls":
        """Of a machine: guides and driven pulleys hand the moment of the rope to what carries them."""
        spans, n = drive.free_spans, len(motion.names)
        ends, shafts = np.zeros((len(spans), 2, 2, n)), np.zeros((len(spans), 2, n))
        for number, span in enumerate(spans):
            for end, (place, sign) in enumerate(((span.start, 1.0), (span.end, -1.0))):
                body, pulley = motion.body_of(place), place.pulley
                if body is None:
                    continue
                ends[number, end] = motion.point(place.centre, body)
                if pulley is not None and (drive.pulley[pulley].fixed or pulley in drive.driven):
                    shafts[number, end] = sign * place.sense * place.radius * motion.rotation(body)
        return cls(ends, shafts, np.array([span.along for span in spans]))

    def forces(self, forces: Array) -> Array:
        """Forces of the ropes on the coordinates of bodies, shape (n,); ``forces``, shape (spans, 2, 2)."""
        pull = np.einsum("sei,si,e->se", forces, self.along, np.array((1.0, -1.0)))
        n = self.ends.shape[-1]
        return np.asarray(
            forces.reshape(-1) @ self.ends.reshape(-1, n) + pull.reshape(-1) @ self.shafts.reshape(-1, n)
        )

    def bound(self, forces: Array) -> Array:
        """Force on each coordinate if every rope pulled along its motion, shape (n,); ``forces`` as above."""
        size = np.linalg.norm(forces, axis=2)[:, :, None]
        return np.asarray((size * (np.linalg.norm(self.ends, axis=2) + np.abs(self.shafts))).sum(axis=(0, 1)))


def _balanced(
    drive: RoutedDrive,
    motion: Motion,
    pulls: Pulls,
    sections: NDArray[np.intp],
    count: int,
    offsets: Offsets,
) -> Array:
    """Tensions at the start of the sections that balance every body, the elastic ones, shape (sections,)."""
    rows = [
        number
        for number, name in enumerate(motion.names)
        for body in drive.body
        if name.rpartition(".")[0] == body.name and body.stiffness == 0.0
    ]
    matrix = np.zeros((len(motion.names), count))
    for section in range(count):
        forces = offsets.unit * (sections == section)[:, None, None]
        share = pulls.forces(forces)
        # Ropes at right angles to a motion do not hold it: round-off times 1e19 N would.
        matrix[:, section] = np.where(np.abs(share) > _ROUND_OFF * pulls.bound(forces), share, 0.0)
    rest = -applied_forces(drive, motion) - pulls.forces(offsets.constant)
    matrix, rest = matrix[rows], rest[rows]
    matrix, rest = _with_common_pulleys(drive, sections, offsets, matrix, rest)
    spans, of_section = drive.free_spans, np.arange(count)[:, None] == sections
    ropes = [drive.ropes[span.route] for span in spans]
    given = np.array([np.nan if rope.pretension is None else rope.pretension for rope in ropes])
    lines = np.array([drive.route[span.route].ropes for span in spans])
    soft = lines * [span.length / rope.axial_rigidity for span, rope in zip(spans, ropes, strict=True)]
    number, run = offsets.samples[:2].astype(np.intp)
    length, beyond, shear = offsets.samples[2:]
    reference = np.bincount(number, length * beyond) / [span.length for span in spans]
    unheld = ~np.isnan(given)
    for last, there in _standing(drive, offsets):
        own = sections == sections[last]
        reference[own], unheld[own] = there, False
    hangs = unheld[number] & (np.bincount(run, shear**2)[run] > 0.0)
    number, run, length, shear = number[hangs], run[hangs], length[hangs], shear[hangs]
    at, beyond, size = sections[number], beyond[hangs] - offsets.flow[number], lines[number] * length
    scale = np.abs(matrix).max(axis=1, initial=0.0)
    scale[scale == 0.0] = 1.0
    # Newton's steps along the balance; what the file leaves open is in it, or refused
    tension = np.zeros(count)
    tension[sections] = np.where(np.isnan(given), 0.0, given - reference)
    np.maximum.at(tension, at, 1e-3 * np.abs(shear) - beyond)  # from below, steps lead up
    for _ in range(_STEPS):
        pull = tension[at] + beyond
        # ends of what hangs between two places lie on the chord
        tilt = np.bincount(run, length * shear / pull) / np.maximum(np.bincount(run, length / pull), 1e-300)
        square = size * (shear - tilt[run]) ** 2
        strained = of_section @ (soft * np.nan_to_num(tension[sections] + reference - given))
        slope = strained - np.bincount(at, 0.5 * square / pull**2, count)
        curvature = of_section @ soft + np.bincount(at, square / pull**3, count)
        even = np.sqrt(curvature.max(initial=0.0) / curvature)
        balance = matrix / scale[:, None] * even
        inverse = np.linalg.pinv(balance, rcond=_SINGULAR)
        wanted = tension - slope / curvature
        full = wanted + even * (inverse @ ((rest - matrix @ wanted) / scale))
        step = full - tension
        while np.any(pull + step[at] < 0.1 * pull):
            step *= 0.5
        tension = tension + step
        if not (at.size and np.any(np.abs(step) > _SETTLED * np.abs(tension).max())):
            break
    else:  # the balance asks a rope that hangs to push, which is refused by its tension
        if np.all(full[at] + beyond > 0.0):
            raise NotComputed(f"no tensions at rest within {_STEPS} steps: raise pretension")
        tension = full
    # where the balance leaves a tension open the file must give a pretension
    open_directions = np.eye(count) - inverse @ balance
    unknown = np.isin(np.arange(count), sections[np.isnan(given)])
    for number in np.flatnonzero(unknown).tolist():
        if np.abs(open_directions[number]).max() > 1e-6:
            span = drive.free_spans[int(np.flatnonzero(sections == number)[0])]
            raise InputRefused(
                f'route "{drive.route[span.route].name}": the balance of bodies and weights leaves the '
                f"tension of {span.name} open: give pretension [N], in [cable] or in the route"
            )
    missing = rest - matrix @ tension
    size = np.abs(rest) + np.abs(matrix) @ np.abs(tension)
    for place, row in enumerate(rows):
        if abs(missing[place]) > _BALANCED * max(size[place], 1e-9):
            _refuse_unbalanced(
                motion.names[row], float(missing[place]), matrix[place] * tension, float(rest[place])
            )
    return tension


def _standing(drive: RoutedDrive, offsets: Offsets) -> Iterator[tuple[int, float]]:
    """Spans at whose drum a standing torque holds the pretension, and their tension there without it [N]."""
    for number, data in enumerate(drive.route):
        own = [i for i, span in enumerate(drive.free_spans) if span.route == number]
        for i, place, beyond in (
            (own[0], drive.free_spans[own[0]].start, offsets.start),
            (own[-1], drive.free_spans[own[-1]].end, offsets.end),
        ):
            drum = place.pulley if not data.closed else None
            if drum is not None and drum not in drive.turned and not drive.pulley[drum].fixed:
                yield i, float(beyond[i])


def _with_common_pulleys(
    drive: RoutedDrive, sections: NDArray[np.intp], offsets: Offsets, matrix: Array, rest: Array
) -> tuple[Array, Array]:
    """One more equation for each free pulley that several ropes turn: their moments balance."""
    visits = [(place.pulley, route) for route, places in enumerate(drive.places) for place in places]
    for number, pulley in enumerate(drive.pulley):
        seen = sum(own == number for own, _ in visits)
        if pulley.fixed or number in drive.driven or seen < 2:
            continue
        row, known = np.zeros(matrix.shape[1]), 0.0
        for index, span in enumerate(drive.free_spans):
            ropes = drive.route[span.route].ropes
            for place, sign, offset in ((span.start, 1, offsets.start), (span.end, -1, offsets.end)):
                if place.pulley == number:
                    arm = sign * place.sense * place.radius * ropes
                    row[sections[index]] += arm
                    known += arm * offset[index]
        matrix, rest = np.vstack((matrix, row)), np.append(rest, -known)
    return matrix, rest


def _refuse_unbalanced(name: str, missing: float, pulls: Array, rest: float) -> None:
    body, _, move = name.rpartition(".")
    unit = "N m" if move == "turn" else "N"
    way = "about its pivot" if move == "turn" else f"along {move}"
    both = [*pulls, -rest]
    ahead, back = sum(p for p in both if p > 0.0), -sum(p for p in both if p < 0.0)
    raise InputRefused(
        f"body {body}: no static solution, {abs(missing):.4g} {unit} {way} are missing; ropes, weights and "
        f"loads pull {ahead:.4g} {unit} one way and {back:.4g} {unit} the other: change loads, masses or the "
        "routes, or give it stiffness"
    )


def geometric_stiffness(motion: Motion, statics: Statics) -> Array:
    r"""Stiffness of turning bodies under constant forces, Eq. (N.4).

    .. math:: K_{ij} = -\sum F \cdot \frac{\partial^2 c}{\partial q_i\,\partial q_j}, \qquad
              \frac{\partial^2 c}{\partial q_a\,\partial q_b} = e_z \times \frac{\partial c}{\partial q_b}

    where a turns and carries b, or is b itself; zero else.
    """
    drive = motion.drive
    total = np.zeros((len(motion.names), len(motion.names)))
    if not any("turn" in body.moves for body in drive.body):
        return total
    g = gravity(drive)
    loads: list[tuple[Array, Point, int | None]] = [
        (body.mass * g + np.array(body.load), body.at, i) for i, body in enumerate(drive.body)
    ]
    loads += [
        (pulley.mass * g, pulley.at, drive.body_number(pulley.on, pulley.name)) for pulley in drive.pulley
    ]
    for number, span in enumerate(drive.free_spans):
        for end, place in enumerate((span.start, span.end)):
            loads.append((statics.forces[number, end], place.centre, motion.body_of(place)))
    for force, at, body in loads:
        rows = motion.point(at, body)
        turned = force[1] * rows[0] - force[0] * rows[1]  # F . (e_z x dc/dq)
        chain = drive.carried_by(body)
        for position, outer in enumerate(chain):
            if "turn" not in drive.body[outer].moves:
                continue
            a = motion.unit(f"{drive.body[outer].name}.turn")
            for inner in chain[: position + 1]:
                for move in drive.body[inner].moves:
                    b = motion.unit(f"{drive.body[inner].name}.{move}")
                    value = -float(turned @ b)
                    total += value * np.outer(a, b)
                    total += value * np.outer(b, a) if inner != outer else 0.0
    return total


def unheld_words(motion: Motion, statics: Statics) -> list[str]:
    """A warning for each pulley that nothing in the file holds at rest, such as the far drum of a line."""
    drive = motion.drive
    torques = np.zeros(len(drive.pulley))
    for span, forces in zip(drive.free_spans, statics.forces, strict=True):
        for place, contact, force in zip((span.start, span.end), span.contacts, forces, strict=True):
            if place.pulley is not None:
                arm = np.subtract(contact, place.centre)
                torques[place.pulley] += arm[0] * force[1] - arm[1] * force[0]
    largest = float(np.abs(statics.forces).max(initial=0.0))
    return [
        f"the ropes at rest turn pulley {pulley.name} by {abs(torque):.4g} N m and nothing in the file holds "
        "it: what is computed holds where a load does; else give it a motor, or fixed = true where a brake "
        "does"
        for number, (pulley, torque) in enumerate(zip(drive.pulley, torques, strict=True))
        if motion.turns(number)
        and number not in drive.turned
        and abs(torque) > pulley.coulomb_friction + _BALANCED * largest * pulley.radius
    ]
