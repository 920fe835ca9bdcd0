"""A rope over wheels and to bodies as one divided cable: every span about its exact elastic catenary.

Straight elements between nodes in the plane; a wheel's rim moves its ends along the rope's own direction
where it leaves. Shared with the package: the file's numbers and the pull along the chord of each span.
"""

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import root

GAUSS = np.polynomial.legendre.leggauss(8)


def catenary(rigidity, weight, chord, pull, elements, weights=()):
    """Nodes, shape (m + 1, 2), lengths at rest, tensions, and unit vectors at both ends.

    ``weight``: vector per unstretched length; ``pull``: force along the chord at the start; ``weights``: of
    what hangs on it, as (share of the chord, force vector), at nodes of their own.
    """
    size = np.hypot(*chord)
    along = chord / size
    across = np.array([-along[1], along[0]])
    shares = np.array([0.0, *(share for share, _ in weights), 1.0])
    counts = np.maximum(2, np.rint(np.diff(shares) * elements)).astype(int)

    def walk(unknown):
        """From the start, with the force across there and the lengths at rest of the parts."""
        force, at = pull * along + unknown[0] * across, np.zeros(2)
        nodes, parts, tensions, ends, first = [at], [], [], [], force
        for number, (count, length) in enumerate(zip(counts, unknown[1:], strict=True)):
            h = length / count
            for _ in range(count):
                s = h * (1 + GAUSS[0]) / 2
                inner = force[:, None] - weight[:, None] * s
                tension = np.hypot(*inner)
                at = at + (inner / tension * (1 + tension / rigidity)) @ GAUSS[1] * h / 2
                tensions.append(np.hypot(*(force - weight * h / 2)))
                force = force - weight * h
                nodes.append(at)
                parts.append(h)
            ends.append(at)
            if number < len(weights):
                force = force - weights[number][1]
        return np.array(nodes), np.array(parts), np.array(tensions), ends, (first, force)

    def miss(unknown):
        ends = walk(unknown)[3]
        missing = [(end @ along) / size - share for end, share in zip(ends, shares[1:], strict=True)]
        return [*missing, ends[-1] @ across / size]

    load = weight * size + sum((force for _, force in weights), np.zeros(2))
    guess = [0.5 * load @ across, *(np.diff(shares) * size / (1 + pull / rigidity))]
    solved = root(miss, guess, tol=1e-13)
    assert np.max(np.abs(solved.fun)) < 1e-11
    nodes, parts, tensions, _, (first, last) = walk(solved.x)
    return nodes, parts, tensions, first / np.hypot(*first), last / np.hypot(*last), np.cumsum([0, *counts])


def settled(span, elements):
    """The catenary of a span whose ends lie on their wheels where it leaves them."""
    directions = [np.array(span["chord"]) / np.hypot(*span["chord"])] * 2
    load = span["density"] * np.array(span["gravity"])
    hung = [(one[0], np.array(one[1])) for one in span["hung"]]
    for count in (*(4,) * 8, elements):  # the rope at rest does not depend on its division
        ends = [
            np.array(centre) - reach * np.array([-t[1], t[0]])  # reach: radius times sense
            for (centre, reach), t in zip((span["start"], span["end"]), directions, strict=True)
        ]
        found = catenary(span["rigidity"], load, ends[1] - ends[0], span["pull"], count, hung)
        directions = [found[3], found[4]]
    return found


def frequencies(spans, mass, stiffness, elements):
    """Natural frequencies [Hz], ascending.

    ``spans``: dicts of rigidity, density, gravity, chord, pull, start and end (centre, radius times sense),
    start_rows and end_rows, shape (2, n), of the centres, start_turn and end_turn, shape (n,), of the rims,
    hung (share of the chord, force vector, mass).
    """
    n = mass.shape[0]
    blocks = []
    for span in spans:
        blocks.append((span, *settled(span, elements)))
    total = n + sum(2 * (block[1].shape[0] - 2) for block in blocks)
    m, k = np.zeros((total, total)), np.zeros((total, total))
    m[:n, :n], k[:n, :n] = mass, stiffness
    one, at = np.eye(2), n
    for span, nodes, parts, tensions, near, far, places in blocks:
        count = nodes.shape[0]
        rows = np.zeros((2 * count, total))
        rows[2:-2, at : at + 2 * (count - 2)] = np.eye(2 * (count - 2))
        at += 2 * (count - 2)
        rows[:2, :n] = span["start_rows"] + np.outer(near, span["start_turn"])
        rows[-2:, :n] = span["end_rows"] + np.outer(far, span["end_turn"])
        local_m, local_k = np.zeros((2 * count, 2 * count)), np.zeros((2 * count, 2 * count))
        for i in range(count - 1):
            d = nodes[i + 1] - nodes[i]
            size = np.hypot(*d)
            t = np.outer(d, d) / size**2
            block = span["rigidity"] / parts[i] * t + tensions[i] / size * (one - t)
            own = np.ix_(range(2 * i, 2 * i + 4), range(2 * i, 2 * i + 4))
            local_k[own] += np.block([[block, -block], [-block, block]])
            local_m[own] += span["density"] * parts[i] / 6 * np.block([[2 * one, one], [one, 2 * one]])
        for place, hung in zip(places[1:-1], span["hung"], strict=True):
            local_m[2 * place : 2 * place + 2, 2 * place : 2 * place + 2] += hung[2] * one
        m += rows.T @ local_m @ rows
        k += rows.T @ local_k @ rows
    return np.sqrt(np.maximum(eigh(k, m, eigvals_only=True), 0.0)) / (2 * np.pi)


def extrapolated(spans, mass, stiffness, *, elements, count):
    """The first frequencies, the error of second order taken out."""
    coarse, fine = (frequencies(spans, mass, stiffness, e)[:count] for e in (elements, 2 * elements))
    return (4 * fine - coarse) / 3
