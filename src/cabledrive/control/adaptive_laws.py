r"""Adaptive laws about a quadratic feedback: L1 with piecewise-constant adaptation, direct MRAC.

The feedback u = -K e makes the reference model, :math:`e_{k+1} = A_me_k`. What the plant does beyond it is
laid to a torque at the motor.

- L1: a predictor runs beside the plant; the torque that takes its error away within one sample, through a
  low-pass, is subtracted. N. Hovakimyan, C. Cao, L1 Adaptive Control Theory, SIAM, 2010, section 3.3.
- MRAC: the torque is a sum of known functions of the reference with unknown factors. With P of the Riccati
  equation :math:`b^TPe` is the feedback itself up to a factor, so that :math:`\dot\theta = \Gamma\varphi
  (-Ke)`, projected on bounds.
"""

from math import exp, pi

import numpy as np

from cabledrive.control.flat_output import FlatOutput
from cabledrive.control.linear_laws import (
    FRICTION_SLOPE,
    feedforward_generator,
    linear_law,
    lq_law,
    sampled_motion,
)
from cabledrive.control.numbers import REFERENCE_MODEL, LawNumbers, learning_table
from cabledrive.control.reference import flat_map
from cabledrive.control.reference_numbers import ReferenceNumbers
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain


def l1_law(chain: LumpedChain, error: float, torque: float, bandwidth: float, interval: float) -> LawNumbers:
    """Quadratic feedback with L1 adaptation, which is a linear law: memory of predictor and low-pass.

    ``error`` [rad] and ``torque`` [N m] weigh the same; ``bandwidth``: of the low-pass [Hz].
    """
    n2 = 2 * chain.size
    a, b = sampled_motion(chain, interval)
    gain = -lq_law(chain, error, torque, interval).rows
    model = a - b @ gain
    seen = -b[:, 0] / float(b[:, 0] @ b[:, 0])  # torque at the motor per error of the prediction
    newest = 1.0 - exp(-2.0 * pi * bandwidth * interval)
    # Memory: predicted errors, then the low-passed torque; inputs: memory, errors, last command. What the
    # prediction misses, matched or not, is given to the predictor at once: it starts from the errors anew.
    matrix = np.zeros((n2 + 1, 2 * n2 + 2))
    matrix[:n2, n2] = -b[:, 0]
    matrix[:n2, n2 + 1 : 2 * n2 + 1] = model
    matrix[n2, :n2], matrix[n2, n2] = newest * seen, 1.0 - newest
    matrix[n2, n2 + 1 : 2 * n2 + 1] = -newest * seen
    row = np.hstack((np.zeros((1, n2)), [[-1.0]], -gain))
    return linear_law(matrix, row, interval)


def reference_model_law(
    feedback: LawNumbers, low: Array, high: Array, largest: Array, rate: float
) -> LawNumbers:
    """Direct MRAC about a feedback without memory.

    ``low``, ``high``, shape (p,): bounds of the factors; ``largest``, shape (p,): largest values of the
    functions along the reference; ``rate``: at which the torque adapts where all functions are at their
    largest [rad/s], in a loop whose feedback answers a torque by itself.
    """
    width = np.maximum(high - low, 0.0)
    gain = rate * width**2 / max(float((width * largest) @ (width * largest)), 1e-300)
    return feedback._replace(
        kind=REFERENCE_MODEL, learning=learning_table(np.zeros(len(low)), low, high, gain)
    )


def reference_model_generator(chain: LumpedChain, flat: FlatOutput, interval: float) -> ReferenceNumbers:
    """The generator of the feedforward's row with the four functions that carry the motor's parameters.

    These are acceleration, speed w and tanh(K w) of the motor along the reference, and 1.
    """
    plain, rows = feedforward_generator(chain, flat, interval), flat_map(flat)
    width, before = len(rows), len(plain.output)
    functions = np.zeros((4, plain.output.shape[1]))
    functions[:2, -width:] = rows[:, [-1, -2]].T  # of the last stage, whose filters have been passed
    sign = np.array([[1.0, FRICTION_SLOPE]]), np.array([[before + 2, before + 1]])
    return plain._replace(
        output=np.vstack((plain.output, functions)),
        constant=np.concatenate((plain.constant, [0.0, 0.0, 0.0, 1.0])),
        friction=np.vstack((plain.friction, sign[0])),
        places=np.vstack((plain.places, sign[1])),
    )
