r"""The model of internal resonance of many parameter sets: as oscillators in time, and of many loops at once.

One step is half a kick, the exact flow of the damped linear oscillators, half a kick; the kick is

.. math::
    \Delta\dot q &= h\Big(\frac{\phi_\tau\tau/r_1 - c_{12}v - \sum_j G_j a_j^2}{M}\Big), \qquad
    \Delta v = h\,\frac{\tau/r_1 - c_{11}v - c_{12}\dot q}{M_0} \\
    \Delta\dot a_j &= -\frac{h}{m_j}\Big(2G_j q + \sum_k N_{jk}a_k^2\Big)a_j. \qquad \text{Eq. (A.20)}

Frequencies and decays are exact at any step; the coupling is of second order.

The models of many loops of two pulleys are in closed form. Their spans are alike, so one transverse mode
stands for both. With rim displacements :math:`u_1, u_2` and :math:`\varphi = kL`, the balance of one rim
gives the shape of the pulley mode, and on a span without masses the integral of Eq. (A.10) is as beside it,

.. math:: u_1/u_2 = \cos\varphi - \frac{W m_2}{2Z}\sin\varphi, \qquad
          \int U_s w_s^2\,\mathrm{d}s = \frac{(n\pi)^2}{2L^2}(u_2 - u_1)
          \Big[1 + \frac{k^2}{k^2 - (2n\pi/L)^2}\Big].
"""


# mypy: allow-untyped-defs

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cabledrive.mechanics.compiled import njit
from cabledrive.mechanics.network import rest_forces
from cabledrive.modal.batch import LoopBatch
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.autoparametric import AutoparametricModel
from cabledrive.reduction.transverse_sections import HIGHEST_NUMBER
from cabledrive.reduction.uniform_tension import linear_flow


class OscillatorCoefficients(NamedTuple):
    """What an integration needs; every array may end in an axis of lanes."""

    along: Array  # (4, ...): exact flow of q: q from q, q from rate, rate from q, rate from rate
    across: Array  # (4, J, ...): exact flow of a
    push: Array  # (J, ...): G / M [1/(m s^2)]
    pump: Array  # (J, ...): 2 G / m [1/(m s^2)]
    cubic: Array  # (J, J, ...): N / m [1/(m^2 s^2)]
    force: Array  # (...): acceleration of q by the torque's amplitude [m/s^2]
    rigid_force: Array  # (...): of the rigid rotation [m/s^2]
    turn: Array  # (...): angle of the torque per step [rad]
    cross: Array  # (...): c12 / M [1/s]
    rigid_decay: Array  # (...): c11 / M0 [1/s]
    rigid_cross: Array  # (...): c12 / M0 [1/s]
    step: Array  # (...): h [s]


def oscillator_coefficients(
    model: AutoparametricModel, step: float, *, torque: ArrayLike = 0.0
) -> OscillatorCoefficients:
    """Coefficients of a step [s], Eq. (A.20), with the model's lanes, forced at its pulley mode [N m]."""
    tau = np.asarray(torque, dtype=float)
    damping = np.asarray(model.transverse_damping, dtype=float)
    rigid = model.rigid_arm > 0.0
    cross = model.cross_damping if rigid else 0.0
    return OscillatorCoefficients(
        along=linear_flow(np.asarray(model.natural), np.asarray(model.modal_damping), step),
        across=linear_flow(model.transverse, damping, step),
        push=model.coupling / model.modal_mass,
        pump=2.0 * (model.coupling.T / model.transverse_mass).T,
        cubic=(model.stiffening.T / model.transverse_mass).T,
        force=tau * model.torque_arm / model.modal_mass,
        rigid_force=tau * model.rigid_arm / model.rigid_mass,
        turn=np.asarray(model.natural * step),
        cross=np.asarray(cross / model.modal_mass),
        rigid_decay=np.asarray(model.rigid_damping / model.rigid_mass if rigid else 0.0),
        rigid_cross=np.asarray(cross / model.rigid_mass),
        step=np.asarray(step),
    )


AXES = {"along": 1, "push": 1, "pump": 1, "across": 2, "cubic": 2}
"""Axes of coefficients that are not lanes, where there are any."""


class Largest(NamedTuple):
    """What an ensemble has reached."""

    pulley: Array  # (lanes,): largest q, either way [m]
    spans: Array  # (J, lanes): largest amplitude a of each section [m]
    state: Array  # at the end: q and a, shape (1 + J, lanes)


def oscillator_ensemble(
    c: OscillatorCoefficients, plucks: ArrayLike, steps: int, *, threads: int = 2
) -> Largest:
    """Largest displacements of many parameter sets by the oscillators themselves.

    ``plucks``, shape (J, lanes): amplitudes at t = 0, at rest [m]; ``steps``: of the length in `c`.
    """
    start = np.asarray(plucks, dtype=float)
    if start.ndim != 2:
        raise InputRefused(f"start has {start.ndim} axes, an ensemble needs 2: amplitudes and lanes")
    wide = {}  # coefficients with an axis of lanes each
    for name, value in c._asdict().items():
        own = np.asarray(value)
        own = own[..., None] if own.ndim == AXES.get(name, 0) else own
        wide[name] = np.ascontiguousarray(np.broadcast_to(own, (*own.shape[:-1], start.shape[1])))
    state = np.concatenate((np.zeros((1, *start.shape[1:])), start))
    top = np.zeros_like(state)
    given, edges = (
        c._replace(**wide),
        np.linspace(0, start.shape[1], max(1, threads) + 1).astype(int).tolist(),
    )
    with ThreadPoolExecutor(max(1, threads)) as pool:
        part = partial(integrate_oscillators, given, steps, state, top)
        list(pool.map(part, edges[:-1], edges[1:]))
    return Largest(top[0], top[1:], state)


@njit
def integrate_oscillators(c, steps, state, top, first, last):
    """Half a kick, exact flow, half a kick, of lanes `first` to `last`; state and largest in place."""
    sections = state.shape[0] - 1
    a, b, squares = np.empty(sections), np.empty(sections), np.empty(sections)
    for i in range(first, last):
        q, p, v = 0.0, 0.0, 0.0
        cosine, sine, turn_cos, turn_sin = 1.0, 0.0, np.cos(c.turn[i]), np.sin(c.turn[i])
        for j in range(sections):
            a[j], b[j] = state[1 + j, i], 0.0
        for n in range(steps + 1):
            h = (0.5 if n == 0 or n == steps else 1.0) * c.step[i]
            top[0, i] = max(top[0, i], abs(q))
            force = c.force[i] * sine - c.cross[i] * v
            rigid = c.rigid_force[i] * sine - c.rigid_decay[i] * v - c.rigid_cross[i] * p
            for j in range(sections):
                squares[j] = a[j] * a[j]
            for j in range(sections):
                top[1 + j, i] = max(top[1 + j, i], abs(a[j]))
                force -= c.push[j, i] * squares[j]
                stiff = c.pump[j, i] * q
                for k in range(sections):
                    stiff += c.cubic[j, k, i] * squares[k]
                b[j] -= h * stiff * a[j]
            p += h * force
            v += h * rigid
            if n < steps:
                q, p = c.along[0, i] * q + c.along[1, i] * p, c.along[2, i] * q + c.along[3, i] * p
                for j in range(sections):
                    place, rate = a[j], b[j]
                    a[j] = c.across[0, j, i] * place + c.across[1, j, i] * rate
                    b[j] = c.across[2, j, i] * place + c.across[3, j, i] * rate
                cosine, sine = cosine * turn_cos - sine * turn_sin, sine * turn_cos + cosine * turn_sin
        state[0, i] = q
        for j in range(sections):
            state[1 + j, i] = a[j]


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
