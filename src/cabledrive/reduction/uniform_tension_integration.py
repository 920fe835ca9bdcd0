r"""Integrating the uniform-tension model: exact linear flow, nonlinear kicks.

One step h is half a kick, the exact flow of the damped linear system, half a kick (Strang), Eq. (R.4):

.. math:: \dot x \leftarrow \dot x + \tfrac12 h f(x), \qquad
          (x, \dot x) \leftarrow e^{Ah}(x, \dot x), \qquad
          A = \begin{pmatrix}0 & 1\\ -W^2 & -C\end{pmatrix},

so that every linear frequency and decay is exact at any step; the coupling is of second order.
"""

from typing import NamedTuple

import numpy as np

from cabledrive.parameters.arrays import Array
from cabledrive.reduction.uniform_tension import UniformTensionModel
from cabledrive.reduction.uniform_tension_kernels import integration_kernel
from cabledrive.reduction.uniform_tension_single import single_sine_kernel


class IntegratedMotion(NamedTuple):
    """What an integration recorded; velocities at the times of the positions."""

    along: Array  # (records, 2, k): longitudinal amplitudes [m kg^1/2] and their rates
    across: Array  # (records, 2, planes, 2, m): transverse amplitudes [m] and their rates
    tallies: Array  # (records, 3): work of the torque, energy lost across and along since the start [J]
    peaks: Array
    """(2, 2): per span: lowest change of tension [N], largest amplitude summed over the sines, planes
    together [m]."""


class Coefficients(NamedTuple):
    """What a step needs, for one step length: arrays only, so that a kernel takes one argument."""

    along: Array  # (2 k, 2 k): exact flow of the longitudinal modes, amplitudes then rates, Eq. (R.4)
    across: Array  # (4, m): exact flow of the sines: x from x, x from v, v from x, v from v
    torque_shape: Array  # (k,): modal force per torque
    coupling: Array  # (k, 2, m): G of (R.3)
    per_mass: float  # 2 / m_t [1/kg]
    carried: Array  # (m,): carrier kappa^2, tension stiffening per S [1/(m s^2)]
    stretching: Array  # (m,): kappa^2 Le / 4, S per squared amplitude [1/m]
    sag: Array  # (2, m): where gravity holds the linear string, in w; the flow turns about it [m]
    tension_along: Array  # (k, 2): tension of each span per longitudinal amplitude [N kg^1/2]
    tension_across: float  # tension per S [N/m]
    loss_along: Array  # (k, k): modal damping, of the power lost along [1/s]
    loss_across: float  # m_t Gamma, of the power lost across [kg/s]


def coefficients(model: UniformTensionModel, step: float) -> Coefficients:
    """Prepare an integration with one step length. ``step``: step length h [s]."""
    from scipy.linalg import expm

    zero, one = np.zeros_like(model.damping), np.eye(model.natural.size)
    system = np.block([[zero, one], [-np.diag(model.natural**2), -model.damping]])
    return Coefficients(
        along=expm(system * step),
        across=_flow(model.transverse, np.full(model.transverse.size, model.transverse_damping), step),
        torque_shape=model.torque_shape,
        coupling=model.coupling,
        per_mass=2.0 / model.transverse_mass,
        carried=model.carrier * model.wave_numbers**2,
        stretching=0.25 * model.wave_numbers**2 * model.span,
        sag=model.gravity_load / model.transverse**2,
        tension_along=model.stiffness / model.span * model.stretch,
        tension_across=model.axial_rigidity / model.span,
        loss_along=model.damping,
        loss_across=model.transverse_mass * model.transverse_damping,
    )


def _flow(natural: Array, damping: Array, step: float) -> Array:
    """Exact flow of damped oscillators over one step, shape (4, n)."""
    root = np.sqrt((natural**2 - 0.25 * damping**2).astype(complex)) * step
    decay = np.exp(-0.5 * damping * step)
    turn = decay * np.cos(root).real
    push = decay * step * np.sinc(root / np.pi).real
    return np.array([turn + 0.5 * damping * push, push, -(natural**2) * push, turn - 0.5 * damping * push])


def integrate(
    c: Coefficients, q: Array, p: Array, a: Array, b: Array, torque: Array, h: float, stride: int
) -> IntegratedMotion:
    """Integrate the model in time, Eq. (R.4).

    ``c``: for the step `h`; ``q``, ``p``, shape (k,): longitudinal amplitudes [m kg^1/2] and rates at the
    start; at the end of the integration on return; ``a``, ``b``, shape (planes, 2, m): transverse amplitudes
    [m]
    and rates, planes w (and v); ``torque``, shape (steps + 1,): at the ends of the steps [N m]; ``h``: step
    [s]; ``stride``: steps between two recorded instants.
    """
    kernel = single_sine_kernel if a.shape == (1, 2, 1) else integration_kernel
    return IntegratedMotion(*kernel(c, q, p, a, b, torque, h, stride))
