"""Every listed mode of the packaged drives against the small motions of the simulated loop about its rest."""

import numpy as np
import pytest
from scipy.linalg import eigh

import cabledrive as cd
from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.mesh import gradients, mesh_of
from cabledrive.mechanics.statics import equilibrium
from cabledrive.parameters import packaged_drives

COUNT = 5


def frequencies_of_the_loop(drive, segments):
    """Small motions of the divided cable about the rest of ``--from-equilibrium``: in the plane, and across.

    The tangent of the exact law at rest and the masses of the nodes are what the time steps integrate.
    """
    mesh, law = mesh_of(drive, segments), cable_law(drive.cable, "exact")
    rest = equilibrium(mesh, law, hold="drive").displacement
    tangent = law.stiffness_matrix(*gradients(mesh, rest)) / mesh.spacing[:, None, None]
    nodes = mesh.nodes - mesh.closed
    springs = np.zeros((3 * nodes, 3 * nodes))
    for i, block in enumerate(tangent):
        a, b = 3 * i + np.arange(3), 3 * ((i + 1) % nodes) + np.arange(3)
        springs[np.ix_(a, a)] += block
        springs[np.ix_(b, b)] += block
        springs[np.ix_(a, b)] -= block
        springs[np.ix_(b, a)] -= block
    mass = np.repeat(mesh.mass[:nodes], 3)
    mass[::3] = mesh.axial_mass[:nodes]
    free = np.repeat(mesh.sways[:nodes], 3)
    free[::3] = True
    for rim, shaft in zip(mesh.rims, mesh.shafts, strict=False):
        free[3 * rim] = not shaft.fixed
    springs, mass, free = np.pad(springs, (0, 1)), np.append(mass, 1.0), np.append(free, False)
    if mesh.joint:
        square = mesh.shafts[0].radius ** 2
        ends = [0, 3 * nodes]
        springs[np.ix_(ends, ends)] += mesh.joint.stiffness / square * np.array([[1.0, -1.0], [-1.0, 1.0]])
        mass[-1], free[-1] = mesh.shafts[2].rim_mass, True
    motor = drive.motor
    if motor is not None and motor.holding_stiffness is not None:
        rotor = 3 * nodes if mesh.joint else 0
        springs[rotor, rotor] += motor.holding_stiffness / mesh.shafts[0].radius ** 2

    def lowest(chosen):
        chosen = chosen[free[chosen]]
        square = eigh(
            springs[np.ix_(chosen, chosen)], np.diag(mass[chosen]), eigvals_only=True, subset_by_index=[0, 39]
        )
        return np.sqrt(np.maximum(square, 0.0)) / (2 * np.pi)

    everything = np.arange(mass.size)
    across = everything[everything % 3 == 1]
    return lowest(np.setdiff1d(everything, across)), lowest(across)


@pytest.mark.verify
@pytest.mark.parametrize("name", packaged_drives("loop", "line"))
def test_every_listed_frequency_is_one_of_the_loop(name, measured):
    """By the error of the loop's own segments, halved once."""
    drive = cd.load_drive(name)
    found = cd.modes(drive, count=COUNT)
    top = min(found.modes[-1].frequency, 1.2 * found.transverse[-1].frequency)
    segments = 48
    coarse, fine = frequencies_of_the_loop(drive, segments), frequencies_of_the_loop(drive, 2 * segments)
    worst = 0.0
    for mode in found.modes:
        if mode.frequency > top:
            continue
        plane = 1 if mode.plane == "v" else 0
        place = int(np.argmin(np.abs(fine[plane] - mode.frequency)))
        limit = fine[plane][place] + (fine[plane][place] - coarse[plane][place]) / 3
        scheme = abs(fine[plane][place] - coarse[plane][place])
        error = abs(limit - mode.frequency)
        worst = max(worst, error / mode.frequency)
        allowed = scheme + 1e-6 * mode.frequency
        assert error <= allowed, f"{mode.frequency:.8g} Hz, {mode.kind} {mode.plane}: loop {limit:.8g} Hz"
    warned = f", with {len(found.warnings)} warnings" if found.warnings else ""
    measured(f"{name}: largest deviation {worst:.1e}{warned}")
