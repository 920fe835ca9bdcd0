r"""Static equilibrium of the divided cable under gravity and carriages, by Newton with line search."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.mesh import Mesh, cable_forces, gradients
from cabledrive.parameters.errors import InputRefused, NotComputed

MOST_ITERATIONS = 100
SHORTEST_STEP = 2.0**-30


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Equilibrium:
    """Where the cable rests."""

    displacement: Array  # (3, nodes): u, v, w from the straight pretensioned cable [m]
    holding_torque: tuple[float, float]
    """Torque on drive pulley and load pulley that keeps them there [N m], that of a holding stiffness
    included; zero where a pulley is free."""
    residual: float  # largest force left out of balance [N]
    iterations: int  # Newton steps taken


def equilibrium(mesh: Mesh, law: CableLaw, *, hold: str = "none") -> Equilibrium:
    """Where cable and carriages rest.

    ``hold``, {"none", "drive", "both"}: pulleys held at angle zero. With "none" the drive pulley stays at
    zero because nothing turns it, which is checked; on a holding stiffness it turns until that balances the
    weights.
    Raises `InputRefused` if `hold` is unknown, or both pulleys are free and the weight of carriages on a
    slope would turn them; `NotComputed` if Newton's method finds no equilibrium, or a piece of a cable that
    cannot push hangs slack.
    """
    if hold not in ("none", "drive", "both"):
        raise InputRefused(f'hold = "{hold}" is not one of its values: write "none", "drive" or "both"')
    rigid_load = mesh.shafts[1].fixed or hold == "both"
    free = np.zeros((3, mesh.nodes), dtype=bool)  # v stays zero; angles are counted from the drive rim
    free[0], free[2], free[0, 0] = True, mesh.sways, False
    if mesh.closed:
        free[:, -1] = False
    if rigid_load:
        free[0, mesh.segments] = False
    balance = _Balance(mesh, law, free)
    spring, scale = rotor_stiffness(mesh) if hold == "none" else 0.0, balance.scale
    slope = spring + (len(mesh.spans) * law.stiffness / float(mesh.position[0, -1]) if rigid_load else 0.0)
    rim, total = 0.0, 0
    before: tuple[float, float] | None = None
    # Secants on the rim's displacement: where the load pulley turns, all goes along and the first is exact.
    for _ in range(MOST_ITERATIONS):
        displacement, iterations = balance.solve(_following(mesh, rim, rigid_load))
        total += iterations
        left = balance.on_all(displacement)
        over = float(left[0, 0]) - spring * rim
        if spring == 0.0 or abs(over) <= 1e-9 * scale:
            break
        if before is not None and over != before[1]:
            slope = -(over - before[1]) / (rim - before[0])
        before = rim, over
        rim += over / slope
    else:
        said = f"no equilibrium on the holding stiffness: {over:.3g} N out of balance at the drive rim"
        raise NotComputed(f"{said}; raise motor.holding_stiffness or hold the drive pulley")
    drive_torque = -float(spring * rim if spring else left[0, 0]) * mesh.shafts[0].radius
    load_torque = -float(left[0, mesh.segments]) * mesh.shafts[1].radius if rigid_load else 0.0
    loose = hold == "none" and not mesh.shafts[0].fixed and not rigid_load and spring == 0.0
    if loose and abs(drive_torque) > 1e-9 * mesh.shafts[0].radius * scale:
        raise InputRefused(
            f"gravity turns the free pulleys: {drive_torque:.4g} N m would hold them; hold the drive pulley"
        )
    return Equilibrium(
        displacement=displacement,
        holding_torque=(0.0 if loose else drive_torque, load_torque),
        residual=float(np.max(np.abs(left[free]))),
        iterations=total,
    )


def rotor_stiffness(mesh: Mesh) -> float:
    """What holds the drive rim [N/m]: the holding stiffness in series with the motor's joint; 0: nothing."""
    rotor = mesh.shafts[2] if mesh.joint is not None else mesh.shafts[0]
    holding = rotor.holding_stiffness / rotor.radius**2
    if mesh.joint is None or holding == 0.0:
        return holding
    joint = mesh.joint.stiffness / rotor.radius**2
    return joint * holding / (joint + holding)


def _following(mesh: Mesh, rim: float, rigid_load: bool) -> Array:
    """Displacements that go along with the drive rim, all of them or less towards a held load rim."""
    start = np.zeros((3, mesh.nodes))
    for number, span in enumerate(mesh.spans):
        share = mesh.position[number] / mesh.position[number, -1]
        near = 1.0 - share if number == 0 else share
        start[0, mesh.span_nodes(span)] = rim * (near if rigid_load else 1.0)
    return start


class _Balance:
    """Forces on the free displacements of a mesh, and Newton's steps to where none is left over."""

    def __init__(self, mesh: Mesh, law: CableLaw, free: NDArray[np.bool_]) -> None:
        self.mesh, self.law, self.free = mesh, law, free
        weight = float(np.sum(np.abs(mesh.weight_u)) + np.sum(np.abs(mesh.weight_w)))
        self.scale = max(law.pretension, weight)
        self.tolerance = max(1e-13 * self.scale, 64 * np.finfo(float).eps * law.stiffness)

    def on_all(self, displacement: Array) -> Array:
        """Forces on every node along u, v, w, (3, nodes) [N]."""
        force = cable_forces(self.mesh, self.law, displacement)
        force[0] += self.mesh.weight_u
        force[2] += self.mesh.weight_w
        return force

    def left(self, displacement: Array, free: NDArray[np.bool_]) -> Array:
        """Forces left out of balance on free displacements, (3, nodes) [N]."""
        return np.where(free, self.on_all(displacement), 0.0)

    def solve(self, displacement: Array) -> tuple[Array, int]:
        """Newton's method; a step is halved until it lowers the sum of squares of the forces left over."""
        for iteration in range(MOST_ITERATIONS):
            left = self.left(displacement, self.free)
            if np.max(np.abs(left)) <= self.tolerance:
                return displacement, iteration
            step, share, merit = self.step(displacement, left, self.free), 1.0, np.sum(left**2)
            while share > SHORTEST_STEP:
                trial = self.with_level_tension(displacement + share * step)
                if np.sum(self.left(trial, self.free) ** 2) <= (1.0 - 1e-4 * share) * merit:
                    break
                share /= 2.0
            else:
                said = f"no equilibrium: {np.sqrt(merit):.3g} N out of balance and no step lowers it"
                raise NotComputed(f"{said}; raise cable.pretension or use more segments")
            displacement = trial
        raise NotComputed(
            f"no equilibrium within {MOST_ITERATIONS} Newton steps: {np.max(np.abs(left)):.3g} N out of "
            "balance; raise cable.pretension or use more segments"
        )

    def with_level_tension(self, displacement: Array) -> Array:
        """Let u follow a change of w: a straight step would stretch the stiff cable to second order."""
        along = self.free.copy()
        along[1:] = False
        for _ in range(5):
            left = self.left(displacement, along)
            if np.max(np.abs(left)) <= self.tolerance:
                break
            displacement = displacement + self.step(displacement, left, along)
        return displacement

    def step(self, displacement: Array, left: Array, free: NDArray[np.bool_]) -> Array:
        """Tangent stiffness x step = forces left over, a banded system with u, w of node after node."""
        from scipy.linalg import solve_banded

        mesh, law, planes = self.mesh, self.law, np.array([0, 2])
        tangent = law.stiffness_matrix(*gradients(mesh, displacement))[:, planes[:, None], planes]
        blocks = tangent / mesh.spacing[:, None, None]
        diagonal = np.zeros((mesh.nodes, 2, 2))
        diagonal[:-1] += blocks
        diagonal[1:] += blocks
        known = ~free[planes].T
        band = np.zeros((7, 2 * mesh.nodes))
        for row in range(2):
            for column in range(2):
                keep = ~(known[:, row] | known[:, column])
                band[3 + row - column, column::2] = np.where(keep, diagonal[:, row, column], 0.0)
                after = ~(known[:-1, row] | known[1:, column])
                band[1 + row - column, 2 + column :: 2] = np.where(after, -blocks[:, row, column], 0.0)
                before = ~(known[1:, row] | known[:-1, column])
                band[5 + row - column, column:-2:2] = np.where(before, -blocks[:, row, column], 0.0)
        band[3][known.ravel()] = law.stiffness
        try:
            solution = solve_banded((3, 3), band, left[planes].T.ravel())
        except np.linalg.LinAlgError:  # a slack piece resists nothing
            raise NotComputed(
                "no equilibrium: a piece of the cable hangs slack; raise cable.pretension"
            ) from None
        step = np.zeros_like(displacement)
        step[planes] = solution.reshape(-1, 2).T
        if mesh.closed:
            step[:, -1] = step[:, 0]
        return step
