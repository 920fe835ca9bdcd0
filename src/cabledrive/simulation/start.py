"""How a run starts, and the options that travel with it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import Model
from cabledrive.mechanics.mesh import Divided, Mesh, gradients
from cabledrive.parameters import Machine
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.fields import described, meaning, nearest
from cabledrive.parameters.route.two_pulleys import NAMES

if TYPE_CHECKING:
    from cabledrive.simulation.network.mesh import Rest

PLANES = ("u", "v", "w")
Profile = ArrayLike | Callable[[Array], ArrayLike]


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """What is kept of a run."""

    rate: float = meaning("least number of records per second [Hz]", 10_000.0)
    probes: tuple[tuple[str, float], ...] = meaning(
        "points to record beside the midpoints: span, and distance from its start along the "
        "pretensioned cable [m]",
        (),
    )
    fields: int = meaning("keep the displacements of all nodes at every so many records; 0: not at all", 0)

    def __post_init__(self) -> None:
        if isinstance(self.fields, bool) or not isinstance(self.fields, int) or self.fields < 0:
            raise InputRefused(f"fields = {self.fields!r} must be a whole number of records, or 0: give one")


@described
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pluck:
    """A displacement of one span at the start, zero at both pulleys and at guided carriages."""

    height: float = meaning(
        "largest displacement of a named shape, factor of a profile [m; with a profile in m: 1]", 1.0
    )
    span: str = meaning('one of "upper", "lower"', "upper")
    plane: str = meaning('one of "u", "v", "w"', "w")
    shape: str | Profile = meaning(
        '"triangle" with its corner at `place`, Section 5.2.1; "half-sine"; "sine-2", "sine-3", ... '
        "for the higher modes of a string; an array of displacements at equal distances from pulley "
        "to pulley, both included; or a function of the distance [m]. A named shape reaches from "
        "pulley to pulley, or to the guided carriages on both sides of `place`",
        "triangle",
    )
    place: float = meaning("where the corner of a triangle is, as a share of the span", 0.5)

    def __post_init__(self) -> None:
        if self.plane not in PLANES:
            raise InputRefused(f'pluck: plane = "{self.plane}" is not one of its values: write u, v or w')
        if not isfinite(self.height):
            raise InputRefused(f"pluck: height = {self.height} m must be finite: give a number")
        if not 0.0 < self.place < 1.0:
            raise InputRefused(f"pluck: place = {self.place} must lie between 0 and 1, inside the span")


@described
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Start:
    """Where everything is at t = 0."""

    plucks: tuple[Pluck, ...] = meaning("displacements, added to each other and to the state of rest", ())
    kicks: tuple[Pluck, ...] = meaning(
        "velocities of the same shapes, their heights in m/s: with a pluck in the other plane, a whirl", ()
    )
    drive_angle: float = meaning("angle of the drive pulley [rad]; the cable follows linearly", 0.0)
    load_angle: float = meaning("angle of the load pulley [rad]", 0.0)
    drive_speed: float = meaning("angular speed of drive pulley and motor [rad/s]; the cable follows", 0.0)
    load_speed: float = meaning("angular speed of the load pulley [rad/s]", 0.0)
    places: Mapping[str, float] = meaning(
        'of a machine with routes: coordinates such as "head.x", from rest [m], [rad]; ropes follow linearly',
        factory=dict,
    )
    speeds: Mapping[str, float] = meaning("the same of their speeds [m/s], [rad/s]", factory=dict)
    from_equilibrium: bool = meaning(
        "start from where the cable hangs instead of the straight cable; a machine with routes always does",
        False,
    )
    hold: str = meaning(
        'of a loop or a line from equilibrium: "drive" where a motor has held the drive pulley, its '
        'flexible joint twisted by that torque; "none" where friction holds it',
        "none",
    )

    def __post_init__(self) -> None:
        for name in OF_LOOPS:
            value, unit = getattr(self, name), "rad" if name.endswith("angle") else "rad/s"
            if not isfinite(value):
                raise InputRefused(f"start: {name} = {value} {unit} must be finite: give a number")
        if self.hold not in ("none", "drive"):
            raise InputRefused(
                f'start: hold = "{self.hold}" is not one of its values: write "none" or "drive"'
            )


OF_LOOPS = ("drive_angle", "load_angle", "drive_speed", "load_speed")
"""What a start says of loops and lines alone."""


def plucked(spans: Divided, plucks: Sequence[Pluck], *, lengths: bool = False) -> Array:
    """Displacements, or velocities, of all nodes by plucks or kicks of spans, (3, nodes) [m], [m/s]."""
    names, positions, nodes, held_nodes = spans
    total = np.zeros((3, held_nodes.size))
    for pluck in plucks:
        if pluck.span not in names:
            raise InputRefused(f'pluck: "{pluck.span[:60]}" is no span: take one of {"; ".join(names)}')
        k = names.index(pluck.span)
        own, x = slice(nodes[k][0], nodes[k][1] + 1), positions[k]
        held = held_nodes[own] if pluck.plane != "u" else np.isin(x, x[[0, -1]])  # carriages move along
        shape = pluck.height * profile_of(pluck, x, x[held])
        size = float(np.max(np.abs(shape)))
        if shape.shape != x.shape or not size < (x[-1] if lengths else np.inf):
            said = f"pluck: {size:.6g} m on {pluck.span} is longer than the span of {x[-1]:.6g} m"
            raise InputRefused(f"{said}: lower it")
        moved = np.flatnonzero(held & (np.abs(shape) > 1e-9 * size))
        if moved.size:
            raise InputRefused(
                f"pluck: {shape[moved[0]]:.6g} at x = {x[moved[0]]:.6g} m of {pluck.span}, where a "
                "pulley or a carriage holds it: make the profile zero there"
            )
        total[PLANES.index(pluck.plane), own] += np.where(held, 0.0, shape)
    return total


def probed(spans: Divided, probes: Sequence[tuple[str, float]]) -> Array:
    """Segment of each probe and place between its ends from 0 to 1, shape (probes, 2)."""
    names, positions, nodes, _ = spans
    table = np.zeros((len(probes), 2))
    for number, (span, place) in enumerate(probes):
        if span not in names:
            raise InputRefused(f'probe: "{span[:60]}" is no span: take one of {"; ".join(names)}')
        k = names.index(span)
        x = positions[k]
        if not 0.0 <= place <= x[-1]:
            raise InputRefused(f"probe at {place} m of {span}, which is {x[-1]:.6g} m long: move it")
        i = min(int(np.searchsorted(x, place, side="right")), len(x) - 1) - 1
        table[number] = nodes[k][0] + i, (place - x[i]) / (x[i + 1] - x[i])
    return table


def by_name(names: tuple[str, ...], given: Mapping[str, float], what: str) -> Array:
    """Coordinates of a start that are given by their names, 0 of others, (n,)."""
    for name, value in given.items():
        if name not in names or not np.isfinite(value):
            raise InputRefused(
                f'start: {what} of "{str(name)[:60]}" = {value}: take one of {", ".join(names)}, finite'
            )
    return np.array([given.get(name, 0.0) for name in names])


def following(mesh: Mesh, ends: Array) -> Array:
    """Displacements of all nodes where ropes follow their ends, (pieces, 2, 3), linearly, (3, nodes)."""
    x = np.zeros((3, mesh.size))
    for k, (own, (first, last)) in enumerate(zip(ends, mesh.nodes, strict=True)):
        here, rails = slice(first, last + 1), np.flatnonzero(~mesh.sways[first : last + 1])
        x[0, here] = np.interp(mesh.positions[k], mesh.positions[k][[0, -1]], own[:, 0])
        for axis in (1, 2):  # what is guided stays on its rail
            heights = np.zeros(rails.size)
            heights[[0, -1]] = own[:, axis]
            x[axis, here] = np.interp(mesh.positions[k], mesh.positions[k][rails], heights)
    return x


def straight(mesh: Mesh, rest: Array) -> tuple[Array, Array]:
    """Displacements of straight spans of the pretension of the file, and the coordinates there.

    ``rest``: displacements at rest from the straight line of each span, (3, nodes). The load pulley turns
    until all spans have that tension; drive pulley and rotor stay.
    """
    q, over = np.zeros(len(mesh.names)), rest[0, mesh.nodes[:, 1]]
    if NAMES[1] in mesh.names:
        load = mesh.names.index(NAMES[1])
        turn = mesh.ends[:, 1, 0, load] - mesh.ends[:, 0, 0, load]
        q[load] = -(turn @ over) / (turn @ turn)
    x = np.zeros_like(rest)
    for reach, own, (first, last) in zip(over, mesh.positions, mesh.nodes, strict=True):
        here = slice(first, last + 1)
        rails = np.flatnonzero(~mesh.sways[here])
        x[0, here], x[2, here] = reach * own / own[-1], np.interp(own, own[rails], rest[2, here][rails])
    return x + following(mesh, mesh.ends @ q), q


def at_start(
    mesh: Mesh, laws: Sequence[CableLaw], rest: "Rest", start: Start, holding: float = 0.0
) -> tuple[Array, Array, Array, Array]:
    """Displacements and velocities at t = 0 of the nodes, (3, nodes), and of the coordinates, (n,).

    ``holding``: torque that has held the drive pulley of a loop or a line at rest [N m].
    Raises `InputRefused` if the start does not fit the machine, gravity would turn a free pulley, or spans of
    a loop or a line would start slack though they may not go slack; `NotComputed` if they may, but would have
    to push at rest.
    """
    places, speeds, law, drive = start.places, start.speeds, laws[0], mesh.network.drive
    shafts = [name for _, name in drive.angles]
    if mesh.whole:  # the rotor turns with the drive pulley
        places, speeds = (
            {name: drive.sense * own for name, own in zip(shafts, (turn, load, turn), strict=True) if own}
            for turn, load in ((start.drive_angle, start.load_angle), (start.drive_speed, start.load_speed))
        )
    q, q_t = by_name(mesh.names, places, "places"), by_name(mesh.names, speeds, "speeds")
    begun, turned = (rest.x, 0.0 * q) if start.from_equilibrium else (rest.counted, rest.turned)
    x = begun + following(mesh, mesh.ends @ q) + plucked(mesh.spans, start.plucks, lengths=True)
    x_t, q = following(mesh, mesh.ends @ q_t) + plucked(mesh.spans, start.kicks), q + turned
    if not mesh.whole:
        return x, x_t, q, q_t
    if start.from_equilibrium:
        ours = [mesh.names.index(name) for name in dict.fromkeys(shafts[::2]) if name in mesh.names]
        rubs = mesh.network.rubs
        friction = float(np.sum(rubs.values @ np.abs(rubs.dense[:, ours])))
        rests = abs(holding) <= friction + 1e-6 * law.pretension * drive.pulley[0].radius
        if start.hold == "none" and not rests:
            said = f"gravity turns the free pulleys: {holding:.4g} N m would hold them"
            raise InputRefused(f"{said}; hold the drive pulley")
        if law.tension_only and mesh.network.lowest_tension.min() <= 0.0:
            raise NotComputed("no equilibrium: a piece of the cable hangs slack; raise cable.pretension")
        if shafts[2] != shafts[0] and (stiffness := drive.motor[0].joint_stiffness):
            q[mesh.names.index(shafts[2])] += drive.sense * holding / stiffness
    tension = np.asarray(law.tension(*gradients(mesh, x)))
    least = int(np.argmin(tension))
    if tension[least] < 0.0 and not law.tension_only:
        k = int(np.searchsorted(mesh.nodes[:, 0], least, side="right")) - 1
        raise InputRefused(
            f"start: the {mesh.pieces[k]} span is slack at x = "
            f"{mesh.positions[k][least - mesh.nodes[k, 0]]:.6g} m "
            f"({tension[least]:.4g} N): lower the pluck, raise cable.pretension or allow slack"
        )
    return x, x_t, q, q_t


def profile_of(pluck: Pluck, x: Array, held: Array) -> Array:
    """Profile of a pluck; a named shape reaches between the held points on both sides of its place."""
    if isinstance(pluck.shape, str):
        place = pluck.place * x[-1]
        beyond = int(np.searchsorted(held, place))
        first, last = held[beyond - 1], held[beyond]
        if (np.abs(held[1:-1] - place) < 1e-3 * x[-1]).any():
            raise InputRefused(
                f"pluck: its place, x = {place:.6g} m, is held by a guided carriage: pluck beside it"
            )
        if pluck.shape == "triangle":
            shape = np.minimum((x - first) / (place - first), (last - x) / (last - place))
        else:
            waves = {"half-sine": "1"}.get(pluck.shape, pluck.shape.removeprefix("sine-"))
            if not waves.isdecimal() or int(waves) == 0:
                said = f'pluck: shape = "{pluck.shape}" is not one of its values'
                raise InputRefused(f'{said}: write "triangle", "half-sine", "sine-2", ...')
            shape = np.sin(int(waves) * np.pi * (x - first) / (last - first))
        return np.where((x > first) & (x < last), shape, 0.0)
    values = pluck.shape(x) if callable(pluck.shape) else pluck.shape
    profile = np.asarray(values, dtype=np.float64)
    if profile.ndim != 1 or profile.size < 3 or not np.isfinite(profile).all():
        raise InputRefused(
            f"pluck: the profile needs 3 or more finite numbers in a row; its shape is {profile.shape}"
        )
    if callable(pluck.shape):
        return profile
    return np.interp(x / x[-1], np.linspace(0.0, 1.0, profile.size), profile)


SLACK = ("stop", "record", "tension-only")
FRICTION = ("stick-slip", "smoothed")


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Scheme:
    """How the cable is computed."""

    model: Model = meaning(
        'cable law: "exact", "weak", "weak-consistent", "linear", or one\'s own: a subclass of'
        " `cabledrive.CableLaw`, a function that makes one from the keywords `pretension` and "
        "`axial_rigidity`, or a law made for this cable. What cannot be compiled runs interpreted, "
        "and the result says so",
        "exact",
    )
    method: str = meaning("name of the method, see `cabledrive.simulation.methods`", "verlet")
    segments: int = meaning("segments per span; more where carriages stand closer together", 200)
    step: float | None = meaning(
        "time step [s]; None: from `cfl`. The step taken is the largest up to it that divides a "
        "recording interval",
        None,
    )
    cfl: float = meaning("largest share of the stable step to take, where `step` is None", 0.9)
    slack: str = meaning(
        "what happens where the tension falls below zero: the run stops; it is noted, and the law "
        "goes on to push; it is noted, and the cable carries nothing there",
        "stop",
    )
    friction: str = meaning(
        "coulomb friction of the shafts: set-valued, or smoothed to c tanh(speed / `smoothing_speed`)",
        "stick-slip",
    )
    smoothing_speed: float = meaning("angular speed over which friction is smoothed [rad/s]", 0.1)

    def __post_init__(self) -> None:
        for name, words in (("slack", SLACK), ("friction", FRICTION)):
            value = getattr(self, name)
            if value not in words:
                raise InputRefused(f'{name} = "{value}" is not one of its values{nearest(str(value), words)}')
        if not 0.0 < self.cfl <= 1.0:
            raise InputRefused(f"cfl = {self.cfl}: the method is stable above 0 and up to 1: choose 0.9")
        if self.step is not None and not (isfinite(self.step) and self.step > 0.0):
            raise InputRefused(
                f"step = {self.step} s must be above 0 and finite: leave it out to have one chosen"
            )
        if not (isfinite(self.smoothing_speed) and self.smoothing_speed > 0.0):
            raise InputRefused(
                f"smoothing_speed = {self.smoothing_speed} rad/s must be above 0 and finite: give one"
            )


def never_simulated(drive: Machine) -> list[tuple[Any, str]]:
    """What no run of a machine with routes has: whether it is there, and what to do."""
    running = next((data.name for data in drive.route if data.speed), "")
    return [
        (running, f'route "{running}" runs (speed), and only ropes at rest are simulated: set it to 0'),
        (any(own.backlash for own in drive.motor), "motor.backlash is not simulated on routes: set it to 0"),
    ]


def check_routes(drive: Machine, scheme: Scheme, recording: Recording, start: Start) -> None:
    """Refuse what no run of a machine with routes has."""
    for refused, why in (
        (
            scheme.friction == "smoothed"
            and any(own.coulomb_friction and own.pivot is None for own in drive.body),
            "friction of bodies that slide is set-valued: leave smoothed friction out",
        ),
        (
            any(getattr(start, name) for name in OF_LOOPS),
            'angles at the start are for loops and lines: give "places" and "speeds"',
        ),
        *never_simulated(drive),
    ):
        if refused:
            raise InputRefused(f'kind = "route": {why}')
