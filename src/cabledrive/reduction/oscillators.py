r"""The model of internal resonance as oscillators in time, one or thousands of parameter sets.

One step is half a kick, the exact flow of the damped linear oscillators, half a kick; the kick is

.. math::
    \Delta\dot q &= h\Big(\frac{\phi_\tau\tau/r_1 - c_{12}v - \sum_j G_j a_j^2}{M}\Big), \qquad
    \Delta v = h\,\frac{\tau/r_1 - c_{11}v - c_{12}\dot q}{M_0} \\
    \Delta\dot a_j &= -\frac{h}{m_j}\Big(2G_j q + \sum_k N_{jk}a_k^2\Big)a_j. \qquad \text{Eq. (A.20)}

Frequencies and decays are exact at any step; the coupling is of second order.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array, Complex
from cabledrive.reduction import ensemble_kernels as k
from cabledrive.reduction.autoparametric import AutoparametricModel
from cabledrive.reduction.averaging import AveragedCoefficients
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


def integrate_oscillators_reference(
    c: OscillatorCoefficients, plucks: Array, steps: int, stride: int
) -> Array:
    """Readable twin of the compiled integrator, for any number of transverse modes and lanes.

    From plucks [m], shape (J, ...), at rest; returns q, v, a every ``stride`` steps, (records, 2 + J, ...).
    """
    a = np.array(plucks, dtype=float)
    b, q, p, v = np.zeros_like(a), np.zeros(a.shape[1:]), np.zeros(a.shape[1:]), np.zeros(a.shape[1:])
    records = []
    for n in range(steps + 1):
        if n % stride == 0:
            records.append(np.concatenate((q[None], v[None], a)))
        h = (0.5 if n in (0, steps) else 1.0) * c.step
        wave = np.sin(n * c.turn)
        q_force = c.force * wave - c.cross * v - np.sum(c.push * a**2, axis=0)
        v_force = c.rigid_force * wave - c.rigid_decay * v - c.rigid_cross * p
        b = b - h * (c.pump * q + np.einsum("jk...,k...->j...", c.cubic, a**2)) * a
        p, v = p + h * q_force, v + h * v_force
        if n < steps:
            q, p = c.along[0] * q + c.along[1] * p, c.along[2] * q + c.along[3] * p
            a, b = c.across[0] * a + c.across[1] * b, c.across[2] * a + c.across[3] * b
    return np.array(records)


AVERAGED_STEP = 4e-3
"""Step of the averaged equations [s]: rates stay below some 30 rad/s there."""


class Largest(NamedTuple):
    """What an ensemble has reached."""

    pulley: Array  # (lanes,): largest q, either way [m]
    spans: Array  # (J, lanes): largest amplitude a of each section [m]
    state: NDArray[np.generic]  # at the end: slow amplitudes, complex, or q and a, shape (1 + J, lanes)


def averaged_ensemble(
    c: AveragedCoefficients, start: Complex, duration: float, *, threads: int = 2
) -> Largest:
    """Largest amplitudes of many parameter sets by the averaged equations of first order.

    ``c``: of one or two sections in one plane, with lanes; more are refused; ``start``, shape (1 + J, lanes):
    slow amplitudes at t = 0 [m]; ``duration`` [s].
    """
    lanes, steps = _lanes_of(start), _steps(duration, AVERAGED_STEP)
    h = duration / steps
    two = _two(c.pump.shape[0])
    cells = _cells(k.AVERAGED_ROWS, lanes)
    put = _Filler(cells, lanes)
    rows: dict[int, ArrayLike] = {
        k.DAMP: 0.5 * c.damping,
        k.TUNE: c.detuning,
        k.FORCE_RE: c.force.real,
        k.FORCE_IM: c.force.imag,
    }
    rows |= {k.DECAY: 0.5 * c.transverse_damping, k.DRIFT_KEPT: np.exp(-0.5 * h * c.drift_decay)}
    rows |= {k.PASSIVE_KEPT: np.exp(-0.5 * h * c.transverse_damping), k.DRIFT: 1.0, k.PASSIVE: 1.0}
    bare = 0.5 * c.cubic - c.static
    stiffened = np.einsum("jk...,k...->j...", bare, c.passive)
    columns = (
        (k.TUNE_1, c.transverse_detuning),
        (k.BACK_1, c.feedback),
        (k.PUMP_1, c.pump),
        (k.DRIFT_1, c.drift),
    )
    for row, values in (*columns, (k.PASSIVE_1, stiffened)):
        rows |= {row + j: values[j] for j in two}
    rows |= {k.BARE_11 + 2 * i + j: bare[i, j] for i in two for j in two}
    rows |= {k.QUARTER_11 + 2 * i + j: 0.25 * c.cubic[i, j] for i in two for j in two}
    rows |= {k.Q_RE: start[0].real, k.Q_IM: start[0].imag, k.MOST_Q: np.abs(start[0]) ** 2}
    for j in two:
        z = start[1 + j]
        rows |= {k.A_RE + 2 * j: z.real, k.A_IM + 2 * j: z.imag, k.MOST_A + j: np.abs(z) ** 2}
    put.all(rows)
    _on_threads(lambda a, b: k.integrate_averaged(cells, a, b, steps, h), put.blocks, threads)
    complex_rows = [k.Q_RE, *(k.A_RE + 2 * j for j in two)]
    state = np.array([put.row(row) + 1j * put.row(row + 1) for row in complex_rows])
    spans = np.sqrt([put.row(k.MOST_A + j) for j in two])
    return Largest(np.sqrt(put.row(k.MOST_Q)), spans, state)


def oscillator_ensemble(
    c: OscillatorCoefficients, plucks: ArrayLike, steps: int, *, threads: int = 2
) -> Largest:
    """Largest displacements of many parameter sets by the oscillators themselves.

    ``c``: of one or two sections in one plane, with lanes; more are refused; ``plucks``, shape (J, lanes):
    amplitudes at t = 0, at rest [m]; ``steps``: of the length in `c`.
    """
    start = np.asarray(plucks, dtype=float)
    lanes, two = _lanes_of(start), _two(c.push.shape[0])
    cells = _cells(k.OSCILLATOR_ROWS, lanes)
    put = _Filler(cells, lanes)
    rows: dict[int, ArrayLike] = {
        k.THRUST: c.force,
        k.RIGID_THRUST: c.rigid_force,
        k.CROSS: c.cross,
        k.STEP: c.step,
    }
    rows |= {k.RIGID_DECAY: c.rigid_decay, k.RIGID_CROSS: c.rigid_cross, k.COS: 1.0}
    rows |= {k.TURN_COS: np.cos(c.turn), k.TURN_SIN: np.sin(c.turn)}
    for part in range(4):
        rows |= {k.QQ + part: c.along[part]}
        rows |= {k.AA_1 + 4 * j + part: c.across[part, j] for j in two}
    rows |= {k.PUSH_1 + j: c.push[j] for j in two} | {k.LIFT_1 + j: c.pump[j] for j in two}
    rows |= {k.CUBE_11 + 2 * i + j: c.cubic[i, j] for i in two for j in two}
    rows |= {k.A + 2 * j: start[j] for j in two}
    put.all(rows)
    _on_threads(lambda a, b: k.integrate_oscillators(cells, a, b, steps), put.blocks, threads)
    state = np.array([put.row(row) for row in (k.PLACE, *(k.A + 2 * j for j in two))])
    return Largest(put.row(k.TOP_Q), np.array([put.row(k.TOP_A + j) for j in two]), state)


class _Filler:
    """Puts rows of lanes into cells and takes them out."""

    def __init__(self, cells: Array, lanes: int) -> None:
        self.blocks = cells.size // k.LANES
        self._lanes = lanes
        self._cells = cells

    def all(self, rows: dict[int, ArrayLike]) -> None:
        shaped = self._shaped
        self.blocks = shaped.shape[0]
        full = np.zeros(shaped.shape[0] * k.LANES)
        for row, values in rows.items():
            full[: self._lanes] = values
            shaped[:, row] = full.reshape(-1, k.LANES)

    def row(self, row: int) -> Array:
        return self._shaped[:, row].reshape(-1)[: self._lanes].copy()

    @property
    def _shaped(self) -> Array:
        blocks = -(-self._lanes // k.LANES)
        return self._cells.reshape(blocks, -1, k.LANES)


def _cells(rows: int, lanes: int) -> Array:
    return np.zeros(-(-lanes // k.LANES) * rows * k.LANES)


def _lanes_of(start: NDArray[np.generic]) -> int:
    if start.ndim != 2:
        raise InputRefused(f"start has {start.ndim} axes, an ensemble needs 2: amplitudes and lanes")
    return int(start.shape[1])


def _two(modes: int) -> range:
    if modes > 2:
        raise InputRefused(f"{modes} transverse modes, but an ensemble takes at most 2: leave the others out")
    return range(modes)


def _steps(duration: float, step: float) -> int:
    if not duration > 0.0:
        raise InputRefused(f"duration = {duration:.6g} s must be positive")
    return int(np.ceil(duration / step - 1e-9))


def _on_threads(work: Callable[[int, int], None], blocks: int, threads: int) -> None:
    edges = np.linspace(0, blocks, max(1, threads) + 1).astype(int)
    with ThreadPoolExecutor(max(1, threads)) as pool:
        list(pool.map(work, edges[:-1].tolist(), edges[1:].tolist()))
