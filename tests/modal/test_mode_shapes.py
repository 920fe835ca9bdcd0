"""Mode shapes obey the mechanics they come from: masses, energies, boundary conditions, by quadrature."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from machines import machine, ring_of, some_cable, uneven_machine
from numpy.polynomial import chebyshev, legendre

import cabledrive as cd
from cabledrive.mechanics.network import statics_of
from network_samples import as_routes

NODES, WEIGHTS = legendre.leggauss(80)
MODES = 8


class Sampled:
    """A mode's displacement and slope at the quadrature points of every stretch, from `Mode.shape` alone."""

    def __init__(self, drive, mode, kind):
        self.drive, self.mode, self.kind = drive, mode, kind
        self.omega = 2 * np.pi * mode.frequency
        spans = drive.spans if kind == "longitudinal" else (mode.span,)
        self.pieces = [piece for span in spans for piece in self.sample(span)]

    def sample(self, span):
        """Weights, displacements, slopes and end slopes of each stretch between joints."""
        stops = [0.0, *(c.position for c in self.drive.carriages_on(span)), self.drive.span_length]
        for start, end in pairwise(stops):
            half = 0.5 * (end - start)
            u = self.mode.shape(span, start + half * (1 + NODES))
            interpolant = chebyshev.chebfit(NODES, u.T, 70)
            slope = chebyshev.chebder(interpolant) / half
            yield {
                "span": span,
                "weights": half * WEIGHTS,
                "u": u,
                "slope": chebyshev.chebval(NODES, slope),
                "ends": (chebyshev.chebval(-1.0, slope), chebyshev.chebval(1.0, slope)),
            }

    def masses(self):
        """Masses at joints with their displacement, (mass, displacement of each shape)."""
        joints = self.mode.joints
        carried = [(c.mass, f"carriage {i}") for i, c in enumerate(self.drive.carriage)]
        if self.kind == "longitudinal":
            motor = self.drive.motor
            rims = [pulley.inertia / pulley.radius**2 for pulley in self.drive.pulley]
            if motor is not None:
                at_rim = motor.inertia / self.drive.pulley[0].radius ** 2
                if motor.joint_stiffness is None:
                    rims[0] += at_rim
                else:
                    carried.append((at_rim, "motor"))
            carried += [(rims[0], "drive pulley"), (rims[1], "load pulley")]
        resting = np.zeros(self.mode.multiplicity)
        return [(mass, joints.get(name, resting)) for mass, name in carried]

    def modal_mass(self, other):
        """Cross modal mass with another mode of the same kind, shape (multiplicity, multiplicity)."""
        cable = sum(
            (a["u"] * a["weights"]) @ b["u"].T for a, b in zip(self.pieces, other.pieces, strict=True)
        )
        lumped = sum(np.outer(m * a, b) for (m, a), (_, b) in zip(self.masses(), other.masses(), strict=True))
        return self.drive.cable.mass_per_length * cable + lumped

    def stiffness(self):
        """Twice the strain energy, shape (multiplicity, multiplicity)."""
        cable = self.drive.cable
        rigid = (
            cable.axial_rigidity
            if self.kind == "longitudinal"
            else cable.pretension / (1.0 + cable.pretension / cable.axial_rigidity)
        )
        total = rigid * sum((p["slope"] * p["weights"]) @ p["slope"].T for p in self.pieces)
        if "motor" in self.mode.joints:
            twist = self.mode.joints["motor"] - self.mode.joints["drive pulley"]
            total = total + self.drive.motor.joint_stiffness / self.drive.pulley[0].radius ** 2 * np.outer(
                twist, twist
            )
        return total


def sampled(drive, kind="longitudinal"):
    modes = cd.modes(drive, count=MODES)
    return [Sampled(drive, mode, kind) for mode in getattr(modes, kind)[:MODES]]


def drives():
    drawn = [machine(np.random.default_rng(seed), contrast=1e3) for seed in range(12)]
    cable = some_cable(np.random.default_rng(0))
    even_ring = ring_of([0.5] * 8, [0.3 * cable.mass_per_length] * 8, cable)
    return [*(pytest.param(drive, id=f"machine-{i}") for i, drive in enumerate(drawn)), even_ring]


@pytest.mark.parametrize("drive", drives())
def test_shapes_have_unit_modal_mass_the_energy_of_their_frequency_and_obey_the_wave_equation(
    drive, measured
):
    """By quadrature, shapes of one multiple mode included.

    Integral of rho0 u_i u_j ds + sum of m u_i u_j = delta_ij; twice the strain energy over omega^2 likewise.
    u'' = -(omega/c)^2 u on every stretch: slope and displacement turn into each other. Kinetic shares of the
    joints are m u^2, and what is left is the cable's.
    """
    found, density = sampled(drive), drive.cable.mass_per_length
    speed = np.sqrt(drive.cable.axial_rigidity / density)
    apart, waves = [], []
    for i, a in enumerate(found):
        one = np.eye(a.mode.multiplicity)
        apart += [a.modal_mass(b) - (one if a is b else 0.0) for b in found[: i + 1]]
        assert np.max(np.abs(a.stiffness() / a.omega**2 - one)) < 1e-7, f"{a.mode.frequency} Hz"
        turned = [piece["u"] ** 2 + (piece["slope"] * speed / a.omega) ** 2 for piece in a.pieces]
        waves += [np.max(np.ptp(row, axis=1) / np.maximum(row.max(axis=1), 1e-300)) for row in turned]
        shares = a.mode.kinetic_shares
        assert sum(shares.values()) == pytest.approx(1.0, abs=1e-12)
        assert min(shares.values()) > -1e-9
        cable = density * sum(np.mean((piece["u"] ** 2) @ piece["weights"]) for piece in a.pieces)
        assert shares["cable"] == pytest.approx(cable, abs=1e-8)
    mass = max(np.max(np.abs(part)) for part in apart)
    measured(f"modal masses within {mass:.1e}, u^2 + (u'/k)^2 constant to {max(waves):.1e}")
    assert mass < 1e-8
    assert max(waves) < 1e-6


@pytest.mark.parametrize("seed", range(6))
def test_transverse_shapes_have_unit_modal_mass_and_the_right_energy(seed, measured):
    """Strings under T0 with hanging carriages; shapes of one section are orthogonal."""
    rng = np.random.default_rng(seed)
    drive = uneven_machine(rng, contrast=100.0)
    drive = replace(
        drive, carriage=tuple(replace(c, guided=bool(rng.random() < 0.3)) for c in drive.carriage)
    )
    found = sampled(drive, "transverse")
    measured(f"energies within {max(abs(a.stiffness()[0, 0] / a.omega**2 - 1.0) for a in found):.1e}")
    for i, a in enumerate(found):
        assert a.stiffness()[0, 0] / a.omega**2 == pytest.approx(1.0, abs=1e-7)
        for b in found[: i + 1]:
            if (a.mode.span, a.mode.section, a.mode.plane) == (b.mode.span, b.mode.section, b.mode.plane):
                assert a.modal_mass(b)[0, 0] == pytest.approx(float(a is b), abs=1e-8)


@pytest.mark.parametrize(
    "name", ["dissertation-1", "dissertation-2", "dissertation-transporter", "printer-belt"]
)
def test_pulleys_and_carriages_obey_their_equations_of_motion(name, measured):
    """Eq. (3.9) and (3.16): -omega^2 m u = EA (slope after - slope before); the cable sticks to the rims."""
    drive = cd.load_drive(name, overrides=["layout.gravity=0"]).listed
    found = sampled(drive)
    imbalances = [pair for one in found for pair in imbalance(drive, one)]
    measured(f"forces on the joints in balance to {max(share for _, share in imbalances):.1e}")
    for joint, share in imbalances:
        assert share < 1e-7, joint
    for mode in (one.mode for one in found):
        for span, first, last in (("upper", "drive", "load"), ("lower", "load", "drive")):
            ends = mode.shape(span, [0.0, drive.span_length])
            rims = np.column_stack([mode.joints[f"{end} pulley"] for end in (first, last)])
            np.testing.assert_allclose(ends, rims, atol=1e-12 * np.max(np.abs(ends) + 1))


def imbalance(drive, found):
    """Each joint with the force that its equation of motion leaves, over the largest in the cable."""
    rigidity = drive.cable.axial_rigidity
    upper = [p for p in found.pieces if p["span"] == "upper"]
    lower = [p for p in found.pieces if p["span"] == "lower"]
    rims = [p.inertia / p.radius**2 for p in drive.pulley]
    if drive.motor is not None and drive.motor.joint_stiffness is None:
        rims[0] += drive.motor.inertia / drive.pulley[0].radius ** 2
        holding = drive.motor.holding_stiffness or 0.0
        rims[0] -= holding / drive.pulley[0].radius ** 2 / found.omega**2  # it pulls with -k u
    forces = {
        "drive pulley": (rims[0], upper[0]["ends"][0] - lower[-1]["ends"][1]),
        "load pulley": (rims[1], lower[0]["ends"][0] - upper[-1]["ends"][1]),
    }
    for i, c in enumerate(drive.carriage):
        pieces = upper if c.span == "upper" else lower
        after = sum(other.position <= c.position for other in drive.carriages_on(c.span))
        jump = pieces[after]["ends"][0] - pieces[after - 1]["ends"][1]
        forces[f"carriage {i}"] = c.mass, jump
    scale = rigidity * max(np.max(np.abs(p["slope"])) for p in found.pieces)
    for joint, (mass, jump) in forces.items():
        left = -(found.omega**2) * mass * found.mode.joints[joint]
        yield joint, np.max(np.abs(left - rigidity * jump)) / scale


def test_shape_beyond_the_mode_is_zero_and_at_joints_the_joints():
    """A transverse mode lives on its own span and section alone, where sag couples none."""
    drive = cd.load_drive("dissertation-transporter", overrides=["layout.gravity=0"]).listed
    s = np.linspace(0.0, drive.span_length, 50)
    for mode in cd.modes(drive, count=12).transverse:
        other = {"upper": "lower", "lower": "upper"}[mode.span]
        assert not np.any(mode.shape(other, s))
        start, end = mode.section
        outside = (s < start) | (s > end)
        assert not np.any(mode.shape(mode.span, s[outside]))
        assert np.any(mode.shape(mode.span, s[~outside]))


@pytest.mark.parametrize("name", ["camera-line", "ropeway", "printer-idlers"])
def test_spans_move_at_their_ends_as_the_rims_that_they_meet(name):
    """Straight and hanging: the displacement along at both ends is the rim's along the rope itself."""
    drive = as_routes(cd.load_drive(name).listed)
    for span, own in zip(drive.free_spans, statics_of(drive).stretches, strict=True):
        if not (span.start.sense and span.end.sense):
            continue
        cosine = [force[0] / np.hypot(*force) for force in (own[0].force, own[-1].end_force)]
        for mode in cd.modes(drive, count=4).longitudinal:
            whole = mode.shape(span.name, np.linspace(0.0, span.length, 400))[0]
            rims = [place.radius * mode.joints[place.name][0] for place in (span.start, span.end)]
            rims = np.multiply(rims, cosine)
            np.testing.assert_allclose(np.abs(whole[[0, -1]]), np.abs(rims), atol=1e-9 * np.abs(whole).max())
