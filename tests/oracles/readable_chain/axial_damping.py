"""Readable Kelvin-Voigt damping: one implicit linear system for the new velocities of the nodes of a span."""

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.simulation.dampers import AS_STRAIGHT
from cabledrive.simulation.plan import COMPLIANCE, INVERSE_SPACING, KICK_T, KICK_U, Plan


def damper_directions(plan: Plan, law: CableLaw, x: Array) -> Array:
    """Directions along which the segments are damped.

    ``x``, shape (3, nodes): displacements [m].
    Returns shape (3, segments): derivative of each segment's strain; zero where the cable is slack.
    """
    gradients = np.diff(x, axis=1) * plan.segment[INVERSE_SPACING]
    return np.stack(law.strain_gradient(*gradients))


def damped_span_reference(
    plan: Plan, span: int, direction: Array, mean: Array, rim_speeds: tuple[float, float]
) -> Array:
    """Damping tensions of a span for given mean speeds of its rims, shape (segments per span,) [N].

    ``mean`` (3, nodes) holds the mean velocities over the step as they would be without the damping. Solves
    (1 + G C / 2) V = mean for the velocities V between the rims, with the dampers C = D^T D / compliance and
    the step over each node's mass in G.
    """
    n = plan.nodes[0, 1]
    nodes = slice(span * n, span * n + n + 1)
    segments = slice(span * n, span * n + n)
    velocity = mean[:, nodes].copy()
    velocity[:, [0, -1]] = 0.0
    velocity[0, [0, -1]] = rim_speeds
    rates = _rates(direction[:, segments])  # (segments, 3 nodes)
    dampers = rates.T @ (rates / plan.segment[COMPLIANCE, segments, None])
    gain = plan.node[[KICK_U, KICK_T, KICK_T], nodes].T.ravel()
    system = np.eye(gain.size) + 0.5 * gain[:, None] * dampers
    if plan.axial == AS_STRAIGHT:  # the tensions' own matrix is that of a rope along u
        along = _rates(np.eye(3)[[0]].T + np.zeros((3, n)))
        matrix = np.diag(plan.segment[COMPLIANCE, segments]) + 0.5 * along * gain @ along.T
        tension: Array = np.linalg.solve(matrix, rates @ velocity.T.ravel())
        return tension
    between = np.linalg.solve(system, velocity.T.ravel())
    tension = (rates @ between) / plan.segment[COMPLIANCE, segments]
    return tension


def _rates(direction: Array) -> Array:
    """Matrix that takes velocities (u, v, w node after node) to the rates at which the segments stretch."""
    segments = direction.shape[1]
    rates = np.zeros((segments, segments + 1, 3))
    own = np.arange(segments)
    rates[own, own] = -direction.T
    rates[own, own + 1] = direction.T
    return rates.reshape(segments, -1)
