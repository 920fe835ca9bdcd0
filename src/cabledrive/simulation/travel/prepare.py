"""A run in which bodies travel, from the file: what it cannot have is refused, the rest becomes numbers."""

from collections.abc import Mapping
from hashlib import sha256

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.holding import HOLDING, motor_condition
from cabledrive.mechanics.mesh import check_segments
from cabledrive.mechanics.network import Network, network_of
from cabledrive.mechanics.network.assembly import turns_by_torque
from cabledrive.mechanics.network.motion import gravity
from cabledrive.parameters import Machine
from cabledrive.parameters.arrays import Integers
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.channels import channels_of
from cabledrive.simulation.methods import time_grid
from cabledrive.simulation.network.mesh import rubbing_of
from cabledrive.simulation.signals import Function, Signal, motor_torques, offsets_of
from cabledrive.simulation.start import OF_LOOPS, Recording, Scheme, Start, by_name, never_simulated
from cabledrive.simulation.travel import plan as at
from cabledrive.simulation.travel.case import PlannedMove, TravelCase, Way, way_of
from cabledrive.simulation.travel.plan import TravelPlan, largest_travel_step

SEGMENTS = 16
SHORTEST = 0.5
"""Free length, relative to that at rest, down to which a run with given torques is stable."""
ROOM = 0.95
"""The same relative to the way of a planned move, as ropes stretch."""
_BALANCED = 1e-6
NO_TURN = 1e-9


def travel_case(
    drive: Machine,
    duration: float,
    *,
    move: PlannedMove | None,
    torque: Mapping[str, Signal | float | Function] | Signal | float | Function,
    start: Start | None,
    scheme: Scheme | None,
    recording: Recording | None,
) -> TravelCase:
    """Check and prepare a run; arguments as of `simulate`."""
    start, recording = start or Start(), recording or Recording()
    scheme = scheme or Scheme(segments=SEGMENTS)
    _check(drive, scheme, recording, start, move)
    network = network_of(drive, motor="free")
    way = None if move is None else way_of(drive, move.moves)
    rotors = turns_by_torque(network).argmax(axis=1)
    if way is not None and not np.any(np.abs(way.turned[:, drive.turned]) > NO_TURN):
        raise InputRefused("move: it turns no motor: name a body that the motors move")
    mass = network.masses.values @ network.masses.dense**2
    for name, own in zip(network.motion.names, mass, strict=True):
        if own <= 0.0:
            raise InputRefused(f'kind = "route", travel: {name} has no mass: give it mass or inertia')
    shortest = SHORTEST * _lengths(network) if way is None else ROOM * way.shortest
    counts = _counts(network, way, scheme.segments)
    poses = [network] if way is None else way.networks
    largest = min(largest_travel_step(pose, counts, shortest) for pose in poses)
    grid = time_grid(duration, largest, scheme, recording.rate, int(counts.sum()))
    names = tuple(drive.pulley[number].name for number in drive.turned)
    torques = motor_torques(names, torque, duration, grid.step)
    plan, x, length, holding = _plan(
        network, counts, shortest, rotors, step=grid.step, prescribed=way is not None
    )
    spans = tuple(span.name for span in network.drive.free_spans)
    q_t = by_name(network.motion.names, start.speeds, "speeds")
    return TravelCase(
        machine=network.drive,
        scheme=scheme,
        recording=recording,
        grid=grid,
        channels=channels_of(network.motion.names, names, spans, travels=True),
        network=network,
        plan=plan,
        names=network.motion.names,
        motors=names,
        spans=spans,
        move=move,
        way=way,
        torques=torques,
        holding=holding + offsets_of(drive),
        x=x,
        length=length,
        q_t=q_t,
        settings={
            "move": None if move is None else [dict(move.moves), move.rise],
            "torque": [signal.fingerprint for signal in torques],
            "start": sha256(q_t.tobytes()).hexdigest(),
        },
    )


def _check(
    drive: Machine, scheme: Scheme, recording: Recording, start: Start, move: PlannedMove | None
) -> None:
    foreign = scheme.model != "exact" or scheme.method != "verlet" or scheme.friction != "stick-slip"
    turning = next((body.name for body in drive.body if "turn" in body.moves), "")
    guide = next((pulley.name for pulley in drive.pulley if pulley.fixed), "")
    held = move is None and motor_condition(drive) == HOLDING
    for refused, why in (
        (foreign, "only the exact law with verlet and stick-slip: leave the others out"),
        (scheme.slack != "stop", "a rope that goes slack ends the run: leave --tension-only out"),
        (recording.fields or recording.probes, "whole fields and probes are not kept: leave them out"),
        (
            start.plucks or start.kicks or start.places or any(getattr(start, name) for name in OF_LOOPS),
            "it begins in the pose of the file with straight ropes: leave plucks out",
        ),
        (drive.carriage, "a [[carriage]] clamped to a rope would run over its pulleys: leave it out"),
        (turning, f"body {turning} turns; only bodies that slide travel: leave out its moves"),
        (guide, f"rope does not run over the guide {guide}: let it turn"),
        *never_simulated(drive),
        (held, "holding_stiffness keeps the motor in its place: give --move, or take it out"),
    ):
        if refused:
            raise InputRefused(f"travel: {why}")
    if move is not None and not (np.isfinite(move.rise) and move.rise > 0.0):
        raise InputRefused(f"rise = {move.rise} s must be above 0 and finite: give the time of the move")


def _lengths(network: Network) -> Array:
    return np.array([span.length for span in network.drive.free_spans])


def _counts(network: Network, way: Way | None, segments: int) -> Integers:
    """Cells of each span, most in the one that becomes longest."""
    check_segments(segments, fewest=1)
    longest = _lengths(network)
    for pose in way.networks if way is not None else []:
        longest = np.maximum(longest, _lengths(pose))
    return np.maximum(1, np.rint(segments * longest / longest.max())).astype(np.int64)


def _plan(
    network: Network, counts: Integers, shortest: Array, rotors: Integers, *, step: float, prescribed: bool
) -> tuple[TravelPlan, Array, Array, Array]:
    """Plan, places of the cells, unstretched lengths, and torques that hold the machine."""
    drive, motion, n = network.drive, network.motion, len(network.motion.names)
    spans = drive.free_spans
    ends = [(span.start, span.end) for span in spans]
    ropes = [drive.ropes[span.route] for span in spans]
    lines = np.array([drive.route[span.route].ropes for span in spans], dtype=np.float64)
    rim = np.array([[place.sense * place.radius for place in pair] for pair in ends])
    turn = np.zeros((len(spans), 2, n))
    for s, pair in enumerate(ends):
        for side, place in enumerate(pair):
            if place.pulley is not None:
                turn[s, side] = rim[s, side] * motion.dense(motion.angle(place.pulley))[0]
    beyond = _beyond(drive)
    for s, side in np.argwhere(beyond == at.DRUM):
        if motion.body_of(ends[s][side]) is not None:
            said = f'kind = "route", travel: the drum {ends[s][side].name} rides on a body'
            raise InputRefused(f"{said}, whose mass would change: put it on the ground")
    rub, bound, wrap, _ = rubbing_of(network)
    frictions = bound.size
    plan = TravelPlan(
        step=step,
        winds=bool(np.any(beyond == at.DRUM)),
        prescribed=prescribed,
        moves=np.where(np.isin(np.arange(n), rotors), 1.0 - prescribed, 1.0),
        cells=np.concatenate(([0], np.cumsum(counts))).astype(np.int64),
        piece=np.array(
            [
                (0.0, rope.axial_rigidity, rope.density, rope.axial_damping, own, span.wrap or 0.0)
                for rope, own, span in zip(ropes, lines, spans, strict=True)
            ]
        ),
        shortest=shortest,
        centre=np.array([[place.centre for place in pair] for pair in ends]),
        frame=np.array(
            [[motion.dense(*motion.point(p.centre, motion.body_of(p))) for p in pair] for pair in ends]
        ),
        turn=turn,
        rim=rim,
        beyond=beyond,
        bearing=np.array([span.along for span in spans]),
        gravity=gravity(drive),
        mass=network.masses.matrix,
        stiffness=network.springs.matrix,
        damping=network.dampers.matrix,
        rest=np.zeros(n),
        rotor=rotors,
        rub=rub,
        smooth=np.zeros(frictions),
        bound=bound,
        wrap=wrap,
        inverse=np.zeros((n, n)),
        rub_mobility=np.zeros((n, frictions)),
        rub_own=np.zeros(frictions),
    )
    x, length, force = _at_rest(network, plan, counts)
    rest, holding = _held(network, plan, force)
    return plan._replace(rest=rest), x, length, holding


def _beyond(drive: Machine) -> Integers:
    """Span behind the pulley at each end of each span, `ANCHOR` or `DRUM`."""
    spans = drive.free_spans
    found = np.full((len(spans), 2), at.ANCHOR, dtype=np.int64)
    for route, data in enumerate(drive.route):
        own = [number for number, span in enumerate(spans) if span.route == route]
        for place, number in enumerate(own):
            neighbours = (own[place - 1] if place else own[-1], own[(place + 1) % len(own)])
            for side, end in enumerate((spans[number].start, spans[number].end)):
                last = place == (0, len(own) - 1)[side] and not data.closed
                if end.pulley is not None:
                    found[number, side] = at.DRUM if last else neighbours[side]
    return found


def _at_rest(network: Network, plan: TravelPlan, counts: Integers) -> tuple[Array, Array, Array]:
    """Places of the cells, unstretched lengths [m], and what the ropes do to the coordinates [N]."""
    tension, free = network.statics.mean, _lengths(network)
    rigidity, density, lines = (plan.piece[:, column] for column in (at.RIGIDITY, at.DENSITY, at.ROPES))
    length = free / (1.0 + tension / rigidity)
    along = plan.bearing
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    rows = np.einsum("sc,sicn->sin", along, plan.frame) + plan.turn
    sideways = np.einsum("sc,sicn->sin", across, plan.frame)
    weight = density * length * (along @ plan.gravity)
    hanging = 0.5 * lines * density * length * (across @ plan.gravity)
    force = np.einsum("s,sin->n", hanging, sideways)
    force += (lines * (tension + 0.5 * weight)) @ rows[:, 0] - (lines * (tension - 0.5 * weight)) @ rows[:, 1]
    places = []
    for s, count in enumerate(counts):
        pulls = tension[s] + (0.5 - np.arange(count + 1) / count) * weight[s]
        parts = np.full(count + 1, length[s] / count)
        parts[[0, -1]] *= 0.5
        places.append(np.cumsum(parts * (1.0 + pulls / rigidity[s]))[:-1])
    return np.concatenate(places), length, force


def _held(network: Network, plan: TravelPlan, force: Array) -> tuple[Array, Array]:
    """Weights, loads and preloads of the coordinates, and torques of the motors that hold the machine."""
    motion, rest, holding = network.motion, -force, np.zeros(plan.rotor.size)
    driven = network.drive.turned
    for m, (number, rotor) in enumerate(zip(driven, plan.rotor, strict=True)):
        shaft = next(iter(motion.angle(number)))
        holding[m] = -force[shaft]
        rest[rotor] = 0.0 if shaft == rotor else force[shaft]  # else the joint's preload stays on both
    size = float(np.max(plan.piece[:, at.ROPES] * network.statics.mean))
    for name, left in zip(motion.names, rest, strict=True):
        pulleys = {pulley.name: pulley.radius for pulley in network.drive.pulley}
        own = name in pulleys and not any(network.drive.pulley[k].name == name for k in driven)
        if own and abs(left) > _BALANCED * size * pulleys[name]:
            said = f'kind = "route", travel: pulley {name} would turn by {abs(left):.4g} N m of its ropes'
            raise InputRefused(f"{said}: give it a motor, or tensions in balance")
        if own:
            rest[motion.names.index(name)] = 0.0
    return rest, holding
