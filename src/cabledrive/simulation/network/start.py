"""Where a machine with routes is at t = 0."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.network.mesh import NetworkMesh
from cabledrive.simulation.start import PLANES, Pluck, named_shape


@dataclass(frozen=True, kw_only=True, eq=False)
class NetworkStart:
    """Where a machine with routes is at t = 0.

    Attributes
    ----------
    plucks : tuple of Pluck
        Displacements of spans, called by their names; planes u, v, w.
    places, speeds : dict of str to float
        Coordinates such as "head.x" or a pulley, from rest [m], [rad]; [m/s], [rad/s]. Ropes follow linearly.
    """

    plucks: tuple[Pluck, ...] = ()
    places: Mapping[str, float] = field(default_factory=dict)
    speeds: Mapping[str, float] = field(default_factory=dict)


def placed(
    mesh: NetworkMesh, given: Mapping[str, float], what: str, plucks: tuple[Pluck, ...]
) -> tuple[Array, Array]:
    """Displacements or velocities of nodes and coordinates; ropes follow their ends linearly."""
    q, x = np.zeros(len(mesh.names)), np.zeros((3, mesh.size))
    for name, value in given.items():
        if name not in mesh.names:
            raise InputRefused(f'start: {what} of "{str(name)[:60]}": take one of {", ".join(mesh.names)}')
        if not np.isfinite(value):
            raise InputRefused(f"start: {what} of {name} = {value} must be finite")
        q[mesh.names.index(name)] = value
    for k, (first, last) in enumerate(mesh.nodes):
        share = mesh.position(k) / mesh.length[k]
        ends = [mesh.ends[k, side] @ q for side in range(2)]
        x[:, first : last + 1] = ends[0][:, None] + (ends[1] - ends[0])[:, None] * share
    for pluck in plucks:
        if pluck.span not in mesh.pieces:
            raise InputRefused(f'pluck: "{pluck.span[:60]}" is no span: take one of {"; ".join(mesh.pieces)}')
        k = mesh.pieces.index(pluck.span)
        first, last = mesh.nodes[k]
        x[PLANES.index(pluck.plane), first : last + 1] += _shape(pluck, mesh.position(k))
    return x, q


def _shape(pluck: Pluck, x: Array) -> Array:
    """Profile of a pluck along one piece, zero at its ends."""
    if not abs(pluck.height) < x[-1]:
        raise InputRefused(f"pluck: {pluck.height:.6g} m is longer than its span of {x[-1]:.6g} m: lower it")
    if isinstance(pluck.shape, str):
        return pluck.height * named_shape(pluck.shape, x, 0.0, pluck.place * x[-1], x[-1])
    values = pluck.shape(x) if callable(pluck.shape) else pluck.shape
    profile = np.asarray(values, dtype=np.float64)
    if not callable(pluck.shape):
        profile = np.interp(x / x[-1], np.linspace(0.0, 1.0, profile.size), profile)
    profile = pluck.height * profile
    if profile.shape != x.shape or not np.isfinite(profile).all() or abs(profile[[0, -1]]).max() > 1e-12:
        raise InputRefused("pluck: the profile must be finite, and zero at both ends of its span")
    return np.asarray(profile)
