"""Drives drawn at random: loops and lines, held ends, flexible joints, large contrasts, symmetric loops."""

from itertools import pairwise

import numpy as np

from cabledrive.parameters import Cable, Carriage, Drive, Layout, Motor, Pulley

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
