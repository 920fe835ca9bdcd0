"""A lumped chain as seen from its first shaft: every link between equal angles."""

from dataclasses import replace

import numpy as np

from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain


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
