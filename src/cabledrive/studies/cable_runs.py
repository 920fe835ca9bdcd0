"""Runs of the nonlinear loop for the report: plucked, forced, whirling, slack, and one by all integrators."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.mesh import mesh_of
from cabledrive.mechanics.sag import catenary_sag, parabola_sag
from cabledrive.mechanics.statics import equilibrium
from cabledrive.modal import natural_frequencies
from cabledrive.parameters import Drive
from cabledrive.simulation import (
    Pluck,
    Recording,
    Sampled,
    Scheme,
    SimulationResult,
    Sine,
    Start,
    simulate,
)
from cabledrive.simulation.stopped import whole

PLUCKS = (2e-3, 1e-3)  # m, upper and lower span
WHIRL = 8e-3  # m
TORQUE = 0.02  # N m
SEGMENTS = 80
WAYS = (
    ("exact", "verlet"),
    ("weak", "verlet"),
    ("linear", "verlet"),
    ("exact", "node-centred"),
    ("exact", "energy-conserving"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class SagTable:
    """Sag of the midpoint of a level span by four ways [m].

    Attributes
    ----------
    chain : float
        The upper span of the divided loop, by Newton's method.
    parabola, catenary : float
        Closed forms.
    unstretched : float
        Parabola whose tension stays at the pretension.
    """

    chain: float
    parabola: float
    catenary: float
    unstretched: float


def sag_table(drive: Drive, segments: int = 200) -> SagTable:
    """Sag of the upper span beside the closed forms.

    ``drive``: a level loop without carriages; ``segments``: segments per span; even, so that a node is at
    midspan.
    """
    mesh = mesh_of(drive, segments)
    rest = equilibrium(mesh, cable_law(drive.cable)).displacement
    cable = drive.cable
    weight = cable.stretched_mass_per_length * drive.layout.gravity
    return SagTable(
        chain=float(abs(rest[2, segments // 2])),
        parabola=parabola_sag(drive).midpoint,
        catenary=catenary_sag(drive).midpoint,
        unstretched=weight * drive.pulley_distance**2 / (8.0 * cable.pretension),
    )


def plucks(heights: tuple[float, float] = PLUCKS) -> Start:
    """Triangular plucks at midspan, from where the cable hangs.

    ``heights``: of upper and lower span [m].
    """
    upper, lower = heights
    return Start(plucks=(Pluck(height=upper), Pluck(height=lower, span="lower")), from_equilibrium=True)


def plucked_run(drive: Drive, duration: float, *, rate: float = 4000.0, fields: int = 0) -> SimulationResult:
    """Free response to unequal plucks.

    ``duration`` [s]; ``rate``: records per second [Hz]; ``fields``: keep all nodes at every so many records.
    """
    recording = Recording(rate=rate, fields=fields)
    return whole(
        simulate(drive, duration, start=plucks(), scheme=Scheme(segments=SEGMENTS), recording=recording)
    )


def forced_run(drive: Drive, duration: float) -> SimulationResult:
    """Response to a torque at the frequency of the lowest longitudinal mode, from rest.

    ``duration`` [s].
    """
    frequency = float(natural_frequencies(drive, count=1)[0])
    return simulate(
        drive,
        duration,
        torque=Sine(amplitude=TORQUE, frequency=frequency),
        start=Start(from_equilibrium=True),
        scheme=Scheme(segments=SEGMENTS),
        recording=Recording(rate=4000.0),
    )


def whirling_run(drive: Drive, duration: float) -> SimulationResult:
    """A half-sine pluck in w and a kick in v that alone would swing three fifths as far.

    ``duration`` [s].
    """
    speed = (drive.cable.pretension / drive.cable.stretched_mass_per_length) ** 0.5
    omega = np.pi * speed / drive.pulley_distance
    start = Start(
        plucks=(Pluck(height=WHIRL, shape="half-sine"),),
        kicks=(Pluck(height=0.6 * omega * WHIRL, shape="half-sine", plane="v"),),
        from_equilibrium=True,
    )
    return simulate(
        drive, duration, start=start, scheme=Scheme(segments=40), recording=Recording(rate=2000.0)
    )


def slackened_run(drive: Drive, duration: float = 4.0) -> SimulationResult:
    """Load pulley held, no weight, torque on the drive pulley raised in a line to twice the slack torque.

    ``duration`` [s]; many periods of the drive pulley on its two spans.
    Returns ended where a span goes slack.
    """
    pulleys = (drive.pulley[0], replace(drive.pulley[1], fixed=True))
    held = replace(drive, pulley=pulleys, layout=replace(drive.layout, gravity=0.0))
    ramp = Sampled(values=np.array([0.0, 2.0 * slack_torque(drive)]), rate=1.0 / duration)
    return simulate(
        held,
        duration,
        torque=ramp,
        scheme=Scheme(segments=30),
        recording=Recording(rate=500.0),
    )


def slack_torque(drive: Drive) -> float:
    """Torque that leaves no tension in one of two equal spans.

    ``drive``: a loop.
    Returns [N m].
    """
    return 2.0 * drive.drive_pulley.radius * drive.cable.pretension


def by_every_way(drive: Drive, duration: float) -> Iterator[tuple[str, str, SimulationResult]]:
    """The plucked run by several laws and methods, and by the fast model.

    ``duration`` [s].

    Yields
    ------
    str, str, SimulationResult
        Law, method, run.
    """
    from cabledrive.reduction.fast_simulation import simulate_fast

    recording = Recording(rate=4000.0)
    start = replace(plucks(), from_equilibrium=False)
    for model, method in WAYS:
        scheme = Scheme(model=model, method=method, segments=60)
        run = simulate(drive, duration, start=start, scheme=scheme, recording=recording)
        yield model, method, whole(run)
    yield "fast", "modes", whole(simulate_fast(drive, duration, start=start, recording=recording))


def largest_difference(result: SimulationResult, reference: SimulationResult) -> float:
    """Largest difference of two midpoints over the largest deflection of the reference.

    ``result``, ``reference``: runs of the same length.
    Returns of the upper midpoint, in w [-].
    """
    expected: Array = reference.midpoint("upper")[:, 2]
    found = np.interp(reference.time, result.time, result.midpoint("upper")[:, 2])
    return float(np.max(np.abs(found - expected)) / np.max(np.abs(expected)))
