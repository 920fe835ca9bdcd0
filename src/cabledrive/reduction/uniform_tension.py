r"""The loop with uniform tension in each span: few modes along, sines across, and their motion in time.

The longitudinal motion is expanded in the certified modes :math:`U_k` below the first resonance of a span:
rigid rotation, pulley mode, motor joint. What lies above follows without inertia. The transverse motion of
each span is a sum of sines. The energy of chapter 2 then gives, with unit modal masses along and
:math:`m_t = \rho L_e/2` across, Eqs. (R.1), (R.2), (R.3):

.. math::
    \ddot q_k + \sum_l C_{kl}\dot q_l + W_k^2 q_k &= \phi_{k\tau}\,\tau
        - \sum_{jm} G_{kjm} (a_{jm}^2 + b_{jm}^2) \\
    \ddot a_{jm} + \Gamma\dot a_{jm} + \Big[w_m^2 + \frac{2}{m_t}\sum_k G_{kjm} q_k
        + \frac{EA^2 \kappa_m^2}{K L_e \rho} S_j\Big] a_{jm} &= \mp g_m \\
    G_{kjm} = \tfrac14 EA\,\kappa_m^2\,\Delta U_{kj}\Big(1 - \frac{x_k^2}{4\pi^2 m^2 - x_k^2}\Big), \qquad
    S_j &= \sum_m \tfrac14 \kappa_m^2 L_e (a_{jm}^2 + b_{jm}^2)

with :math:`\kappa_m = m\pi/L_e`, :math:`K = EA(1 + \varepsilon_0)`, :math:`x_k = W_k L_e/c_u` and
:math:`\Delta U_{kj}` the difference of mode k between the ends of span j.

One step h is half a kick, the exact flow of the damped linear system, half a kick (Strang), Eq. (R.4):

.. math:: \dot x \leftarrow \dot x + \tfrac12 h f(x), \qquad
          (x, \dot x) \leftarrow e^{Ah}(x, \dot x), \qquad
          A = \begin{pmatrix}0 & 1\\ -W^2 & -C\end{pmatrix},

so that every linear frequency and decay is exact at any step; the coupling is of second order.
"""

from dataclasses import dataclass
from math import pi
from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.holding import FREE, modal_losses, motor_condition
from cabledrive.mechanics.spans import rigid_mass
from cabledrive.modal import longitudinal_modes
from cabledrive.modal.tuning import rims_of
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.modal_cable_kernels import (
    ModalCableNumbers,
    integration_kernel,
    new_modal_cable_state,
)

STEEPEST = 0.05
"""Largest slope of the cable for which the tension may count as uniform; (slope)^2 is the relative error."""
HIGHEST_SHARE = 0.9
"""Longitudinal modes are kept below this share of the first resonance of a span, c_u / (2 Le)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UniformTensionModel:
    """Coefficients of (R.1)-(R.3) for one drive; k longitudinal modes, two spans, m sines."""

    natural: Array  # (k,): longitudinal frequencies W [rad/s]; first 0 with a free motor: rigid rotation
    damping: Array  # (k, k): modal damping C [1/s]
    rims: Array  # (k, 2): displacement of drive rim and load rim, of unit modal mass [kg^-1/2]
    torque_shape: Array  # (k,): modal force per torque [kg^-1/2 / m]
    stretch: Array  # (k, 2): difference of each mode between the ends of each span [kg^-1/2]
    coupling: Array  # (k, 2, m): G [N/m kg^-1/2]
    transverse: Array  # (m,): transverse frequencies w [rad/s]
    transverse_mass: float  # modal mass of a sine, rho Le / 2 [kg]
    transverse_damping: float  # Gamma [1/s]
    wave_numbers: Array  # (m,): kappa [1/m]
    carrier: float  # EA^2 / (K Le rho), of the tension that the transverse motion itself makes [m/s^2]
    gravity_load: Array  # (2, m): modal acceleration by gravity in the plane of the loop [m/s^2]
    radii: tuple[float, float]  # of drive pulley and load pulley [m]
    pretension: float  # T0 [N]
    stiffness: float  # K [N]
    axial_rigidity: float  # EA [N]
    span: float  # Le [m]
    span_resonance: float
    """First longitudinal one of a span between held rims: the model ends below it [rad/s]."""


def uniform_tension_model(drive: Drive, sines: int = 16) -> UniformTensionModel:
    """Reduce a loop to uniform tension in each span with some sines per span and plane, Eqs. (R.1)-(R.3).

    Refused: lines, carried masses, held pulleys and Coulomb friction, which the model does not have.
    """
    _check_fits(drive, sines)
    cable, length = drive.cable, drive.pulley_distance
    span_resonance = pi * cable.axial_wave_speed / length
    kept = longitudinal_modes(drive, below=HIGHEST_SHARE * span_resonance / (2 * pi))
    shapes = [rims_of(mode) for mode in kept]
    natural = np.array([2 * pi * mode.frequency for mode in kept])
    if motor_condition(drive) == FREE:
        natural = np.append(0.0, natural)
        shapes.insert(0, np.full(3, rigid_mass(drive) ** -0.5))
    elif not kept:
        said = "the holding stiffness leaves no longitudinal mode below the first resonance of a span"
        raise InputRefused(f"{said}: the fast model does not fit; use --model exact")
    rims = np.array(shapes)
    wave_numbers = np.arange(1, sines + 1, dtype=np.float64) * pi / length
    stiffness = cable.axial_rigidity * (1.0 + cable.prestrain)
    density = cable.stretched_mass_per_length
    stretch = np.outer(rims[:, 1] - rims[:, 0], [1.0, -1.0])
    x, m = (natural * length / cable.axial_wave_speed)[:, None, None], np.arange(1, sines + 1)
    uneven = 1.0 - x**2 / (4 * pi**2 * m**2 - x**2)
    per_sine = 2.0 * (1.0 - np.cos(m * pi)) / (m * pi)  # -g on w1 and +g on w2 onto the sines, (2.26), (2.27)
    return UniformTensionModel(
        natural=natural,
        damping=modal_losses(drive, rims, natural**2),
        rims=rims[:, :2],
        torque_shape=rims[:, 2] / drive.drive_pulley.radius,
        stretch=stretch,
        coupling=0.25 * cable.axial_rigidity * stretch[:, :, None] * wave_numbers**2 * uneven,
        transverse=wave_numbers * cable.transverse_wave_speed,
        transverse_mass=0.5 * density * length,
        transverse_damping=cable.transverse_damping,
        wave_numbers=wave_numbers,
        carrier=cable.axial_rigidity**2 / (stiffness * length * density),
        gravity_load=np.outer([-drive.layout.gravity_across, drive.layout.gravity_across], per_sine),
        radii=(drive.drive_pulley.radius, drive.load_pulley.radius),
        pretension=cable.pretension,
        stiffness=stiffness,
        axial_rigidity=cable.axial_rigidity,
        span=length,
        span_resonance=span_resonance,
    )


def _check_fits(drive: Drive, sines: int) -> None:
    friction = max(pulley.coulomb_friction for pulley in drive.pulley)
    friction = max(friction, drive.motor.coulomb_friction if drive.motor else 0.0)
    for refused, why in (
        (drive.kind != "loop", f'kind = "{drive.kind}" does not fit the fast model, which needs a loop:'),
        (drive.carriage, f"carriage: {len(drive.carriage)} given, the fast model carries none:"),
        (
            any(pulley.fixed for pulley in drive.pulley),
            "pulley.fixed = true does not fit the fast model, where both turn:",
        ),
        (
            friction > 0.0,
            f"coulomb_friction = {friction:.4g} N m does not fit the fast model, which is smooth: "
            "set it to 0 or",
        ),
    ):
        if refused:
            raise InputRefused(f"{why} use --model exact")
    if not 1 <= sines <= 400:
        raise InputRefused(f"sines = {sines} transverse modes must lie between 1 and 400")


class IntegratedMotion(NamedTuple):
    """What an integration recorded; velocities at the times of the positions."""

    along: Array  # (records, 2, k): longitudinal amplitudes [m kg^1/2] and their rates
    across: Array  # (records, 2, planes, 2, m): transverse amplitudes [m] and their rates
    tallies: Array  # (records, 3): work of the torque, energy lost across and along since the start [J]
    peaks: Array
    """(2, 2): per span: lowest tension [N], largest amplitude summed over the sines, planes together [m]."""


def linear_flow(natural: Array, damping: Array | float, step: float) -> Array:
    """Exact flow over a step [s], (4, ...): place from place and from rate, rate from place and from rate."""
    root = np.sqrt((natural**2 - 0.25 * damping**2).astype(complex)) * step
    decay = np.exp(-0.5 * damping * step)
    turn = decay * np.cos(root).real
    push = decay * step * np.sinc(root / np.pi).real
    return np.array([turn + 0.5 * damping * push, push, -(natural**2) * push, turn - 0.5 * damping * push])


def first_order(squares: Array, damping: Array) -> Array:
    """Matrix of the rates of amplitudes, then rates, shape (2k, 2k)."""
    zero, one = np.zeros_like(damping), np.eye(squares.size)
    return np.block([[zero, one], [-np.diag(squares), -damping]])


def coefficients(model: UniformTensionModel, step: float) -> ModalCableNumbers:
    """Prepare an integration with one step length h [s]; the motions are those of both rims."""
    from scipy.linalg import expm

    modes, sines = model.natural.size, model.transverse.size
    return ModalCableNumbers(
        steps=1,
        step=step,
        along=expm(first_order(model.natural**2, model.damping) * step),
        push=np.zeros((2 * modes, 0)),
        across=linear_flow(model.transverse, model.transverse_damping, step),
        sag=model.gravity_load / model.transverse**2,
        coupling=model.coupling,
        carried=model.carrier * model.wave_numbers**2,
        stretching=0.25 * model.wave_numbers**2 * model.span,
        wave_numbers=model.wave_numbers,
        middle=np.sin(0.5 * pi * np.arange(1, sines + 1)),
        factors=np.array([2.0 / model.transverse_mass, model.axial_rigidity / model.span, STEEPEST]),
        motions=np.ascontiguousarray((model.rims / model.radii).T),
        rest=np.full(2, model.pretension),
        tension=np.ascontiguousarray((model.stiffness / model.span * model.stretch).T),
    )


def integrate(
    model: UniformTensionModel,
    numbers: ModalCableNumbers,
    start: tuple[Array, Array, Array, Array],
    torque: Array,
    stride: int,
) -> IntegratedMotion:
    """Integrate the model in time, Eq. (R.4).

    ``numbers``: of `coefficients` for the step h; ``start``: longitudinal amplitudes [m kg^1/2] and rates,
    shape (k,), transverse amplitudes [m] and rates, shape (planes, 2, m), planes w (and v), which become
    those at the end;
    ``torque``, shape (steps + 1,): at the ends of the steps [N m]; ``stride``: steps between two recorded
    instants.
    """
    q, p, a, b = start
    state = new_modal_cable_state(numbers, len(a))
    state.modes[:], state.sines[:], state.rates[:] = np.concatenate((q, p)), a, b
    losses = model.damping, model.transverse_mass * model.transverse_damping
    motion = integration_kernel(numbers, model.torque_shape, losses, state, torque, stride)
    q[:], p[:] = np.split(state.modes, 2)
    a[:], b[:] = state.sines, state.rates
    return IntegratedMotion(*motion)
