"""Drives, settings and random starts on which the compiled integrators are held against readable ones."""

from dataclasses import replace
from itertools import product

import numpy as np

from cabledrive.mechanics.cable_laws import LAWS, cable_law
from cabledrive.mechanics.mesh import mesh_of
from cabledrive.mechanics.network.motion import gravity
from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.drive_parts import Carriage
from cabledrive.simulation.channels import width_of
from cabledrive.simulation.damped import AS_BENT, AS_STRAIGHT
from cabledrive.simulation.methods import NAMES, integrate_steps
from cabledrive.simulation.network.mesh import network_plan, rest_of
from cabledrive.simulation.plan import copy_state, new_state, new_workspace
from cabledrive.simulation.start import Scheme

SEGMENTS, STEPS, EVERY = 7, 36, 6
LOOP = load_drive("dissertation-2").listed
MOTORED = load_drive("dissertation-3").listed
CARRIAGES = (
    Carriage(mass=2e-3, position=0.31),
    Carriage(mass=1e-3, position=0.62, guided=False),
    Carriage(mass=3e-3, position=0.2, span="lower", guided=False),
)
RUBBED = replace(
    LOOP, pulley=tuple(replace(p, viscous_friction=0.01, coulomb_friction=0.02) for p in LOOP.pulley)
)
HELD = replace(LOOP, pulley=(LOOP.pulley[0], replace(LOOP.pulley[1], fixed=True)))
SLOPED = replace(LOOP, layout=replace(LOOP.layout, inclination=0.4))

SPRUNG = replace(MOTORED, motor=replace(MOTORED.motor, holding_stiffness=40.0))
RIGID_SPRUNG = replace(SPRUNG, motor=replace(SPRUNG.motor, joint_stiffness=None, coulomb_friction=0.0))

CASES = {
    **{name: (LOOP, name, {}) for name in LAWS},
    "line": (replace(LOOP, kind="line"), "exact", {"transverse_damping": 20.0}),
    "damped": (LOOP, "exact", {"transverse_damping": 20.0}),
    "sloped": (SLOPED, "exact", {}),
    "held load": (HELD, "exact", {}),
    "carriages": (replace(SLOPED, carriage=CARRIAGES), "exact", {"transverse_damping": 20.0}),
    "forces": (replace(LOOP, carriage=CARRIAGES), "exact", {"forces": ((3, 0), (5, 2))}),
    "stick-slip": (RUBBED, "exact", {}),
    "smoothed": (RUBBED, "exact", {"smoothing_speed": 0.1}),
    "motor": (MOTORED, "exact", {}),
    "motor, held by a spring": (SPRUNG, "exact", {}),
    "rigid motor, held by a spring": (RIGID_SPRUNG, "exact", {}),
    "motor, smoothed": (MOTORED, "exact", {"smoothing_speed": 0.1}),
    "axial damping": (LOOP, "exact", {"axial_damping": 4.5}),
    "axial damping, bent": (LOOP, "exact", {"axial_damping": 4.5, "bent": True}),
    "axial damping, line": (replace(LOOP, kind="line"), "exact", {"axial_damping": 0.1}),
    "axial damping, linear": (LOOP, "linear", {"axial_damping": 4.5}),
    "everything": (
        replace(MOTORED, carriage=CARRIAGES, pulley=RUBBED.pulley, layout=SLOPED.layout),
        "exact",
        {"axial_damping": 4.5, "transverse_damping": 20.0, "forces": ((2, 1), (9, 0))},
    ),
    "slack": (LOOP, "exact", {"slack": True}),
    "slack, damped": (LOOP, "exact", {"slack": True, "axial_damping": 0.1, "bent": True}),
    "slack, weak": (LOOP, "weak", {"slack": True}),
    "steep": (LOOP, "exact", {"steep": True}),
}


def setting(case):
    """Plan, random start and inputs of a case, the motion some thousand times round-off of every part."""
    drive, model, options = CASES[case]
    options = dict(options)
    slack, steep, bent = (options.pop(name, False) for name in ("slack", "steep", "bent"))
    damping = {name: options.get(name, 0.0) for name in ("transverse_damping", "axial_damping")}
    drive = replace(drive, cable=replace(drive.cable, **damping))
    mesh, law = mesh_of(drive.machine, SEGMENTS), cable_law(drive.cable, model, tension_only=slack)
    rest, shortest = hung(drive, mesh, law), mesh.spacing[mesh.spacing > 0.0].min()
    step = 0.8 * shortest / drive.cable.axial_wave_speed
    smooth = {"friction": "smoothed", "smoothing_speed": 0.1} if "smoothing_speed" in options else {}
    scheme = Scheme(slack="record", **smooth)
    laws, probes = [law] * len(mesh.pieces), (("upper", 0.123),)
    plan = network_plan(mesh, laws, rest, probes, step, scheme, options.get("forces", ()))
    plan = as_bent(plan) if bent else plan
    rng = np.random.default_rng(11)
    size = np.array([[6e-3 if slack else 2e-4], [2e-3], [2e-3]]) * (60.0 if steep else 1.0)
    x = size * rng.uniform(-1.0, 1.0, (3, mesh.size)) * shortest * 7.0
    x_t = rng.uniform(-0.5, 0.5, (3, mesh.size))
    start = new_state(plan, *joined(mesh, x, x_t, rest.x))
    torque = 0.5 * rng.standard_normal((STEPS, 1))
    forces = rng.standard_normal((STEPS, plan.force.shape[0]))
    return plan, start, torque, forces


def hung(drive, mesh, law):
    """How the cable of a loop or a line hangs."""
    return rest_of(mesh, [law] * len(mesh.pieces), gravity(drive.machine))


def joined(mesh, x, x_t, rest):
    """Displacements from rest and velocities whose ends are joined, and coordinates that follow the rims."""
    turns, both = mesh.turns, []
    for field, offset in ((x, rest), (x_t, 0.0 * rest)):
        rows = np.vstack([mesh.ends[:, :, 0].reshape(-1, len(mesh.names)), turns[2] - turns[0]])
        q = np.linalg.lstsq(rows, np.append(field[0, mesh.nodes].ravel(), 0.0))[0]
        field[1:, ~mesh.sways] = 0.0
        field[:, mesh.nodes] = (mesh.ends @ q).transpose(2, 0, 1)
        both.append((field + offset, q))
    (x, q), (x_t, q_t) = both
    return x, x_t, q, q_t


def as_bent(plan):
    """With the matrix of the bent rope, which the long loop takes, in place of the straight one's."""
    return plan._replace(axial=AS_BENT) if plan.axial == AS_STRAIGHT else plan


def taken(function, plan, start, torque, forces, every=EVERY):
    """Code, state, rows and fields after the steps of a method by its name, or of a readable twin."""
    state, records = copy_state(start), len(torque) // every
    kept = np.zeros((records, width_of(plan))), np.zeros((records, *start.x.shape))
    given, inputs = (plan, state, new_workspace(plan)), (torque, forces)
    if isinstance(function, str):
        return integrate_steps(function, given, inputs, every, kept), state, *kept
    return function(*given, *inputs, every, *kept), state, *kept


VERLET, NODE_CENTRED, ENERGY = NAMES


def chain_matrices(mesh, stiffness, axes=(0,)):
    """Springs and masses of divided ropes, (n, n): nodes along some axes, then coordinates.

    ``stiffness``: of a rope of each piece along every axis.
    """
    inner, n = np.flatnonzero(mesh.cells), len(mesh.names)
    nodes = len(axes) * inner.size
    springs, mass = np.zeros((nodes + n, nodes + n)), np.zeros((nodes + n, nodes + n))
    springs[nodes:, nodes:], mass[nodes:, nodes:] = mesh.stiffness, mesh.mass
    for (k, (first, last)), (number, axis) in product(enumerate(mesh.nodes), enumerate(axes)):
        own = number * inner.size + np.searchsorted(inner, np.arange(first + 1, last))
        moves = np.zeros((last - first + 1, nodes + n))
        moves[1 + np.arange(own.size), own] = 1.0
        moves[[0, -1], nodes:] = mesh.ends[k, :, axis]
        stretch = np.diff(moves, axis=0)
        springs += mesh.ropes[k] * stiffness[k] * (stretch.T / mesh.spacing[first:last]) @ stretch
        mass[own, own] = mesh.ropes[k] * (mesh.cells + mesh.carried)[first + 1 : last]
    return springs, mass


def heard(signal, step, near):
    """Frequencies of peaks next to given ones, by a parabola through the log of a Hann spectrum."""
    window = np.hanning(signal.size)
    spectrum = np.log(np.abs(np.fft.rfft(signal * window, 8 * signal.size)) + 1e-300)
    resolution = 1.0 / (8 * signal.size * step)
    peaks = []
    for frequency in near:
        middle = round(frequency / resolution)
        reach = round(2.0 / (signal.size * step) / resolution)
        k = middle - reach + int(np.argmax(spectrum[middle - reach : middle + reach + 1]))
        before, at, after = spectrum[k - 1 : k + 2]
        peaks.append((k + 0.5 * (before - after) / (before - 2.0 * at + after)) * resolution)
    return np.array(peaks)
