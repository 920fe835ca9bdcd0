r"""Marching the uniform-tension model: exact linear flow, nonlinear kicks.

One step h is half a kick, the exact flow of the damped linear system, half a kick (Strang), Eq. (R.4):

.. math:: \dot x \leftarrow \dot x + \tfrac12 h f(x), \qquad
          (x, \dot x) \leftarrow e^{Ah}(x, \dot x), \qquad
          A = \begin{pmatrix}0 & 1\\ -W^2 & -C\end{pmatrix},

so that every linear frequency and decay is exact at any step; the coupling is of second order.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.reduction.uniform_tension import UniformTensionModel

Array = NDArray[np.float64]


class Coefficients(NamedTuple):
    """What a step needs, for one step length: arrays only, so that a kernel takes one argument.

    Attributes
    ----------
    along : ndarray, shape (2 k, 2 k)
        Exact flow of the longitudinal modes, amplitudes then rates, Eq. (R.4).
    across : ndarray, shape (4, m)
        Exact flow of the sines: x from x, x from v, v from x, v from v.
    torque_shape : ndarray, shape (k,)
        Modal force per torque.
    coupling : ndarray, shape (k, 2, m)
        G of (R.3).
    per_mass : float
        2 / m_t [1/kg].
    carried : ndarray, shape (m,)
        carrier kappa^2, tension stiffening per S [1/(m s^2)].
    stretching : ndarray, shape (m,)
        kappa^2 Le / 4, S per squared amplitude [1/m].
    gravity_load : ndarray, shape (2, m)
        Modal acceleration by gravity in w.
    midspan : ndarray, shape (m,)
        Value of each sine at midspan.
    tension_along : ndarray, shape (k, 2)
        Tension of each span per longitudinal amplitude [N kg^1/2].
    tension_across : float
        Tension per S [N/m].
    """

    along: Array
    across: Array
    torque_shape: Array
    coupling: Array
    per_mass: float
    carried: Array
    stretching: Array
    gravity_load: Array
    midspan: Array
    tension_along: Array
    tension_across: float


def coefficients(model: UniformTensionModel, step: float) -> Coefficients:
    """Prepare a march with one step length.

    Parameters
    ----------
    model : UniformTensionModel
    step : float
        Step length h [s].

    Returns
    -------
    Coefficients
    """
    from scipy.linalg import expm

    m = np.arange(1, model.transverse.size + 1)
    zero, one = np.zeros_like(model.damping), np.eye(model.natural.size)
    system = np.block([[zero, one], [-np.diag(model.natural**2), -model.damping]])
    return Coefficients(
        along=expm(system * step),
        across=_flow(model.transverse, np.full(m.size, model.transverse_damping), step),
        torque_shape=model.torque_shape,
        coupling=model.coupling,
        per_mass=2.0 / model.transverse_mass,
        carried=model.carrier * model.wave_numbers**2,
        stretching=0.25 * model.wave_numbers**2 * model.span,
        gravity_load=model.gravity_load,
        midspan=np.sin(0.5 * np.pi * m),
        tension_along=model.stiffness / model.span * model.stretch,
        tension_across=model.axial_rigidity / model.span,
    )


def _flow(natural: Array, damping: Array, step: float) -> Array:
    """Exact flow of damped oscillators over one step, shape (4, n)."""
    root = np.sqrt((natural**2 - 0.25 * damping**2).astype(complex)) * step
    decay = np.exp(-0.5 * damping * step)
    turn = decay * np.cos(root).real
    push = decay * step * np.sinc(root / np.pi).real
    return np.array([turn + 0.5 * damping * push, push, -(natural**2) * push, turn - 0.5 * damping * push])


def march_reference(c, q, p, a, b, torque, h, stride):
    """Readable twin of the compiled march.

    Parameters
    ----------
    c : Coefficients
    q, p : ndarray, shape (k,)
        Longitudinal amplitudes and their rates; changed in place.
    a, b : ndarray, shape (planes, 2, m)
        Transverse amplitudes of planes w (and v) and their rates; changed in place.
    torque : ndarray, shape (steps + 1,)
        At the ends of the steps [N m].
    h : float
        Step [s].
    stride : int
        Steps between two recorded instants.

    Returns
    -------
    longitudinal : ndarray, shape (records, k)
    midspan : ndarray, shape (records, planes, 2)
    tension : ndarray, shape (2,)
        Lowest tension above the pretension of each span over all steps [N].
    """
    steps = torque.size - 1
    along, across = [], []
    lowest = np.full(2, np.inf)
    for n in range(steps + 1):
        stretched = np.einsum("pjm,m->j", a**2, c.stretching)
        lowest = np.minimum(lowest, q @ c.tension_along + c.tension_across * stretched)
        if n % stride == 0:
            along.append(q.copy())
            across.append(a @ c.midspan)
        stiffening = c.per_mass * np.einsum("k,kjm->jm", q, c.coupling) + stretched[:, None] * c.carried
        force = c.torque_shape * torque[n] - np.einsum("kjm,pjm->k", c.coupling, a**2)
        pull = -stiffening * a
        pull[0] += c.gravity_load
        weight = 0.5 if n in (0, steps) else 1.0
        p += weight * h * force
        b += weight * h * pull
        if n < steps:
            q[:], p[:] = np.split(c.along @ np.concatenate((q, p)), 2)
            a[:], b[:] = c.across[0] * a + c.across[1] * b, c.across[2] * a + c.across[3] * b
    return np.array(along), np.array(across), lowest


def march_kernel(c, q, p, a, b, torque, h, stride):
    """Arithmetic of the march, compiled by `march`; arguments and results as `march_reference`."""
    steps = torque.size - 1
    longitudinal = q.size
    planes, spans, sines = a.shape
    records = steps // stride + 1
    along = np.empty((records, longitudinal))
    across = np.empty((records, planes, spans))
    lowest = np.full(spans, np.inf)
    stretched = np.empty(spans)
    force = np.empty(longitudinal)
    kicked = np.empty(2 * longitudinal)
    stiffening = np.empty(sines)
    for n in range(steps + 1):
        weight = 0.5 * h if n == 0 or n == steps else h
        record = n // stride if n % stride == 0 else -1
        for k in range(longitudinal):
            force[k] = c.torque_shape[k] * torque[n]
            if record >= 0:
                along[record, k] = q[k]
        for j in range(spans):
            total = 0.0
            for plane in range(planes):
                middle = 0.0
                for m in range(sines):
                    total += c.stretching[m] * a[plane, j, m] ** 2
                    middle += c.midspan[m] * a[plane, j, m]
                if record >= 0:
                    across[record, plane, j] = middle
            stretched[j] = total
            tension = c.tension_across * total
            for m in range(sines):
                stiffening[m] = total * c.carried[m]
            for k in range(longitudinal):
                tension += q[k] * c.tension_along[k, j]
                drive = c.per_mass * q[k]
                pumped = 0.0
                for m in range(sines):
                    stiffening[m] += drive * c.coupling[k, j, m]
                for plane in range(planes):
                    for m in range(sines):
                        pumped += c.coupling[k, j, m] * a[plane, j, m] ** 2
                force[k] -= pumped
            lowest[j] = min(lowest[j], tension)
            for plane in range(planes):
                for m in range(sines):
                    load = c.gravity_load[j, m] if plane == 0 else 0.0
                    x = a[plane, j, m]
                    v = b[plane, j, m] + weight * (load - stiffening[m] * x)
                    if n < steps:
                        a[plane, j, m] = c.across[0, m] * x + c.across[1, m] * v
                        v = c.across[2, m] * x + c.across[3, m] * v
                    b[plane, j, m] = v
        for k in range(longitudinal):
            kicked[k] = q[k]
            kicked[longitudinal + k] = p[k] + weight * force[k]
            p[k] = kicked[longitudinal + k]
        if n < steps:
            for k in range(longitudinal):
                q[k] = 0.0
                p[k] = 0.0
                for i in range(2 * longitudinal):
                    q[k] += c.along[k, i] * kicked[i]
                    p[k] += c.along[longitudinal + k, i] * kicked[i]
    return along, across, lowest


@cache
def _compiled() -> Any:
    import numba

    return numba.njit(cache=True, fastmath={"contract", "reassoc", "nsz", "arcp"}, error_model="numpy")(
        march_kernel
    )


def march(
    c: Coefficients, q: Array, p: Array, a: Array, b: Array, torque: Array, h: float, stride: int
) -> tuple[Array, Array, Array]:
    """March the model, Eqs. (R.1), (R.2) by (R.4).

    Parameters
    ----------
    c : Coefficients
        For the step `h`.
    q, p : ndarray, shape (k,)
        Longitudinal amplitudes [m kg^1/2] and rates at the start; at the end of the march on return.
    a, b : ndarray, shape (planes, 2, m)
        Transverse amplitudes [m] and rates, planes w (and v).
    torque : ndarray, shape (steps + 1,)
        At the ends of the steps [N m].
    h : float
        Step [s].
    stride : int
        Steps between two recorded instants.

    Returns
    -------
    longitudinal : ndarray, shape (records, k)
    midspan : ndarray, shape (records, planes, 2)
        Displacement at midspan [m].
    tension : ndarray, shape (2,)
        Lowest change of tension in each span over the march [N].
    """
    along, across, lowest = _compiled()(c, q, p, a, b, torque, h, stride)
    return along, across, lowest
