"""Drives drawn at random: held ends, flexible joints, contrasts, symmetric loops; counts of networks."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from cabledrive.mechanics import Chain, Pendant
from cabledrive.mechanics.chain import own_chain
from cabledrive.modal.component import Component
from cabledrive.modal.networks import network_of_chain
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters import Cable, Carriage, Drive, Layout, Motor, Pulley
from oracles.network_fem import String, matrices
from oracles.rope_fem import frequencies

MOTOR = Pendant(stiffness=2500.0, mass=0.4, joint=2)
LINE = Chain(
    rigidity=438.0,
    density=2.1e-4,
    lengths=np.array([0.6, 0.37, 0.47]),
    masses=np.array([0.8, 0.05, 0.2, 1.5]),
)
RADIUS = 0.5  # a power of two: J / r^2 gives back the mass it was made from, to the last bit


def machine(rng, contrast=1e6):
    """Any drive with a longitudinal chain, one in three of them a symmetric loop."""
    return symmetric_loop(rng, contrast) if rng.random() < 1 / 3 else uneven_machine(rng, contrast)


def uneven_machine(rng, contrast=1e6):
    kind = rng.choice(["loop", "loop", "line"])
    cable = some_cable(rng)
    length = 10 ** rng.uniform(-2, 3)
    scale = cable.mass_per_length * length
    fixed = rng.random(2) < 0.2
    motor = None
    if not fixed[0] and rng.random() < 0.5:
        motor = some_motor(rng, cable, length, scale * spread(rng, contrast), rng.random() < 0.7)
    carriages = []
    for span in ("upper", "lower")[: 2 if kind == "loop" else 1]:
        places = np.cumsum([spread(rng, contrast) for _ in range(rng.integers(1, 5))])
        for place in length * places[:-1] / places[-1]:
            carriages.append(Carriage(mass=scale * spread(rng, contrast), span=span, position=place))
    pulleys = [pulley(scale * spread(rng, contrast), bool(held)) for held in fixed]
    return drive(kind, cable, length, pulleys, carriages, motor)


def symmetric_loop(rng, contrast=1e6):
    """Loops whose modes come in pairs: equal masses evenly spaced, mirror images, or two equal pulleys."""
    cable, length = some_cable(rng), 2.0 ** rng.integers(-3, 6)
    scale = cable.mass_per_length * length
    mass = scale * spread(rng, contrast)
    form = rng.choice(["even", "mirrored", "bare"])
    if form == "bare":
        return drive("loop", cable, length, [pulley(mass), pulley(mass)], [])
    if form == "even":
        parts = int(rng.choice([2, 4, 8]))
        places, masses = [length * k / parts for k in range(1, parts)], [mass] * (parts - 1)
        pulleys = [pulley(mass), pulley(mass)]
    else:
        places = np.sort(rng.uniform(0, length, rng.integers(1, 4))).tolist()
        masses = [scale * spread(rng, contrast) for _ in places]
        pulleys = [pulley(mass), pulley(scale * spread(rng, contrast))]
    upper = [Carriage(mass=m, position=p) for m, p in zip(masses, places, strict=True)]
    lower = [Carriage(mass=m, position=length - p, span="lower") for m, p in zip(masses, places, strict=True)]
    motor = some_motor(rng, cable, length, mass, True) if rng.random() < 0.2 else None
    return drive("loop", cable, length, pulleys, upper + lower, motor)


def spread(rng, contrast):
    """A factor with logarithm evenly spread; two of them differ by at most the contrast."""
    return contrast ** rng.uniform(-0.5, 0.5)


def some_cable(rng):
    return Cable(
        youngs_modulus=10 ** rng.uniform(9, 11),
        area=10 ** rng.uniform(-7, -4),
        mass_per_length=10 ** rng.uniform(-4, 1),
        pretension=10 ** rng.uniform(0, 2),
    )


def some_motor(rng, cable, length, rim_mass, flexible):
    stiffness = cable.axial_rigidity / length * spread(rng, 1e4) * RADIUS**2
    return Motor(inertia=rim_mass * RADIUS**2, joint_stiffness=stiffness if flexible else None)


def pulley(rim_mass, fixed=False):
    return Pulley(radius=RADIUS, inertia=rim_mass * RADIUS**2, fixed=fixed)


def drive(kind, cable, length, pulleys, carriages, motor=None):
    return Drive(
        name="drawn",
        kind=str(kind),
        cable=cable,
        layout=Layout(span_length=float(length), gravity=0.0),
        pulley=tuple(pulleys),
        carriage=tuple(carriages),
        motor=motor,
    )


def ring_of(lengths, masses, cable):
    """A loop from its segments and joints in order, an even number: the load pulley is half way."""
    half = len(lengths) // 2
    upper, lower = np.cumsum(lengths[:half]), np.cumsum(lengths[half:])
    carriages = [
        Carriage(mass=m, position=p, span=span)
        for span, places, some in (("upper", upper, masses[1:half]), ("lower", lower, masses[half + 1 :]))
        for p, m in zip(places[:-1], some, strict=True)
    ]
    return drive("loop", cable, upper[-1], [pulley(masses[0]), pulley(masses[half])], carriages)


def distinct(values, share):
    """Groups of neighbouring values closer than a share of them."""
    groups = [[values[0]]]
    for a, b in pairwise(values):
        if b - a > share * b:
            groups.append([])
        groups[-1].append(b)
    return groups


# --- Counts and modes of chains, of random networks and of single ropes, straight from the search
def below(chain, omega):
    """Modes of a chain below a frequency [rad/s], its rigid-body mode included."""
    spectrum = Spectrum(network_of_chain(own_chain(chain)))
    return spectrum.count(omega) + spectrum.rigid_body_modes


def by_multiplicity(modes):
    """Frequencies of a list of modes [Hz], each by its multiplicity."""
    return np.repeat([mode.frequency for mode in modes], [mode.multiplicity for mode in modes])


def listed(found):
    """Frequencies of what a component's search has found, each by its multiplicity, all proven [rad/s]."""
    assert all(own.enclosure is not None for _, own in found)
    return np.repeat([own.omega for _, own in found], [own.multiplicity for _, own in found])


def held(rope, top):
    """Frequencies of a rope between ends at rest, clamped if it bends, below one [rad/s]."""
    return listed(alone(rope).modes(0.0, top))


def alone(rope):
    """One rope between ends at rest."""
    none = ((),) * len(rope.start)
    return Component((), [replace(rope, start=none, end=none, ropes=1)])


def finite_elements(chain, top, held=(), degree=46):
    """Natural frequencies [rad/s] up to about one by the p-version, no wave formula; rigid modes near 0.

    ``held``: joints that are held besides the chain's own ends.
    """
    n = chain.masses.size
    total = n + len(chain.pendants)
    fixed = {joint for joint, is_held in zip((0, n - 1), chain.fixed, strict=True) if is_held}
    kept = [joint for joint in range(total) if joint not in fixed | set(held)]
    rows, stiffness = np.eye(total), np.zeros((total, total))
    mass = np.diag([*chain.masses, *(pendant.mass for pendant in chain.pendants)])
    stiffness[range(n), range(n)] = 0.0 if chain.grounds is None else chain.grounds
    for number, pendant in enumerate(chain.pendants, n):
        twist = rows[number] - rows[pendant.joint]
        stiffness += pendant.stiffness * np.outer(twist, twist)
        stiffness[number, number] += pendant.ground
    cables = (np.broadcast_to(value, chain.lengths.shape) for value in (chain.rigidity, chain.density))
    strings = [
        String(rows[i, kept], rows[(i + 1) % n, kept], rho * length, np.sqrt(force / rho) / length)
        for i, (length, force, rho) in enumerate(zip(chain.lengths, *cables, strict=True))
    ]
    square = np.ix_(kept, kept)
    mass, _, stiffness = matrices(strings, mass[square], stiffness[square], degree)
    return frequencies(mass, stiffness, top)


def irvine_roots(parameter):
    """Symmetric modes in the plane of a level span, x = omega L sqrt(rho/T), by Irvine and Caughey.

    tan(x/2) = x/2 - 4/lambda^2 (x/2)^3; The linear theory of free vibrations of a suspended cable (1974).
    """

    def miss(x):
        return np.sin(x / 2) - (x / 2 - 4 / parameter * (x / 2) ** 3) * np.cos(x / 2)

    x = np.linspace(0.5, 40.0, 80_001)
    return [brentq(miss, x[i], x[i + 1]) for i in np.flatnonzero(np.diff(np.sign(miss(x))))]
