r"""Inertias in line, joined by springs and dampers: Models 1 to 4 of a cable drive.

Link j joins inertia j to inertia j + 1. Its stretch is :math:`e_j = p_j\theta_j - q_j\theta_{j+1}`; a joint
has :math:`p = q = 1`, a cable between rims has the radii. With :math:`\tau_c` the torque left after Coulomb
friction and offset, the chain obeys Eqs. (4.18), (6.10), (6.11), (6.13) for its length.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cabledrive.mechanics.holding import span_stiffness
from cabledrive.parameters import Drive, InputRefused, Machine
from cabledrive.parameters.arrays import Array, Complex
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.route.two_pulleys import two_pulleys_of


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class LumpedChain:
    """A lumped chain of n inertias and n - 1 links; angles in rad, or displacements in m of masses."""

    names: tuple[str, ...] = meaning('what each inertia is: "motor", "drive", "load", ...')
    inertias: tuple[float, ...] = meaning("moments of inertia [kg m^2]")
    viscous: tuple[float, ...] = meaning("viscous friction b of each inertia [N m s/rad], signs as in (4.16)")
    coulomb: tuple[float, ...] = meaning("Coulomb friction c [N m]")
    offsets: tuple[float, ...] = meaning("constant torque d [N m]")
    stiffness: tuple[float, ...] = meaning("of each link, per stretch [N m/rad], [N/m] between rims", ())
    damping: tuple[float, ...] = meaning("of each link, per stretch [N m s/rad], [N s/m] between rims", ())
    ratios: tuple[tuple[float, float], ...] = meaning(
        "(p, q) of each link: 1 and 1 of a joint; radii [m] of a cable", ()
    )
    holding: float = meaning(
        "spring from the first inertia to the ground, the motor's holding stiffness [N m/rad]", 0.0
    )

    def __post_init__(self) -> None:
        n = len(self.inertias)
        if n == 0 or any(len(x) != n for x in (self.names, self.viscous, self.coulomb, self.offsets)):
            raise InputRefused(
                f"a lumped chain of {n} inertias needs {n} names, frictions and offsets: give as many"
            )
        if any(len(x) != n - 1 for x in (self.stiffness, self.damping, self.ratios)):
            said = f"a lumped chain of {n} inertias needs {n - 1} links"
            raise InputRefused(f"{said}: give stiffness, damping and ratios of each")
        if min(self.inertias) <= 0.0:
            raise InputRefused(
                f"inertia = {min(self.inertias):.4g} must be above 0: merge the inertia with its neighbour"
            )

    @property
    def size(self) -> int:
        """Number of inertias."""
        return len(self.inertias)

    @property
    def link_matrix(self) -> Array:
        """Stretches of the links per angle, shape (n - 1, n)."""
        matrix = np.zeros((self.size - 1, self.size))
        for j, (p, q) in enumerate(self.ratios):
            matrix[j, j], matrix[j, j + 1] = p, -q
        return matrix

    @property
    def stiffness_matrix(self) -> Array:
        """K, shape (n, n) [N m/rad]."""
        g = self.link_matrix
        matrix: Array = g.T @ np.diag(self.stiffness) @ g
        matrix[0, 0] += self.holding
        return matrix

    @property
    def damping_matrix(self) -> Array:
        """C of links and viscous friction, shape (n, n) [N m s/rad]."""
        g = self.link_matrix
        return g.T @ np.diag(self.damping) @ g + np.diag(self.viscous)


def first_order(stiffness: Array, damping: Array, masses: Array) -> tuple[Array, Array]:
    r"""Matrices of :math:`\dot x = A x + B f` with displacements and speeds as states, n of each.

    ``masses``, shape (n,). Returns ``a``, shape (2n, 2n); ``b``, shape (2n, n): one column per force.
    """
    n, inverse = masses.size, np.diag(1.0 / masses)
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
    return a, np.vstack([np.zeros((n, n)), inverse])


def state_space(chain: LumpedChain) -> tuple[Array, Array]:
    """`first_order` of a chain: angles and speeds, and the torques left after friction and offset."""
    return first_order(chain.stiffness_matrix, chain.damping_matrix, np.array(chain.inertias))


def held(system: Array, inputs: Array, interval: float) -> tuple[Array, Array]:
    """Transition (n, n), push (n,) or (n, k) over an interval [s] of a system under inputs that are held."""
    from scipy.linalg import expm

    n = len(system)
    block = np.zeros((n + inputs.size // n,) * 2)
    block[:n] = np.column_stack((system, inputs))
    power = expm(block * interval)[:n]
    return power[:, :n], power[:, n:].reshape(inputs.shape)


def speed_response(chain: LumpedChain, omega: Array, speed_of: int = 0) -> Complex:
    r"""Frequency response from torque to speed: Eqs. (4.17), (4.19), (6.12), (6.14), their misprints mended.

    .. math:: H = i\omega\, e^T (K + i\omega C - \omega^2 M)^{-1} f

    ``omega``, shape (m,): angular frequencies [rad/s], not zero; torque on the motor; ``speed_of``: number of
    an inertia, from the motor.
    Returns shape (m,): speed per torque [rad/(N m s)].
    """
    w = np.asarray(omega, dtype=float)[:, None, None]
    dynamic = chain.stiffness_matrix + 1j * w * chain.damping_matrix - w**2 * np.diag(chain.inertias)
    angle = np.linalg.solve(dynamic, np.broadcast_to(np.eye(chain.size, 1), (len(w), chain.size, 1)))
    return 1j * w[:, 0, 0] * angle[:, speed_of, 0]


def frequencies_of(stiffness: Array, masses: Array) -> Array:
    """Undamped natural frequencies [rad/s], ascending, shape (n,); rigid motions have 0."""
    root = 1.0 / np.sqrt(masses)
    return np.sqrt(np.clip(np.linalg.eigvalsh(root[:, None] * stiffness * root), 0.0, None))


def natural_frequencies_of(chain: LumpedChain) -> Array:
    """Undamped natural frequencies [rad/s], ascending, without the rigid rotation if there is one."""
    found = frequencies_of(chain.stiffness_matrix, np.array(chain.inertias))
    return found[0 if chain.holding > 0.0 else 1 :]


def reflected(chain: LumpedChain) -> tuple[LumpedChain, Array]:
    r"""The same row in angles of its first shaft, so that every link has :math:`p = q = 1`.

    With :math:`\varphi_i = g_i\theta_i`, :math:`g_1 = 1`, :math:`g_{j+1} = g_j q_j/p_j`, torques are divided
    by
    :math:`g_i` and inertias and viscous frictions by :math:`g_i^2`; a stretch :math:`p_j\theta_j -
    q_j\theta_{j+1}` is :math:`(p_j/g_j)(\varphi_j - \varphi_{j+1})`.

    Returns ``chain``: stiffness and damping in N m/rad and N m s/rad of the first shaft; ``gears``, shape
    (n,): :math:`g_i`, angle at the first shaft per angle of inertia i.
    """
    gears = np.ones(chain.size)
    for j, (p, q) in enumerate(chain.ratios):
        gears[j + 1] = gears[j] * q / p
    arms = np.array([p for p, _ in chain.ratios]) / gears[:-1]

    def scaled(values: tuple[float, ...], factors: Array) -> tuple[float, ...]:
        return tuple(float(v) for v in np.array(values) * factors)

    return replace(
        chain,
        inertias=scaled(chain.inertias, gears**-2),
        viscous=scaled(chain.viscous, gears**-2),
        coulomb=scaled(chain.coulomb, 1.0 / gears),
        offsets=scaled(chain.offsets, 1.0 / gears),
        stiffness=scaled(chain.stiffness, arms**2),
        damping=scaled(chain.damping, arms**2),
        ratios=((1.0, 1.0),) * (chain.size - 1),
    ), gears


FLEXIBLE_JOINT = {1: False, 2: True, 3: False, 4: True}
FLEXIBLE_CABLE = {1: False, 2: False, 3: True, 4: True}


def rim_spring(drive: Drive) -> tuple[float, float]:
    """Stiffness [N/m] and damping [N s/m] of all spans together, 2 k and 2 b_c / r of (6.11) for a loop.

    ``[lumped]``, where given: what was measured; else EA / L and the cable's own axial damping.
    """
    cable, radius = drive.cable, drive.drive_pulley.radius
    damping = cable.axial_damping / drive.span_length
    if drive.lumped is not None and drive.lumped.cable_damping is not None:
        damping = drive.lumped.cable_damping / radius
    return len(drive.spans) * span_stiffness(drive), len(drive.spans) * damping


def highest_model(drive: Drive) -> int:
    """The most detailed model that the drive's data allow. Returns 4 with a flexible motor joint, else 3."""
    return 4 if drive.motor is not None and drive.motor.joint_stiffness is not None else 3


def lumped_model(drive: Machine | Drive, model: int | None = None) -> LumpedChain:
    """One of the Models 1 to 4 of a drive, Eqs. (6.9), (6.10), (6.11), (6.13), for any two radii.

    Parameters
    ----------
    drive : Machine or Drive
    model : {1, 2, 3, 4}, optional
        1: rigid joint and cable; 2: flexible joint; 3: flexible cable; 4: both. Default: `highest_model`.

    Returns
    -------
    LumpedChain
        Inertias in the order motor (with the drive pulley where the joint is rigid), drive, load; the motor
        on its holding stiffness where the drive has one.

    Raises
    ------
    InputRefused
        If the drive lacks what the model needs, or carries masses on its cable.
    """
    drive = two_pulleys_of(drive, "`lumped_model`", chains=True)
    model = highest_model(drive) if model is None else model
    _check(drive, model)
    motor, pulley, load = drive.motor, drive.drive_pulley, drive.load_pulley
    rows = {"drive": np.array([*_shaft(pulley), 0.0])}
    links: list[tuple[float, float, tuple[float, float]]] = []
    if motor is not None:
        own = np.array([*_shaft(motor), motor.offset_torque])
        rows = {"motor": own, **rows} if FLEXIBLE_JOINT[model] else {"motor": own + rows["drive"]}
        if FLEXIBLE_JOINT[model]:
            links.append((motor.joint_stiffness or 0.0, motor.joint_damping, (1.0, 1.0)))
    if FLEXIBLE_CABLE[model]:
        rows["load"] = np.array([*_shaft(load), 0.0])
        links.append((*rim_spring(drive), (pulley.radius, load.radius)))
    else:
        ratio = pulley.radius / load.radius
        rows[list(rows)[-1]] += np.array([*_shaft(load), 0.0]) * np.array([ratio**2, ratio**2, ratio, 0.0])
    keys = ("inertias", "viscous", "coulomb", "offsets")
    of_shafts: dict[str, Any] = dict(
        zip(keys, map(tuple, np.array(list(rows.values())).T.tolist()), strict=True)
    )
    return LumpedChain(
        names=tuple(rows),
        **of_shafts,
        **dict(zip(("stiffness", "damping", "ratios"), zip(*links, strict=True), strict=False)),
        holding=(motor.holding_stiffness or 0.0) if motor is not None else 0.0,
    )


def _shaft(part: object) -> tuple[float, ...]:
    return tuple(getattr(part, name) for name in ("inertia", "viscous_friction", "coulomb_friction"))


def _check(drive: Drive, model: int) -> None:
    if model not in FLEXIBLE_JOINT:
        raise InputRefused(f"model = {model} is none of 1, 2, 3, 4: choose one of them")
    if FLEXIBLE_JOINT[model] and (drive.motor is None or drive.motor.joint_stiffness is None):
        raise InputRefused(
            f"model {model} needs motor.joint_stiffness [N m/rad]: give it, or take model {model - 1}"
        )
    if drive.carriage:
        said = f"the lumped models do not support carriages, the drive has {len(drive.carriage)}"
        raise InputRefused(f"{said}: name the axis of one, or use `study` (guided carriage) or `simulate`")
    fixed = [name for name, pulley in zip(("drive", "load"), drive.pulley, strict=True) if pulley.fixed]
    if fixed:
        raise InputRefused(
            f"the lumped models need two rotating pulleys, the {fixed[0]} pulley is fixed: use `simulate`"
        )
