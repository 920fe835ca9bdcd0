r"""The table of rows: weights of waves, masses, springs and inner modes, their bands, forms and counts.

A part of a network is a table of constant rows b, each of which strains, moves or bends something. The exact
dynamic stiffness over the frequency is the sum of their weighted squares, and so is minus its derivative:

.. math:: \hat K(\omega) = \sum_r w_r(\omega)\,b_r^H b_r, \qquad
          -\hat K' = \sum_r w'_r(\omega)\,b_r^H b_r > 0, \qquad
          w = \tfrac12 Z\,(t + 1/t),\; -Z t,\; -\omega a,\; a/\omega,\; -\frac{a\,\omega^3}{b^2 - \omega^2}
          \qquad \text{Eq. (M.1)}

for the stretch and for each end of a wave, :math:`t = \tan(\omega\tau/2)`, for a mass, for a spring, and for
a mode between held ends. Ropes that run and hang have :math:`\pm a` for what their momentum turns, and
:math:`-a\,\omega^2/(b - \omega)` for a mode of waves of one way, of the other one with b below zero. A wave
along a rope of curvature :math:`\kappa` far above its ring frequency :math:`\omega_r = c\kappa` has
:math:`Z s` and :math:`\tau/s` in place of Z and :math:`\tau`, with :math:`s^2 = 1 + \omega_r^2/\omega^2`:
the rope across gives way by its inertia alone. Nothing below knows strings, beams or sag. All is done for
many frequencies at once, the lanes; each may be of a machine of its own, with other numbers in the same rows.
"""

from math import pi
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from cabledrive.modal.runs import Run, eliminated, solved_run, solved_whole
from cabledrive.parameters.errors import NotComputed

Array = NDArray[np.float64]
Integers = NDArray[np.intp]

MASS, SPRING, POLE, TURN, ONE_WAY = range(5)
"""Kinds of the rows behind those of the waves."""

GROWTH = 1e4
"""How far the terms of an elimination may outgrow the matrix before its signs are in doubt."""

STEADY = 1e2
"""The same of runs, whose terms meet in few pivots."""

STEPS, CONVERGED, STAY = 14, 1e-13, 1e-12
"""Steps of a refinement, the shift at which it ends, and how far it may leave its bracket, both relative."""

TOGETHER = 500_000
"""Rows times lanes that are held at a time: what a cache holds."""
FEW = 16
"""Unknowns up to which many matrices are solved in one call."""


class Table(NamedTuple):
    """One part, ready for frequencies up to some top.

    Waves (m parts): rows 3i, 3i+1, 3i+2 are stretch, near end, far end; ``part`` 0: whole, 1 and 2: before
    and behind the cut of a long one, at an antinode that moves with the frequency. ``z``, ``time`` and ``a``,
    the factors of the fixed rows behind, have a second axis where the lanes are of several machines. Entries
    of row r are ``first[r]:first[r+1]``. ``kinds``: numbers of the fixed rows of each kind; ``rows``: all as
    matrices, of the entries without phase and, if a rope runs, of those with it; ``products``: of their
    pairs, which make the band, entry (j + d, j) in its place j (width + 1) + d; ``runs``: its longest run,
    none where a rope runs.
    """

    z: Array
    time: Array
    lag: Array
    ring: Array
    part: Integers
    kind: Integers
    a: Array
    b: Array
    first: Integers
    column: Integers
    value: NDArray[Any]
    kinds: tuple[tuple[int, Integers], ...]
    rows: tuple[Any, ...]
    products: tuple[Any, ...]
    runs: tuple[Run, ...]
    size: int
    width: int

    @property
    def running(self) -> bool:
        """Whether a rope runs, so that shapes are complex."""
        return len(self.rows) > 1


class Lanes(NamedTuple):
    """Frequencies [rad/s], each with where the long waves are cut, and the machine that it belongs to."""

    omega: Array
    placed: Array
    machine: Integers

    def take(self, chosen: slice) -> "Lanes":
        """Some of them."""
        return Lanes(self.omega[chosen], self.placed[chosen], self.machine[chosen])


def lanes_at(omega: Any, machine: Any = 0) -> Lanes:
    """Lanes with the cuts at their own frequencies."""
    omega = np.atleast_1d(np.asarray(omega, dtype=float))
    return Lanes(omega, omega, np.broadcast_to(np.asarray(machine, dtype=np.intp), omega.shape))


def part_times(t: Table, lanes: Lanes) -> tuple[Array, Array]:
    r"""Travel time of each part of a wave, and the modes that the parts hide, shapes (m, lanes), (lanes,).

    With h half turns in :math:`\alpha = \omega\tau`, rounded, the cut
    :math:`\alpha_1 = (\lfloor (h-1)/2 \rfloor + \tfrac12)\pi + (\alpha - h\pi)/2` leaves
    :math:`|\sin| \ge 1/\sqrt 2` on both sides, Eq. (M.2).
    """
    time = _of(t.time, lanes)
    cut = np.flatnonzero(t.part)
    if not cut.size:
        return time, np.zeros(lanes.omega.size)
    phase = lanes.placed * time[cut]
    if t.ring.any():
        phase = phase / np.sqrt(1.0 + (t.ring[cut, None] / lanes.placed) ** 2)
    half = np.maximum(1.0, np.floor(phase / pi + 0.5))
    share = ((np.floor(0.5 * half - 0.5) + 0.5) * pi + 0.5 * (phase - half * pi)) / phase
    before = (t.part[cut] == 1)[:, None]
    own = time * np.ones(lanes.omega.size)
    own[cut] *= np.where(before, share, 1.0 - share)
    return own, np.sum((half - 1.0) * before, axis=0)


def _of(values: Array, lanes: Lanes) -> Array:
    """Numbers of the lanes' machines, a row for each part."""
    return values[:, lanes.machine] if values.ndim == 2 else values[:, None]


def weights(t: Table, lanes: Lanes, *, rates: bool = True) -> tuple[Array, Array, Array, Array]:
    """Weights of all rows, minus their derivatives, phases of running ropes [s], and hidden modes.

    ``rates``: whether the derivatives are wanted.
    """
    own, hidden = part_times(t, lanes)
    omega, m = lanes.omega, 3 * t.part.size
    w = np.empty((m + t.kind.size, omega.size))
    rate = np.empty_like(w) if rates else w[:0]
    z, time, late = _of(t.z, lanes), own, own[:0]
    if t.running:
        late = t.lag[:, None] * own / _of(t.time, lanes)
    if t.ring.any():
        curved = (t.ring[:, None] / omega) ** 2
        slow = np.sqrt(1.0 + curved)
        z, own, time = z * slow, own / slow, own / slow * (1.0 + curved / slow**2)
    x = np.tan(0.5 * omega * own)
    inverse = 1.0 / x
    w[0:m:3] = 0.5 * z * (x + inverse)
    w[1:m:3] = w[2:m:3] = -z * x
    if rates:
        rate[0:m:3] = 0.5 * w[0:m:3] * time * (inverse - x)
        rate[1:m:3] = rate[2:m:3] = 0.5 * z * time * (1.0 + x * x)
        if t.ring.any():
            rate[:m] += w[:m] * np.repeat(curved / slow**2, 3, axis=0) / omega
    for kind, rows in t.kinds:
        a, square = _of(t.a[rows], lanes), omega**2
        if kind == MASS:
            w[m + rows], fall = -omega * a, a
        elif kind == SPRING:
            w[m + rows], fall = a / omega, a / square
        elif kind == POLE:
            b = t.b[rows, None] ** 2
            apart = b - square
            w[m + rows] = -a * omega * square / apart
            fall = a * square * (3.0 * b - square) / apart**2
        elif kind == TURN:
            w[m + rows], fall = a * t.b[rows, None], 0.0 * a
        else:
            b, apart = t.b[rows, None], t.b[rows, None] - omega
            w[m + rows] = -a * square / apart
            fall = a * omega * (2.0 * b - omega) / apart**2
        if rates:
            rate[m + rows] = fall
    return w, rate, late, hidden


def bands(t: Table, omega: Array, w: Array, late: Array) -> NDArray[Any]:
    """The bands of the weighted squares, lower half by columns, shape (size, width + 1, lanes)."""
    flat = t.products[0] @ w
    if t.running:
        turn = _turns(t, omega, late)
        flat = flat + t.products[1] @ (w * turn) + t.products[2] @ (w * turn.conj())
    return np.asarray(flat).reshape(t.size, t.width + 1, -1)


def _turns(t: Table, omega: Array, late: Array) -> NDArray[np.complex128]:
    """Phase of the delayed entries of each row, shape (rows, lanes)."""
    turn = np.ones((t.first.size - 1, omega.size), dtype=complex)
    turn[: 3 * t.part.size : 3] = np.exp(1j * omega * late)
    return turn


def turned_round(band: NDArray[Any]) -> NDArray[Any]:
    """The same matrices with their unknowns in the opposite order."""
    size, width = band.shape[0], band.shape[1]
    out = np.zeros_like(band)
    for d in range(width):
        out[: size - d, d] = band[: size - d, d][::-1].conj()
    return out


def negative_pivots(band: NDArray[Any]) -> tuple[Array, Array]:
    """Negative pivots of LDL^H of every lane, and how its terms outgrow the matrix."""
    size, width, lanes = band.shape[0], band.shape[1] - 1, band.shape[2]
    whole = np.zeros((size + width, 2 * width + 1, lanes), band.dtype)  # before the diagonal: not read
    whole[:size, width:] = band
    row, place, lane = whole.strides
    behind = as_strided(whole[1:, width:], (size - 1, width, width, lanes), (row, row - place, place, lane))
    less = np.empty((width, width, lanes), band.dtype)
    for own, square in zip(whole[:, width:], behind, strict=False):  # of each the square of the next ones
        column = own[1:]
        across = column.conj() if np.iscomplexobj(column) else column
        square -= np.multiply(across[:, None], column / own[0].real, out=less)
    pivot, terms = whole[:size, width].real, np.zeros((size, lanes))
    for d in range(1, width + 1):
        terms[d:] += np.abs(whole[: size - d, width + d]) ** 2 / np.abs(pivot[: size - d])
    return (pivot < 0.0).sum(axis=0), terms.max(axis=0) / np.abs(band[:, 0]).max(axis=0)


def zero_pivots(t: Table, band: NDArray[Any], least: float) -> tuple[int, bool]:
    """Pivots of LDL^H of one band that are zero, to a share of the diagonal; whether one is negative."""
    diagonal, before = np.abs(band[:, 0]), False
    for run in t.runs[:1]:
        (matrix, *_), negative, growth = eliminated(run, band[..., None])
        if growth[0] <= STEADY:
            before, diagonal = bool(negative[0]), diagonal[run.kept]
            band = np.array([np.pad(own[i:], (0, i)) for i, own in enumerate(matrix[0])])
    size, width, zero = band.shape[0], band.shape[1] - 1, 0
    for k in range(size):
        pivot = float(band[k, 0].real)
        if abs(pivot) <= least * diagonal[k]:
            zero += 1
            continue
        if before or pivot < 0.0:
            return zero, True
        m = min(width, size - 1 - k)
        for j in range(m):
            if band[k, 1 + j] != 0.0:
                band[k + 1 + j, : m - j] -= band[k, 1 + j : 1 + m] / pivot * band[k, 1 + j].conj()
    return zero, before


def counted(t: Table, lanes: Lanes) -> Array:
    r"""Modes below each lane's frequency, rigid ones included, Eq. (M.5).

    W. H. Wittrick and F. W. Williams, Quart. J. Mech. Appl. Math. 24 (1971) 263: the negative pivots of the
    elimination, of long runs first, and the modes that the cuts hide between held ends. Where round-off
    clouds the signs, in the order of the band, from its other end, then both with more digits, then by
    eigenvalues.
    """
    if lanes.omega.size > (most := max(1, TOGETHER // t.first.size)):
        parts = range(0, lanes.omega.size, most)
        return np.concatenate([counted(t, lanes.take(slice(first, first + most))) for first in parts])
    with np.errstate(all="ignore"):
        w, _, late, hidden = weights(t, lanes, rates=False)
        band = bands(t, lanes.omega, w, late)
        found, bad, wide = np.zeros(hidden.shape), np.arange(hidden.size), np.result_type(band, np.longdouble)
        for run in t.runs:
            (matrix, *_), pivots, growth = eliminated(run, band[..., bad])
            # eigenvalues of what is left, which a double mode does not trouble
            matrix = np.where(np.isfinite(matrix), matrix, 0.0)
            found[bad] = hidden[bad] + pivots + (np.linalg.eigvalsh(matrix) < 0.0).sum(axis=1)
            bad = bad[~(growth <= STEADY)]
            if not bad.size:
                return found
        for kind, turned in ((band.dtype, False), (band.dtype, True), (wide, False), (wide, True)):
            own = band[..., bad].astype(kind, copy=False)
            negative, growth = negative_pivots(turned_round(own) if turned else own)
            found[bad] = negative + hidden[bad]
            bad = bad[~(growth <= GROWTH * np.finfo(band.dtype).eps / np.finfo(kind).eps)]
            if not bad.size:
                return found
        from scipy.linalg import eigvals_banded  # few machines wait for it

        for lane in bad:
            try:
                values = eigvals_banded(band[..., lane].T, lower=True)
            except (np.linalg.LinAlgError, ValueError):  # the second of what is not finite
                raise NotComputed("modes cannot be counted: stiffness and mass lie too far apart") from None
            found[lane] = int(np.sum(values < 0.0)) + hidden[lane]
    return found


def dense(band: NDArray[Any]) -> NDArray[Any]:
    """The whole matrices of bands, shape (..., size, size) of (size, width + 1, ...)."""
    size, number = band.shape[0], np.arange(band.shape[0])
    full = np.zeros((size, size, *band.shape[2:]), band.dtype)
    for d, own in zip(range(size), band.swapaxes(0, 1), strict=False):
        full[number[d:], number[: size - d]] = own[: size - d]
        full[number[: size - d], number[d:]] = own[: size - d].conj()
    return np.moveaxis(full, (0, 1), (-2, -1))


def solved(band: NDArray[Any], x: NDArray[Any], runs: tuple[Run, ...] = ()) -> NDArray[Any]:
    """Solve every lane's band for its columns, shape (size, lanes, k); scaled to a largest entry of 1."""
    if band.shape[0] <= FEW:
        out = solved_whole(dense(band), x)
    elif runs:
        left, _, growth = eliminated(runs[0], band, x)
        out, bad = solved_run(runs[0], left, band.shape[0]), np.flatnonzero(~(growth <= STEADY))
        out[:, bad] = _pivoted(band[..., bad], x[:, bad])
    else:
        out = _pivoted(band, x)
    return out / np.abs(out).max(axis=0)


def _pivoted(band: NDArray[Any], x: NDArray[Any]) -> NDArray[Any]:
    """Solve every lane's band with pivots."""
    from scipy.linalg.lapack import dgbsv, zgbsv

    size, width, out = band.shape[0], band.shape[1] - 1, np.empty_like(x)
    solve = zgbsv if np.iscomplexobj(band) else dgbsv
    for lane in range(x.shape[1]):
        general = np.zeros((3 * width + 1, size), band.dtype, order="F")
        for d in range(width + 1):
            column = band[: size - d, d, lane]
            general[2 * width - d, d:] = column.conj()
            general[2 * width + d, : size - d] = column
        _, _, own, singular = solve(width, width, general, x[:, lane])
        if singular:
            general[2 * width] += 1e-16 * np.abs(general[2 * width]).max()
            _, _, own, singular = solve(width, width, general, x[:, lane])
        out[:, lane] = own
    return out


def moved(t: Table, omega: Array, late: Array, x: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Motion of every row, shape (rows, lanes, k), and what running ropes add to its derivative."""
    flat, shape = x.reshape(t.size, -1), (t.first.size - 1, *x.shape[1:])
    y = np.asarray(t.rows[0] @ flat).reshape(shape)
    if not t.running:
        return y, y
    own = np.asarray(t.rows[1] @ flat).reshape(shape) * _turns(t, omega, late)[:, :, None]
    turned = np.zeros_like(own)
    turned[: 3 * t.part.size : 3] = 1j * late[:, :, None] * own[: 3 * t.part.size : 3]
    return y + own, turned


def rate_load(t: Table, omega: Array, w: Array, rate: Array, late: Array, x: NDArray[Any]) -> NDArray[Any]:
    """Minus the derivative of the stiffness times columns, shape (size, lanes, k)."""
    y, turned = moved(t, omega, late, x)
    load = rate[:, :, None] * y
    if not t.running:
        return np.asarray(t.rows[0].T @ load.reshape(load.shape[0], -1)).reshape(x.shape)
    load = load - w[:, :, None] * turned
    more = np.zeros_like(load)
    more[: 3 * t.part.size : 3] = 1j * late[:, :, None] * (w[:, :, None] * y)[: 3 * t.part.size : 3]
    behind = (load + more) * _turns(t, omega, late).conj()[:, :, None]
    flat = [own.reshape(own.shape[0], -1) for own in (load, behind)]
    return np.asarray(t.rows[0].conj().T @ flat[0] + t.rows[1].T @ flat[1]).reshape(x.shape)


def forms(
    t: Table, omega: Array, w: Array, rate: Array, late: Array, x: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Quadratic forms of stiffness and rate, shape (lanes, k, k): sums of squares, nothing cancels."""
    y, turned = moved(t, omega, late, x)
    if y.shape[2] == 1 and not t.running:
        square = y[:, :, 0] ** 2
        both = (np.einsum("rl,rl->l", own, square)[:, None, None] for own in (w, rate))
        return next(both), next(both)
    left = y.transpose(1, 2, 0).conj()
    right = y.transpose(1, 0, 2)
    energy = (left * w.T[:, None, :]) @ right
    fall = (left * rate.T[:, None, :]) @ right
    if t.running:
        crossed = (left * w.T[:, None, :]) @ turned.transpose(1, 0, 2)
        fall = fall - crossed - crossed.transpose(0, 2, 1).conj()
    return energy, fall
