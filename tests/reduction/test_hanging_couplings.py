"""Couplings of modes about ropes that hang: third derivatives of the energy of divided ropes."""

from itertools import product

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics import ExactLaw
from cabledrive.mechanics.mesh import divided
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.motion import gravity
from cabledrive.reduction.waves import waves_of
from cabledrive.simulation.network.mesh import rest_of
from network_samples import as_routes

SIZE = 0.02
"""Largest displacement of a node that is tried [m]."""


def cableway(irvine, slope, cabin):
    """A loop of 40 m under 1 kN of pretension, EA 500 times as much, with a cabin of 3 kg."""
    weight = 1000.0 * np.sqrt(irvine / 500.0) / 40.0
    return as_routes(
        cd.Drive(
            schema=1,
            name="cableway",
            kind="loop",
            cable=cd.Cable(given_rigidity=5e5, mass_per_length=weight / 9.81, pretension=1000.0),
            layout=cd.Layout(span_length=40.0, inclination=np.radians(slope), gravity=9.81),
            pulley=tuple(cd.Pulley(radius=0.1, inertia=0.05) for _ in range(2)),
            carriage=(cd.Carriage(mass=3.0, position=40.0 / 3.0, guided=False),) if cabin else (),
        ),
    )


@pytest.mark.parametrize("irvine, slope, cabin", [(1.0, 0.0, False), (30.0, 20.0, True), (100.0, 0.0, False)])
def test_couplings_are_the_third_derivatives_of_the_energy_of_divided_ropes(irvine, slope, cabin, measured):
    """Along the modes' own shapes, by differences; the error falls with the square of the segments."""
    machine = cableway(irvine, slope, cabin)
    network, found = network_of(machine), cd.modes(machine, below=60.0 if irvine < 10.0 else 14.0)
    along, across = [one for one in found.longitudinal if not one.clamped][:2], list(found.transverse[:6])
    couplings = waves_of(network, along, across, hanging=True).couplings
    scale = np.abs(couplings).max()
    off = []
    for segments in (60, 120):
        mesh = divided(network, segments)
        both = zip(mesh.tension.tolist(), mesh.rigidity.tolist(), strict=True)
        laws = [ExactLaw(pretension=tension, axial_rigidity=rigidity) for tension, rigidity in both]
        rest = rest_of(mesh, laws, gravity(machine)).x

        def shape(mode, mesh=mesh):
            moved = np.zeros((3, mesh.size))
            for k, (first, last) in enumerate(mesh.nodes):
                own = mesh.parts[k][0]
                places = own.start + (own.end - own.start) * mesh.positions[k] / mesh.length[k]
                for axis, way in enumerate(("along", "out of plane", "across")):
                    moved[axis, first : last + 1] = mode.displacement(own.where.name, way, places)[0].real
            return moved

        def energy(moved, mesh=mesh, laws=laws):
            total = np.longdouble(0.0)
            for (first, last), law, ropes in zip(mesh.nodes, laws, mesh.ropes, strict=True):
                h = mesh.spacing[first:last]
                slopes = np.diff(moved[:, first : last + 1].astype(np.longdouble), axis=1) / h
                total += ropes * np.sum(h * law.energy_density(*slopes))
            return total

        shapes = [[SIZE * own / np.abs(own).max() for own in map(shape, modes)] for modes in (along, across)]
        sizes = [[SIZE / np.abs(own).max() for own in map(shape, modes)] for modes in (along, across)]
        worst = 0.0
        for q, a, b in product(range(len(along)), range(6), range(6)):
            if a > b:
                continue
            signs = product((1, -1), repeat=3)
            stored = sum(
                i * j * k * energy(rest + i * shapes[0][q] + j * shapes[1][a] + k * shapes[1][b])
                for i, j, k in signs
            )
            third = float(stored) / 8.0 / (sizes[0][q] * sizes[1][a] * sizes[1][b])
            worst = max(worst, abs(third - couplings[q, a, b]) / scale)
        off.append(worst)
    measured(f"Irvine parameter {irvine:g}: {off[0]:.1e} and {off[1]:.1e} of the largest coupling")
    assert off[1] < 1e-3
    assert off[0] / off[1] == pytest.approx(4.0, rel=0.3)
