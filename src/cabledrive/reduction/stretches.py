r"""Modes along and across whose only nonlinearity is that of stretches: one model, its numbers for a step.

With q the amplitudes of longitudinal modes (unit modal mass) and a those of transverse modes, which lie in
rows b, one for each stretch of cable and plane, the energy of chapter 2 is that of linear modes and

.. math::
    V = \sum_k \big(q_k Q_k + \tfrac12 s_k Q_k^2\big) + \tfrac12\sum_{cd} N_{cd} P_c P_d, \qquad
    Q_k = L_k^T a + \tfrac12 a^T G_k a, \quad P_c = l_c^T a + \tfrac12 a^T D_c a.

:math:`Q_k` is the force of the transverse motion on mode k, :math:`P_c` twice the length that row b takes up
of strand c, of which it has n; :math:`s_k` and N let the modes that are not kept, or follow, give way without
inertia. G and D couple modes of one row alone; where they are diagonal, each sine then being by itself, so
are the arrays, and n is one.

One step h is half a kick by the forces of V and of the torque, the exact flow of the damped linear modes,
half a kick (Strang), Eq. (R.4):

.. math:: \dot x \leftarrow \dot x + \tfrac12 h f(x), \qquad
          (x, \dot x) \leftarrow e^{Ah}(x, \dot x), \qquad
          A = \begin{pmatrix}0 & 1\\ -W^2 & -C\end{pmatrix},

so that every linear frequency and decay is exact at any step; the coupling is of second order.
"""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from typing import NamedTuple, TypeVar

import numpy as np

from cabledrive.parameters.arrays import Array, Integers

LANES = 100
"""Members of an ensemble that a thread steps together: as many as the processor's fast memory holds."""

Key = TypeVar("Key")


class StretchModel(NamedTuple):
    """Modes along (k), followers (f), rows (b) of up to m modes across, motions shown (o), tensions (x).

    Followers are forces of motors, then of friction, and strain as further modes would: what holds behind the
    kept modes.
    """

    natural: Array  # (k,): longitudinal frequencies W [rad/s]; 0: rigid motion
    damping: Array  # (k, k): modal damping C [1/s]
    torque_shape: Array  # (k,) or, of each motor, (k, i): modal force per torque [kg^-1/2 / m]
    motions: Array  # (o, k): motions shown per modal amplitude
    transverse: Array  # (b, m): transverse frequencies [rad/s]
    mass: Array  # (b, m): their modal masses [kg]
    loss: Array  # (b, m): their damping [1/s]
    sag: Array  # (b, m): amplitudes about which they vibrate [m]
    coupling: Array  # (k + f, b, m) or (k + f, b, m, m): G [N/m^2 kg^-1/2]
    square: Array  # (b, m) or (b, n, m, m): D [1/m]
    carried: Array  # (b n, b n): N [N/m]
    probes: Array  # (b, m, points): displacement at watched points per amplitude
    rest: Array = np.zeros(0)  # (x,): tensions at rest [N]
    tension: Array = np.zeros((0, 0))  # (x, k + f): tensions per modal amplitude [N/m kg^-1/2]
    raised: Array = np.zeros((0, 0))  # (x, b n): tensions per P [N/m]
    slopes: Array = np.zeros(0)  # (m,): slope per amplitude, for the limit of steepness [1/m]
    steepest: float = 0.0  # largest slope for which the model holds [-]
    highest: float = np.inf  # up to which frequency the model goes [rad/s]
    # where G and D are full; else L, l and s are zero
    direct: Array = np.zeros((0, 0, 0))  # (k + f, b, m): L [N/m kg^-1/2]
    bend: Array = np.zeros((0, 0, 0))  # (b, n, m): l [-]
    softness: Array = np.zeros(0)  # (k,): s [s^2]
    shoved: Array = np.zeros((0, 0, 0))  # (b, m, f): force on a mode across per force of each follower
    # of what rubs by Coulomb's law
    friction: Array = np.zeros(0)  # (s,): force or torque [N], [N m]
    friction_shape: Array = np.zeros((0, 0))  # (s, k): motion against it [kg^-1/2]


class StretchNumbers(NamedTuple):
    """The model, and what a step of one length needs besides; i inputs are held over a sample."""

    model: StretchModel
    steps: int  # steps in a sample
    step: float  # length of a step [s]
    along: Array  # (2k, 2k): exact flow of the modes over a step, amplitudes then rates
    push: Array  # (2k, i): what inputs that are held over a step add to them
    across: Array  # (4, b, m): exact flow across: x from x, x from v, v from x, v from v
    per_mass: Array  # (b, m): 1 / mass [1/kg]
    table: (
        Array  # (b, m, (n + k + f) m): where they are full, D and then G of each mode, in one row of a loop
    )
    glide: Array  # (s, 2k): mean speed of what rubs over a step, per amplitude and rate
    give: Array  # (s,): the same per impulse [1/kg]


class StretchState(NamedTuple):
    """Amplitudes then rates (2k,); rows, their rates and accelerations (b, m); what follows is scratch."""

    modes: Array
    sines: Array
    rates: Array
    pull: Array
    holds: Integers  # (1,): whether the model holds
    fresh: Array
    force: Array  # (k,): modal
    stiffening: Array
    stretched: Array  # (b n,): P [m]
    held: Array  # (f,): forces of the followers [N], [N m]
    rubbed: Array  # (s,): friction of the last step [N], [N m]
    products: Array


def linear_flow(natural: Array, damping: Array | float, step: float) -> Array:
    """Exact flow over a step [s], (4, ...): place from place and from rate, rate from place and from rate."""
    root = np.sqrt((natural**2 - 0.25 * damping**2).astype(complex)) * step
    decay = np.exp(-0.5 * damping * step)
    turn = decay * np.cos(root).real
    push = decay * step * np.sinc(root / np.pi).real
    return np.array([turn + 0.5 * damping * push, push, -(natural**2) * push, turn - 0.5 * damping * push])


def numbers_of(
    model: StretchModel, step: float, *, steps: int = 1, inputs: Array | None = None
) -> StretchNumbers:
    """Prepare an integration with one step length [s]; ``inputs``, shape (k, i): modal force per input."""
    from scipy.linalg import expm

    k, forces = model.natural.size, np.zeros((model.natural.size, 0)) if inputs is None else inputs
    scale = max(model.natural.max(initial=0.0), 1.0 / step)  # rates in this unit: rounding is even
    rates = np.zeros((2 * k + forces.shape[1],) * 2)
    rates[:k, k : 2 * k] = scale * np.eye(k)
    rates[k : 2 * k] = np.hstack((-np.diag(model.natural**2) / scale, -model.damping, forces / scale))
    flow = expm(rates * step)[: 2 * k]
    flow[k:] *= scale
    flow[:, k : 2 * k] /= scale
    along, rows, most = np.ascontiguousarray(flow[:, : 2 * k]), *model.sag.shape
    shafts = model.friction_shape if model.friction.size else np.zeros((0, k))
    glide = shafts @ (along[:k] - np.eye(k, 2 * k)) / step
    table = np.zeros((rows, most, 0))
    if model.coupling.ndim == 4:
        table = np.concatenate([model.square.swapaxes(0, 1), model.coupling]).transpose(1, 3, 0, 2)
        table = table.reshape(rows, most, table.shape[2] * most)
    return StretchNumbers(
        model=model,
        steps=steps,
        step=step,
        along=along,
        push=np.ascontiguousarray(flow[:, 2 * k :]),
        across=linear_flow(model.transverse, model.loss, step),
        per_mass=1.0 / model.mass,
        table=table,
        glide=glide,
        give=np.maximum(np.einsum("sk,sk->s", glide[:, k:], shafts), 1e-300),
    )


def new_stretch_state(numbers: StretchNumbers) -> StretchState:
    """A cable at rest and straight."""
    model, size, shape = numbers.model, len(numbers.along), numbers.model.sag.shape
    return StretchState(
        modes=np.zeros(size),
        sines=np.zeros(shape),
        rates=np.zeros(shape),
        pull=np.zeros(shape),
        holds=np.zeros(1, dtype=np.int64),
        fresh=np.zeros(size),
        force=np.zeros(size // 2),
        stiffening=np.zeros(shape[1]),
        stretched=np.zeros(len(model.carried)),
        held=np.zeros(max(len(model.direct) - size // 2, 0)),
        rubbed=np.zeros(model.friction.size),
        products=np.zeros((shape[0], numbers.table.shape[2])),
    )


def in_lanes(
    work: Callable[[Key, list[int]], None], members: Iterable[tuple[Key, Sequence[int]]], threads: int | None
) -> None:
    """Run the members of an ensemble, those of each model together, `LANES` at a time.

    ``work``: takes the model's key and the numbers of some of its members, and keeps what comes of them;
    ``threads``: unless given, one per processor.
    """
    parts = [(key, own[i : i + LANES]) for key, own in members for i in range(0, len(own), LANES)]
    with ThreadPoolExecutor(max_workers=threads or cpu_count() or 1) as pool:
        list(pool.map(lambda part: work(part[0], list(part[1])), parts))
