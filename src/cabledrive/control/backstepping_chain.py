r"""Backstepping for motor, flexible joint, drive pulley, flexible cable and load, six states, all uncertain.

States are :math:`x_1 = \theta_2`, :math:`x_3 = S_1(\theta_{12} - \theta_2)`, :math:`x_5 = S_2(\theta_{11} -
\theta_{12})` and their rates, with :math:`S_1 = k_k/J_2` and :math:`S_2 = S_1k_m/J_{12}`:

.. math::
    \dot x_2 &= p_1x_3 + p_2 + w_1, \qquad
    \dot x_4 = p_3x_5 - p_4x_3 - S_1p_2 + w_2, \\
    \dot x_6 &= S_2p_{10}u - p_5x_5 + p_6x_3 - p_7\dot\theta_{11} - p_8S + p_9 + w_3

What the dampers add, :math:`w_j`, is taken along the reference, with every derivative that the steps ask for.
"""

from math import isfinite, pi

import numpy as np

from cabledrive.control.backstepping_recursion import equal_bandwidth
from cabledrive.control.darc_gains import printed_bounds
from cabledrive.control.numbers import BACKSTEPPING, LawNumbers, learning_table
from cabledrive.control.reference import lagged
from cabledrive.control.reference_numbers import ReferenceNumbers, reference_numbers
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain

REFERENCE_SLOPE = 50.0
_LOAD_ACCELERATION = 2.0  # rad/s^2
# Relative half widths of stiffnesses and inertias: cable, load, joint, drive pulley.
_CABLE, _LOAD, _JOINT, _PULLEY = 0.05, 0.05, 0.10, 0.05


def chain_scales(chain: LumpedChain) -> tuple[float, float]:
    """S_1 [1/s^2] and S_2 [1/s^4], which give the virtual controls gain one, of three inertias, Model 4."""
    if chain.size != 3:
        raise InputRefused(f"{chain.size} inertias given, backstepping of six states takes 3: use Model 4")
    s1 = chain.stiffness[1] / chain.inertias[2]
    return s1, s1 * chain.stiffness[0] / chain.inertias[1]


def chain_parameters(chain: LumpedChain) -> tuple[Array, Array]:
    """The ten parameters and their half widths, of three inertias between equal angles, Model 4.

    Half widths: from 5 % of cable and load, 10 % of the joint, 5 % of the drive pulley, 2 rad/s^2 of load and
    the printed bounds of the motor.
    """
    s2 = chain_scales(chain)[1]
    motor, pulley, load = chain.inertias
    joint, cable = chain.stiffness
    bounds = printed_bounds(chain, flexible_joint=True)
    inertia, friction = bounds.spread[0] / (2.0 * motor), bounds.spread[1:] / 2.0 * s2 / motor
    matched = np.array([chain.viscous[0], chain.coulomb[0], chain.offsets[0]]) * s2 / motor
    parameters = np.array(
        [
            1.0,
            chain.offsets[2] / load,
            1.0,
            cable / pulley + cable / load,
            joint / motor + joint / pulley,
            joint * cable / pulley**2,
            *matched,
            1.0 / motor,
        ]
    )
    shares = np.array(
        [
            _CABLE + _LOAD,
            0.0,
            _JOINT + _PULLEY,
            _CABLE + _LOAD,
            _JOINT + inertia,
            _CABLE + _JOINT + 2.0 * _PULLEY,
            0.0,
            0.0,
            0.0,
            inertia,
        ]
    )
    widths = shares * parameters
    widths[1] = _LOAD_ACCELERATION
    widths[6:9] = friction + inertia * np.abs(matched)
    return parameters, widths


def chain_reference(chain: LumpedChain, wanted: Array, interval: float) -> Array:
    r"""What the law takes at each sample.

    Along the reference :math:`x_3 = \ddot y_d/D_2` and :math:`x_5 = S_1(1 + J_2/J_{12})\ddot y_d/D_1 +
    y_d^{(4)}/(D_1D_2)`; what the undamped chain lacks of their rates is :math:`w_j`.

    ``wanted``, shape (7, samples): wanted load angle at the first shaft, to its sixth derivative. Returns
    shape (samples, 17): y_d to its sixth derivative, w1 to its fourth, w2 to its second, w3, speed of the
    motor.
    """
    joint, cable = _times(chain)
    jointed = lagged(wanted, joint, interval)
    stages = (wanted, lagged(wanted, cable, interval), jointed, lagged(jointed, cable, interval))
    return np.ascontiguousarray(_signals(chain, *stages).T)


def chain_generator(chain: LumpedChain, interval: float) -> ReferenceNumbers:
    """The generator of the rows of `chain_reference`."""
    joint, cable = _times(chain)
    output = _signals(chain, *np.split(np.eye(28), 4))
    return reference_numbers(output, (cable, joint, cable), interval, sources=(0, 0, 2))


def _times(chain: LumpedChain) -> tuple[float, float]:
    """Time constants b / k of joint and cable [s]."""
    joint, cable = (d / k for d, k in zip(chain.damping, chain.stiffness, strict=True))
    return joint, cable


def _signals(chain: LumpedChain, wanted: Array, cabled: Array, jointed: Array, both: Array) -> Array:
    """The signals of time from the wanted motion and what cable, joint and both leave of it, (7, p) each."""
    s1, s2 = chain_scales(chain)
    motor, pulley, load = chain.inertias
    x3 = cabled[2:]
    x5 = s1 * (1.0 + load / pulley) * jointed[2:5] + both[4:]
    p4 = chain.stiffness[1] / pulley + s1
    w1 = wanted[2:] - x3
    w2 = x3[2:] - x5 + p4 * x3[:3]
    joint_torque = chain.damping[0] * x5[1] / s2
    cable_torque = chain.damping[1] * x3[1] / s1
    w3 = s2 * (cable_torque / pulley - joint_torque * (1.0 / motor + 1.0 / pulley))
    speed = wanted[1] + x3[1] / s1 + x5[1] / s2
    return np.vstack((wanted, w1, w2, w3, speed))


def chain_numbers(chain: LumpedChain, bandwidth: float, adaptation: float, interval: float) -> LawNumbers:
    """Freeze the law of six states; ``bandwidth`` [Hz]; ``adaptation``: gamma of (6.36), 0: none.

    Refused: a bandwidth that is not positive, a negative adaptation.
    """
    if not isfinite(bandwidth) or bandwidth <= 0.0:
        raise InputRefused(
            f"bandwidth = {bandwidth:.6g} Hz must be finite and above 0: the errors grow otherwise"
        )
    if not isfinite(adaptation) or adaptation < 0.0:
        raise InputRefused(f"adaptation = {adaptation:.6g} must not be negative: give 0 to switch it off")
    parameters, widths = chain_parameters(chain)
    learning = learning_table(
        parameters, parameters - widths, parameters + widths, adaptation * (2.0 * widths) ** 2
    )
    return LawNumbers(
        kind=BACKSTEPPING,
        matrix=equal_bandwidth(3, 2.0 * pi * bandwidth),
        rows=np.array([chain_scales(chain)]),
        learning=learning,
        scalars=np.array([interval, 0.0, REFERENCE_SLOPE, 1.0, 0.0, 1.0, 0.0]),
    )
