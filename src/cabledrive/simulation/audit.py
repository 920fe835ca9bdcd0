"""What a run says about its own error: energy budget, slack."""

from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import LAWS
from cabledrive.mechanics.mesh import Mesh
from cabledrive.mechanics.mesh_forces import strain_energy, weight_energy
from cabledrive.mechanics.sag import parabola_sag
from cabledrive.mechanics.statics import equilibrium, rotor_stiffness
from cabledrive.mechanics.tension_only import taut_law
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.simulation.case import Case
from cabledrive.simulation.channels import AXIAL, COLUMN, WEIGHT_ENERGY
from cabledrive.simulation.plan import EVENTS, MOST_EVENTS, State


@dataclass(frozen=True, slots=True, kw_only=True)
class SlackEvent:
    """A span that went slack.

    Attributes
    ----------
    time : float
        When [s].
    span : {"upper", "lower"}
    position : float
        Where first, as the distance from the span's start along the pretensioned cable [m].
    tension : float
        What the taut law gives there at that step [N], just below zero.
    """

    time: float
    span: str
    position: float
    tension: float


def slack_events(case: Case, state: State) -> tuple[SlackEvent, ...]:
    """Where and when spans went slack up to the end of a run, in order, the first thousand times."""
    noted = state.events[: min(int(state.counts[EVENTS]), MOST_EVENTS)]
    return tuple(
        SlackEvent(
            time=float(step * case.grid.step),
            span=case.mesh.spans[int(span)],
            position=float(case.mesh.position[int(span), int(segment) : int(segment) + 2].mean()),
            tension=float(tension),
        )
        for step, span, segment, tension in noted
    )


def budget_error(rows: Array) -> Array:
    """Error of the energy budget at each record: energy plus losses less work, less its start [J]."""
    balance = rows[:, COLUMN["balance"]]
    error: Array = balance - balance[:1]
    return error


def energy_handled(rows: Array, energy_at_rest: float) -> float:
    """Largest energy [J] of a run: what it started with above `rest_energy`, and the work done on it."""
    if not len(rows):
        return 0.0
    start = float(np.sum(rows[0, AXIAL : WEIGHT_ENERGY + 1])) - energy_at_rest
    work = rows[:, COLUMN["torque_work"]] + rows[:, COLUMN["force_work"]]
    return max(start, 0.0) + float(np.max(work, initial=0.0))


def rest_energy(drive: Drive, mesh: Mesh, law: CableLaw) -> float:
    r"""Energy of the drive at rest under gravity, relative to the straight pretensioned cable.

    Without carriages, that of the parabola: with :math:`q = \int \tfrac12 w'^2 dx = L_e (P/H)^2/24`,
    :math:`E = T_0 q + \tfrac{K}{2 L_e} q^2 - 2 H q` for each span.

    Returns energy [J], zero or negative.
    """
    if not drive.layout.gravity:
        return 0.0
    spring = rotor_stiffness(mesh)
    if not drive.carriage and not spring and type(taut_law(law)) in LAWS.values():
        return len(mesh.spans) * _parabola_energy(drive, mesh, law)
    try:
        rest = equilibrium(mesh, law).displacement
    except (
        InputRefused,
        NotComputed,
    ):  # gravity turns the pulleys: there is no rest, so count from held ones
        rest = equilibrium(mesh, law, hold="both").displacement
    held = 0.5 * spring * float(rest[0, 0]) ** 2
    return float(np.sum(strain_energy(mesh, law, rest))) + weight_energy(mesh, rest) + held


def _parabola_energy(drive: Drive, mesh: Mesh, law: CableLaw) -> float:
    tension = parabola_sag(drive).horizontal_tension
    length = drive.pulley_distance
    stretch = length * (float(np.abs(mesh.weight_w).max()) / mesh.spacing[0] * length / tension) ** 2 / 24.0
    stored = law.pretension * stretch + 0.5 * law.stiffness / length * stretch**2
    return stored - 2.0 * tension * stretch
