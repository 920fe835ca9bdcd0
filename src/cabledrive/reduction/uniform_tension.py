r"""The loop with uniform tension in each span: few modes along, sines across, and their motion in time.

The longitudinal motion is expanded in the certified modes :math:`U_k` below the first resonance of a span:
rigid rotation, pulley mode, motor joint. What lies above follows without inertia. The transverse motion of
each span is a sum of sines. It is a `StretchModel` with diagonal G and D, whose rows are the spans in the
plane w, then in v. The energy of chapter 2 gives, with unit modal masses along and :math:`m_t = \rho L_e/2`
across, Eqs. (R.1), (R.2), (R.3):

.. math::
    \ddot q_k + \sum_l C_{kl}\dot q_l + W_k^2 q_k &= \phi_{k\tau}\,\tau
        - \sum_{jm} G_{kjm} (a_{jm}^2 + b_{jm}^2) \\
    \ddot a_{jm} + \Gamma\dot a_{jm} + \Big[w_m^2 + \frac{2}{m_t}\sum_k G_{kjm} q_k
        + \frac{EA^2 \kappa_m^2}{K L_e \rho} S_j\Big] a_{jm} &= \mp g_m \\
    G_{kjm} = \tfrac14 EA\,\kappa_m^2\,\Delta U_{kj}\Big(1 - \frac{x_k^2}{4\pi^2 m^2 - x_k^2}\Big), \qquad
    S_j &= \sum_m \tfrac14 \kappa_m^2 L_e (a_{jm}^2 + b_{jm}^2)

with :math:`\kappa_m = m\pi/L_e`, :math:`K = EA(1 + \varepsilon_0)`, :math:`x_k = W_k L_e/c_u` and
:math:`\Delta U_{kj}` the difference of mode k between the ends of span j; the model's ``coupling`` is 2 G,
its ``square`` :math:`\tfrac12\kappa_m^2 L_e`.
"""

from math import pi
from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.holding import FREE, modal_losses, motor_condition
from cabledrive.mechanics.spans import rigid_mass
from cabledrive.modal.natural import longitudinal_modes
from cabledrive.modal.tuning import rims_of
from cabledrive.parameters import Drive, InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.two_pulleys import two_pulleys_of
from cabledrive.reduction.stretch_runs import recorded_run
from cabledrive.reduction.stretches import StretchModel, StretchNumbers, new_stretch_state

STEEPEST = 0.05
"""Largest slope of the cable for which the tension may count as uniform; (slope)^2 is the relative error."""
HIGHEST_SHARE = 0.9
"""Longitudinal modes are kept below this share of the first resonance of a span, c_u / (2 Le)."""


def uniform_tension_model(drive: Machine | Drive, sines: int = 16, planes: int = 1) -> StretchModel:
    """Reduce a loop to uniform tension in each span with some sines per span and plane, Eqs. (R.1)-(R.3).

    ``planes``, {1, 2}: w alone, or v as well. The motions shown are the angles of drive and load pulley and
    motor. Refused: lines, carried masses, held pulleys and Coulomb friction, which the model does not have.
    """
    drive = two_pulleys_of(drive, "the fast model, unlike --model exact,")
    if why := misfit(drive):
        raise InputRefused(f"{why} use --model exact")
    if not 1 <= sines <= 400:
        raise InputRefused(f"sines = {sines} transverse modes must lie between 1 and 400")
    cable, length = drive.cable, drive.pulley_distance
    span_resonance = pi * cable.axial_wave_speed / length
    kept = longitudinal_modes(drive, below=HIGHEST_SHARE * span_resonance / (2 * pi), taut=True)
    shapes = [rims_of(mode) for mode in kept]
    natural = np.array([2 * pi * mode.frequency for mode in kept])
    if motor_condition(drive) == FREE:
        natural = np.append(0.0, natural)
        shapes.insert(0, np.full(3, rigid_mass(drive) ** -0.5))
    elif not kept:
        said = "the holding stiffness leaves no longitudinal mode below the first resonance of a span"
        raise InputRefused(f"{said}: the fast model does not fit; use --model exact")
    rims, first = np.array(shapes), drive.drive_pulley.radius
    m, rows = np.arange(1, sines + 1, dtype=np.float64), 2 * planes
    wave_numbers = m * pi / length
    stiffness = cable.axial_rigidity * (1.0 + cable.prestrain)
    density = cable.stretched_mass_per_length
    stretch = np.outer(rims[:, 1] - rims[:, 0], [1.0, -1.0])
    x = (natural * length / cable.axial_wave_speed)[:, None, None]
    uneven = 1.0 - x**2 / (4 * pi**2 * m**2 - x**2)
    coupling = 0.5 * cable.axial_rigidity * stretch[:, :, None] * wave_numbers**2 * uneven
    transverse = wave_numbers * cable.transverse_wave_speed
    gravity = 2.0 * (1.0 - np.cos(m * pi)) / (m * pi) * drive.layout.gravity_across
    sag = np.zeros((rows, sines))
    sag[:2] = np.outer([-1.0, 1.0], gravity / transverse**2)  # -g on w1 and +g on w2, (2.26), (2.27)
    return StretchModel(
        natural=natural,
        damping=modal_losses(drive, rims, natural**2),
        torque_shape=rims[:, 2] / first,
        transverse=np.tile(transverse, (rows, 1)),
        mass=np.full((rows, sines), 0.5 * density * length),
        loss=np.full((rows, sines), cable.transverse_damping),
        sag=sag,
        coupling=np.tile(coupling, (1, planes, 1)),
        square=np.tile(0.5 * wave_numbers**2 * length, (rows, 1)),
        carried=np.tile(np.eye(2), (planes, planes)) * cable.axial_rigidity**2 / (stiffness * length),
        rest=np.full(2, cable.pretension),
        tension=np.ascontiguousarray((stiffness / length * stretch).T),
        raised=np.tile(np.eye(2), planes) * cable.axial_rigidity / length,
        slopes=wave_numbers,
        steepest=STEEPEST,
        probes=np.tile(np.sin(0.5 * pi * m)[:, None], (rows, 1, 1)),
        motions=np.ascontiguousarray((rims / [first, drive.load_pulley.radius, first]).T),
        highest=HIGHEST_SHARE * span_resonance,
    )


def misfit(drive: Drive) -> str:
    """Why the fast model does not fit a drive; empty where it does."""
    friction = max(pulley.coulomb_friction for pulley in drive.pulley)
    friction = max(friction, drive.motor.coulomb_friction if drive.motor else 0.0)
    whys = (
        (not drive.closed, f'kind = "{drive.kind}" does not fit the fast model, which needs a loop:'),
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
    )
    return next((why for refused, why in whys if refused), "")


class IntegratedMotion(NamedTuple):
    """What an integration recorded; velocities at the times of the positions."""

    along: Array  # (records, 2, k): longitudinal amplitudes [m kg^1/2] and their rates
    across: Array  # (records, 2, rows, m): transverse amplitudes [m] and their rates
    tallies: Array  # (records, 3): work of the torque, energy lost across and along since the start [J]
    peaks: Array
    """(2, 2): per span: lowest tension [N], largest amplitude summed over the sines, planes together [m]."""


def integrate(
    numbers: StretchNumbers, start: tuple[Array, Array, Array, Array], torque: Array, stride: int
) -> IntegratedMotion:
    """Integrate the model in time.

    ``start``: longitudinal amplitudes [m kg^1/2] and rates, shape (k,), transverse amplitudes [m] and rates,
    shape (rows, m), which become those at the end; ``torque``, shape (steps + 1,): at the ends of the steps
    [N m]; ``stride``: steps between two recorded instants.
    """
    q, p, a, b = start
    state = new_stretch_state(numbers)
    state.modes[:], state.sines[:], state.rates[:] = np.concatenate((q, p)), a, b
    motion = recorded_run(numbers, state, torque, stride)
    q[:], p[:] = np.split(state.modes, 2)
    a[:], b[:] = state.sines, state.rates
    return IntegratedMotion(*motion)
