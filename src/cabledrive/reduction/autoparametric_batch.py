r"""Models of the internal resonance of many loops of two pulleys, in closed form.

The spans of such a loop are alike, so one transverse mode stands for both. With rim displacements
:math:`u_1, u_2` and :math:`\varphi = kL`, the balance of one rim gives the shape of the pulley mode,

.. math:: u_1/u_2 = \cos\varphi - \frac{W m_2}{2Z}\sin\varphi,

and on a span without masses the integral of Eq. (A.10) is

.. math:: \int U_s w_s^2\,\mathrm{d}s = \frac{(n\pi)^2}{2L^2}(u_2 - u_1)
          \Big[1 + \frac{k^2}{k^2 - (2n\pi/L)^2}\Big].
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network import rest_forces
from cabledrive.modal.batch import LoopBatch
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.autoparametric import AutoparametricModel
from cabledrive.reduction.transverse_sections import HIGHEST_NUMBER

ALONE = 0.1
"""Least stretch of the spans, over the larger rim displacement, for which q is that stretch."""
PLACES, SHARES = np.polynomial.legendre.leggauss(16)
MOST_STEPS = 60


class PulleyModes(NamedTuple):
    """Pulley mode of each loop; every array is of shape (n,)."""

    omega: Array  # W [rad/s]
    drive: Array  # rim displacement per q, as the next two
    load: Array
    motor: Array
    mass: Array  # M [kg]


class TautSpans(NamedTuple):
    """Both spans of each loop under their tension; every array is of shape (n,)."""

    pretension: Array  # T0, to which the coupling belongs [N]
    force: Array  # R, force of the uniform string on which a wave takes as long [N]
    lowest: Array  # lowest tension [N]


def pulley_modes(loops: LoopBatch, omega: Array) -> PulleyModes:
    """Shapes of the pulley modes of many loops, as `scaled_rims`; ``omega``, shape (n,): W [rad/s]."""
    (first, second), (spring, pendant, held) = loops.masses, loops.pendant
    impedance = np.sqrt(loops.rigidity * loops.density)
    phase = omega * loops.length / np.sqrt(loops.rigidity / loops.density)
    free = spring + held - omega**2 * pendant
    hung = spring * (held - omega**2 * pendant) / np.where(loops.flexible, free, 1.0)
    load = omega**2 * first - loops.grounds - hung
    turned = np.sin(phase) / (2.0 * impedance)
    by_load = np.cos(phase) - omega * second * turned
    by_drive = np.cos(phase) - load / omega * turned
    # of the two balances the one that subtracts nothing: it gives the larger of both displacements
    far = np.abs(by_load) >= 1.0
    u1, u2 = np.where(far, by_load, 1.0), np.where(far, 1.0, by_drive)
    motor = spring * u1 / free if loops.flexible else u1
    scale = u2 - u1
    larger = np.where(np.abs(u2) > np.abs(u1), u2, u1)
    scale = np.where(np.abs(scale) < ALONE * np.abs(larger), larger, scale)
    # of the squared displacement on a span between its rims
    far, near = (np.sin(np.outer(0.5 * (1.0 + way * PLACES), phase)) for way in (1.0, -1.0))
    cable = 0.5 * SHARES @ ((u1 * near + u2 * far) / np.sin(phase)) ** 2 * loops.length
    moved = first * u1**2 + second * u2**2 + pendant * motor**2 + 2.0 * loops.density * cable
    return PulleyModes(omega, u1 / scale, u2 / scale, motor / scale, moved / scale**2)


def straight_spans(loops: LoopBatch, pretension: Array) -> TautSpans:
    """Spans of straight loops under a pretension, shape (n,) [N]."""
    force = pretension / (1.0 + pretension / loops.rigidity)
    return TautSpans(pretension, force, pretension)


def spans_at_rest(loops: LoopBatch) -> TautSpans:
    r"""Level spans under their weight: `rest_state` where both are alike and one force is unknown.

    .. math:: \int_0^L\Big(\frac{H}{EA} + \frac{H}{|\mathbf F|} - 1\Big)\mathrm{d}s = \varepsilon_0 L

    The left side is concave in H, so that Newton's method from the pretension on comes from below.
    Returns NaN where it does not settle.
    """
    if loops.gravity_across == 0.0:
        return straight_spans(loops, loops.pretension)
    weights = rest_forces.SHARES
    across = np.outer(0.5 - rest_forces.PLACES, loops.density * loops.gravity_across * loops.length)
    along, prestrain = loops.pretension.copy(), loops.pretension / loops.rigidity
    settled: NDArray[np.bool_] = np.zeros(along.size, dtype=bool)
    for _ in range(MOST_STEPS):
        tension = np.hypot(along, across)
        fallen = weights @ (across**2 / (tension * (tension + along)))
        give = 1.0 / loops.rigidity + weights @ (across**2 / tension**3)
        step = (prestrain - along / loops.rigidity + fallen) / give
        along = along + step
        settled = np.abs(step) <= 1e-14 * along
        if settled.all():
            break
    slowness = weights @ np.sqrt(1.0 / np.hypot(along, across) + 1.0 / loops.rigidity)
    along = np.where(settled, along, np.nan)
    return TautSpans(loops.pretension, slowness**-2, along)


def many_models(loops: LoopBatch, modes: PulleyModes, spans: TautSpans) -> AutoparametricModel:
    """Model of each loop as `autoparametric_model` makes it, loops as lanes, the upper span for both.

    The transverse amplitude is scaled to unit modal mass; stiffening is left out, on which no threshold
    depends.
    """
    lanes, radius = modes.omega.shape, loops.radius[0]
    travel = loops.length * np.sqrt(loops.density / spans.force)
    number = np.clip(np.ceil(0.5 * modes.omega * travel / np.pi - 0.5), 1, HIGHEST_NUMBER)
    stretch = 1.0 + spans.pretension / loops.rigidity
    along = modes.omega * np.sqrt(loops.density / loops.rigidity)
    across = number * np.pi / loops.length
    bent = 0.5 * across**2 * (modes.load - modes.drive) * (1.0 + along**2 / (along**2 - 4.0 * across**2))
    coupling = 0.5 * loops.rigidity / stretch**2 * bent / (0.5 * loops.density * loops.length)
    arm, twist = radius**2, modes.motor - modes.drive
    # friction at the rim of what turns with the rigid rotation [N s/m], and its displacement per q
    turning = [
        (loops.viscous[0] / arm, modes.drive),
        (loops.viscous[1] / loops.radius[1] ** 2, modes.load),
        (loops.motor_viscous / arm, modes.motor),
    ]
    springs = loops.joint_stiffness * twist**2 + loops.holding_stiffness * modes.motor**2
    strain = modes.omega**2 - springs / arm / modes.mass
    lost = sum(viscous * shape**2 for viscous, shape in turning) + loops.joint_damping / arm * twist**2
    free = np.full(lanes, 0.0 if loops.held else 1.0)
    moving = sum(loops.masses) + 2.0 * loops.density * loops.length + loops.pendant[1]
    # largest strain of each pulley mode per q: inside a span where it has a node there
    near, far, phase = modes.drive, modes.load, along * loops.length
    ends = np.maximum(np.abs(far - near * np.cos(phase)), np.abs(far * np.cos(phase) - near))
    crest = np.sqrt(np.maximum(near**2 + far**2 - 2.0 * near * far * np.cos(phase), 0.0))
    steepest = along * np.where(near * far < 0.0, crest, ends) / np.sin(phase)
    values: dict[str, Any] = {
        "natural": modes.omega,
        "modal_mass": modes.mass,
        "modal_damping": loops.axial_damping / loops.rigidity * strain + lost / modes.mass,
        "rims": (modes.drive, modes.load),
        "torque_arm": modes.motor / radius,
        "rigid_arm": free / radius,
        "rigid_mass": np.inf if loops.held else moving,
        "rigid_damping": free * sum(viscous for viscous, _ in turning),
        "cross_damping": free * sum(viscous * shape for viscous, shape in turning),
        "coulomb_force": np.zeros(lanes),
        "modes": (),
        "transverse": (number * np.pi / travel)[None],
        "transverse_mass": np.ones(1),
        "transverse_damping": loops.transverse_damping,
        "coupling": coupling[None],
        "stiffening": np.zeros((1, 1)),
        "slack_amplitude": spans.lowest / (loops.rigidity * steepest),
        "uneven": np.zeros(1),
        "load_radius": loops.radius[1],
        "pretension": spans.pretension,
        "axial_rigidity": loops.rigidity,
        "tension_offset": np.zeros(1),
    }
    return AutoparametricModel(**values)
