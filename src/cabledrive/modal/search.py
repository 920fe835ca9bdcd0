r"""Every mode of a table of rows: isolated by counting, refined by inverse iteration, proven by counting.

Inverse iteration with Rayleigh and Ritz on :math:`\hat K(\omega)` converges cubically at simple and multiple
modes alike: with :math:`\hat K = V^H \hat K V`, :math:`\hat M = -V^H \hat K' V` of a block V,

.. math:: \hat K z = \sigma \hat M z, \qquad \omega \leftarrow \omega + \bar\sigma, \qquad
          V \leftarrow \hat K(\omega)^{-1} (-\hat K')\,V z. \qquad \text{Eq. (M.6)}

The modes of all brackets take each step together.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.modal.rows import (
    CONVERGED,
    STAY,
    STEPS,
    TOGETHER,
    Array,
    Integers,
    Lanes,
    Table,
    bands,
    counted,
    forms,
    lanes_at,
    rate_load,
    solved,
    weights,
)
from cabledrive.parameters.errors import NotComputed

MULTIPLE = 1e-10
"""Modes closer than this, relative to their frequency, are one mode of higher multiplicity."""

ENCLOSURE = 1e-12
ENCLOSURES = (1e-12, 1e-11, 1e-10, 1e-9, 1e-8)
"""Half-widths, relative, of the interval in which two counts prove a mode: the first that can be had."""

CLUSTER = 1e-6
NEAR = 1e-2
"""Relative width of a bracket of several modes below which they are refined together."""

NARROWEST = 1e-15
"""Relative width of a bracket in which a mode that cannot be proven is given up."""
SLOWEST = 1e-30
"""Phase of the longest wave from which a mode differs from a motion that strains nothing [rad]."""

LARGEST_SHAPES = 20_000_000
"""Numbers of the shapes that are refined together: some hundred megabytes; larger clusters stay unproven."""
MOST_CUTS = 128
_ONE: Integers = np.zeros(1, dtype=np.intp)


class Solved(NamedTuple):
    """One natural frequency of one machine; shapes, shape (size, multiplicity), of unit modal mass."""

    machine: int
    number: int  # of the first of its modes, among those of its machine from 0
    omega: float
    multiplicity: int
    enclosure: float | None
    placed: float
    shapes: NDArray[Any]


class _Brackets(NamedTuple):
    """Intervals [rad/s] with counts at their ends, and the width from which on each is refined."""

    low: Array
    high: Array
    below: Integers
    above: Integers
    machine: Integers
    limit: Array

    def take(self, chosen: Any) -> "_Brackets":
        return _Brackets(*(own[chosen] for own in self))


def searched(
    t: Table,
    band: tuple[Array, Array],
    counts: tuple[Integers, Integers],
    longest: Array,
    *,
    wanted: int | None = None,
) -> list[Solved]:
    """All modes between two frequencies, in any order.

    ``band``: lowest and highest of each machine [rad/s]; ``counts`` there; ``longest``: longest travel time
    of a wave [s]; ``wanted``: stop after so many, a multiple mode whole.
    Raises `NotComputed` if a mode the count promises cannot be found.
    """
    (low, top), (start, end) = band, counts
    machine, least = np.arange(low.size), SLOWEST / np.maximum(longest, SLOWEST)
    queue = _Brackets(low, top, start, end, machine, np.full(low.size, np.inf))
    found: list[Solved] = []
    unproven: dict[tuple[int, int], list[Solved]] = {}
    while queue.low.size:
        modes = queue.above - queue.below
        needed = modes > 0
        if wanted is not None:
            needed &= queue.below - start[queue.machine] < wanted
        queue, modes = queue.take(needed), modes[needed]
        width, times = queue.high - queue.low, longest[queue.machine]
        short = (width * times <= 0.5) | (queue.high * times <= 2.0)
        ready = short & (width <= queue.limit) & ((modes == 1) | (width <= NEAR * queue.high))
        again = [_split(t, queue.take(~ready))]
        if not ready.all():  # all that can be refined is refined together
            again.append(queue.take(ready))
            ready[:] = False
        for m in np.unique(modes[ready]):
            own = queue.take(ready & (modes == m))
            stay = np.ones(own.low.size, dtype=bool)
            together = max(1, TOGETHER // (t.first.size * int(m)))
            parts = (own.take(slice(i, i + together)) for i in range(0, own.low.size, together))
            proven = [one for part in parts for one in _proven(t, part, *refined(t, part, int(m)))]
            for i, solutions in enumerate(proven):  # none where iteration leaves its bracket
                key = (int(own.machine[i]), int(own.below[i]))
                if solutions and all(one.enclosure for one in solutions):
                    found += solutions
                    stay[i] = False
                    continue
                if solutions:
                    unproven[key] = solutions
                if own.high[i] - own.low[i] <= least[own.machine[i]] + NARROWEST * own.high[i]:
                    if key not in unproven:
                        raise NotComputed(
                            f"modes: {m} from {own.low[i]:.15g} to {own.high[i]:.15g} rad/s could not be "
                            "refined"
                        )
                    found += unproven[key]
                    stay[i] = False
            narrower = own.take(stay)
            limit = np.maximum((narrower.high - narrower.low) / 16.0, NARROWEST * narrower.high)
            again.append(narrower._replace(limit=np.maximum(limit, least[narrower.machine])))
        queue = _Brackets(*(np.concatenate(own) for own in zip(*again, strict=True)))
    return found


def modes_between(t: Table, low: float, top: float, below: int, above: int, longest: float) -> list[Solved]:
    """All modes of one machine between two frequencies, ascending; the rest as of `searched`."""
    (start, end), (first, last) = np.array([[low], [top]], dtype=float), np.array([[below], [above]])
    found = searched(t, (start, end), (first, last), np.array([longest], dtype=float))
    return sorted(found, key=lambda own: own.omega)


def _split(t: Table, own: _Brackets) -> _Brackets:
    """Cut every bracket into a few for each of its modes, counted at the cuts."""
    if not own.low.size:
        return own
    cuts = np.minimum(1 + 2 * (own.above - own.below), MOST_CUTS)
    which = np.repeat(np.arange(cuts.size), cuts)
    inside = 1 + np.arange(which.size) - np.repeat(np.cumsum(cuts) - cuts, cuts)
    share = inside / (1.0 + cuts[which])
    places = own.low[which] + share * (own.high - own.low)[which]
    here = counted(t, lanes_at(places, own.machine[which]))
    here = np.clip(here, own.below[which], own.above[which]).astype(np.intp)
    offset = np.cumsum(cuts) - cuts
    apart = which * (1 + int(own.above.max()))  # the count does not fall
    here = np.maximum.accumulate(here + apart) - apart
    low = np.insert(places, offset, own.low)
    below: Integers = np.insert(here, offset, own.below).astype(np.intp)
    ends = np.cumsum(cuts)
    high = np.insert(places, ends, own.high)
    above: Integers = np.insert(here, ends, own.above).astype(np.intp)
    which = np.repeat(np.arange(cuts.size), cuts + 1)
    return _Brackets(low, high, below, above, own.machine[which], own.limit[which])


def _proven(
    t: Table, own: _Brackets, good: NDArray[np.bool_], omegas: Array, shapes: NDArray[Any]
) -> list[list[Solved]]:
    """Group what is closer than round-off can part, and prove each group by counts at both sides."""
    groups: list[tuple[int, Integers]] = []
    for lane in np.flatnonzero(good).tolist():
        if omegas.shape[1] == 1:
            groups.append((lane, _ONE))
            continue
        cuts = np.flatnonzero(np.diff(omegas[lane]) > MULTIPLE * omegas[lane, :-1]) + 1
        for part in np.split(np.arange(omegas.shape[1]), cuts):
            groups.append((lane, part))
    out: list[list[Solved]] = [[] for _ in own.low]
    if not groups:
        return out
    of = np.array([number for number, _ in groups])
    i, j = (np.array([part[end] for _, part in groups]) for end in (0, -1))
    proof = np.zeros(of.size)
    for width in ENCLOSURES:
        left = np.flatnonzero(proof == 0.0)
        if not left.size:
            break
        here = of[left]
        near = omegas[here, i[left]] * (1.0 - width)
        far = omegas[here, j[left]] * (1.0 + width)
        both = counted(t, lanes_at(np.concatenate((near, far)), np.tile(own.machine[here], 2)))
        under, over = np.split(both, 2)
        fine = (under <= own.below[here] + i[left]) & (over >= own.below[here] + j[left] + 1)
        proof[left[fine]] = width
    machine, below, middle = (x.tolist() for x in (own.machine, own.below, 0.5 * (own.low + own.high)))
    for (number, part), width in zip(groups, proof.tolist(), strict=True):
        first, size = int(part[0]), part.size
        omega = float(omegas[number, first] if size == 1 else omegas[number, part].mean())
        shape = shapes[:, number, first : first + size]
        one = machine[number], below[number] + first, omega, size, width or None, middle[number]
        out[number].append(Solved(*one, shape))
    return out


def refined(t: Table, own: _Brackets, m: int) -> tuple[NDArray[np.bool_], Array, NDArray[Any]]:
    """Whether the m modes of every bracket stay inside, their frequencies, shapes of unit modal mass."""
    n, lanes = t.size, own.low.size
    start = 0.5 * (own.low + own.high)
    kind = complex if t.running else float
    good, omegas = np.zeros(lanes, dtype=bool), np.zeros((lanes, m))
    if m > n or n * lanes * m > LARGEST_SHAPES:
        return good, omegas, np.zeros((n, lanes, 0), kind)
    shapes = np.zeros((n, lanes, m), kind)
    numbers = np.arange(1.0, n + 1.0)[:, None] * (1.0 + np.sqrt(2.0) * np.arange(1.0, m + 1.0))
    x = np.broadcast_to(np.cos(numbers)[:, None, :], (n, lanes, m)).astype(kind)
    at = Lanes(start, start, own.machine)
    active, before = np.arange(lanes), np.full(lanes, np.inf)
    with np.errstate(all="ignore"):
        w, rate, late, _ = weights(t, at)
        band = bands(t, at.omega, w, late)
        x = _apart(solved(band, x, t.runs))
        x = _apart(solved(band, rate_load(t, at.omega, w, rate, late, x), t.runs))
        for _ in range(STEPS):
            energy, fall = forms(t, at.omega, w, rate, late, x)
            fine, sigma, basis = _ritz(energy, fall)
            x = np.matmul(x.transpose(1, 0, 2), basis).transpose(1, 0, 2)
            omega, low, high = at.omega, own.low[active], own.high[active]
            shift, slack = sigma.mean(axis=1), STAY * high
            fine &= (omega + sigma[:, 0] >= low - slack) & (omega + sigma[:, -1] <= high + slack)
            still = (np.abs(shift) <= 1e-11 * omega) & (np.abs(shift) >= 0.5 * before[active])
            close = sigma[:, -1] - sigma[:, 0] <= CLUSTER * omega
            done = fine & close & ((np.abs(shift) <= CONVERGED * omega) | still)
            good[active[done]] = True
            omegas[active[done]] = omega[done, None] + sigma[done]
            shapes[:, active[done]] = x[:, done]
            before[active] = np.abs(shift)
            go = fine & ~done & (close | (np.abs(shift) > 0.01 * (sigma[:, -1] - sigma[:, 0])))
            active, x = active[go], x[:, go]
            if not active.size:
                break
            at = Lanes(at.omega[go] + shift[go], at.placed[go], at.machine[go])
            w, rate, late, _ = weights(t, at)
            load = rate_load(t, at.omega, w, rate, late, x)
            x = _apart(solved(bands(t, at.omega, w, late), load, t.runs))
    return good, omegas, shapes


def _apart(x: NDArray[Any]) -> NDArray[Any]:
    """Columns of each lane made orthonormal."""
    if x.shape[2] == 1:
        return x
    whole = np.isfinite(x).all(axis=(0, 2))
    x = np.where(whole[None, :, None], x, 0.0)
    return np.linalg.qr(x.transpose(1, 0, 2))[0].transpose(1, 0, 2)


def _ritz(energy: NDArray[Any], fall: NDArray[Any]) -> tuple[NDArray[np.bool_], Array, NDArray[Any]]:
    """Whether a lane's forms are sound, its shifts, ascending, and combinations of unit modal mass."""
    if energy.shape[1] == 1:
        mass = fall[:, 0, 0].real
        fine = mass > 0.0
        mass = np.where(fine, mass, 1.0)
        return fine, (energy[:, 0, 0].real / mass)[:, None], np.sqrt(2.0 / mass)[:, None, None]
    fine = np.isfinite(energy).all(axis=(1, 2)) & np.isfinite(fall).all(axis=(1, 2))
    eye = np.eye(energy.shape[1])
    energy, fall = (np.where(fine[:, None, None], own, eye) for own in (energy, fall))
    values, basis = np.linalg.eigh(0.5 * (fall + fall.conj().transpose(0, 2, 1)))
    fine &= values[:, 0] > 1e-14 * values[:, -1]
    basis = basis / np.sqrt(np.maximum(values, 1e-300))[:, None, :]
    inner = basis.conj().transpose(0, 2, 1) @ energy @ basis
    sigma, vectors = np.linalg.eigh(0.5 * (inner + inner.conj().transpose(0, 2, 1)))
    return fine, sigma, np.sqrt(2.0) * (basis @ vectors)
