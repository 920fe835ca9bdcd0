"""Bodies that travel: hoists against scipy, modes at every position, momentum, and what is refused."""

import numpy as np
import pytest
from scipy.optimize import curve_fit

import cabledrive as cd
from cabledrive.parameters.route import moved
from cabledrive.simulation import Recording, Scheme, Sine, Start
from cabledrive.simulation.travel import PlannedMove
from command import refused
from network_samples import routed
from oracles.by_scipy import Hoist, Traction

TRACTION = """
cable = { axial_rigidity = "100 kN", mass_per_length = "0.1 g/m" }
body = [
    { name = "car", at = ["-0.2 m", "-20 m"], moves = "y", mass = "60 kg" },
    { name = "weight", at = ["0.2 m", "-10 m"], moves = "y", mass = "50 kg" },
]
pulley = [{ name = "sheave", at = ["0 m", "0 m"], radius = "0.2 m", inertia = "1 kg m^2" }]
anchor = [
    { name = "car hook", on = "car", at = ["-0.2 m", "-20 m"] },
    { name = "weight hook", on = "weight", at = ["0.2 m", "-10 m"] },
]
route = [{ name = "rope", path = ["car hook", "-sheave", "weight hook"] }]
motor = { pulley = "sheave", inertia = "0.1 kg m^2" }
"""
HOIST = """
cable = { axial_rigidity = "1 MN", mass_per_length = "0.5 kg/m" }
body = [{ name = "load", at = ["0.25 m", "-30 m"], moves = "y", mass = "50 kg" }]
pulley = [{ name = "drum", at = ["0 m", "0 m"], radius = "0.25 m", inertia = "2 kg m^2" }]
anchor = [{ name = "hook", on = "load", at = ["0.25 m", "-30 m"] }]
route = [{ name = "rope", path = ["-drum", "hook"] }]
motor = { pulley = "drum", inertia = "0.5 kg m^2" }
"""
BLOCK = '{ name = "block", on = "load", at = ["0.35 m", "-30 m"], radius = "0.1 m", inertia = "0.02 kg m^2" }'
TACKLE = HOIST.replace('"0.25 m", "-30 m"', '"0.35 m", "-30 m"').replace(
    '"2 kg m^2" }', f'"2 kg m^2" }}, {BLOCK}'
)
TACKLE = TACKLE.replace('"hook", on = "load", at = ["0.35 m", "-30 m"]', '"beam", at = ["0.45 m", "0 m"]')
TACKLE = TACKLE.replace('"hook"', '"+block", "beam"')
DRUMS = """
cable = { axial_rigidity = "1 MN", mass_per_length = "0.5 kg/m", pretension = "1 kN" }
layout = { gravity = "0 m/s^2" }
pulley = [
    { name = "left", at = ["0 m", "0 m"], radius = "0.2 m", inertia = "2 kg m^2" },
    { name = "right", at = ["10 m", "0 m"], radius = "0.3 m", inertia = "3 kg m^2" },
]
route = [{ name = "rope", path = ["-left", "-right"] }]
motor = [
    { pulley = "left", inertia = "0.5 kg m^2" },
    { pulley = "right", inertia = "0.5 kg m^2" },
]
"""


def rise(whole, duration):
    """Turn and speed of a shaft: the polynomial of Eq. (6.1), written out."""
    powers = np.polynomial.Polynomial([0, 0, 0, 0, 0, 126, -420, 540, -315, 70])
    slope = powers.deriv()

    def turn(t):
        part = min(t / duration, 1.0)
        return whole * powers(part), whole * slope(part) / duration if part < 1.0 else 0.0

    return turn


@pytest.mark.kernel
def test_a_traction_sheave_moves_as_scipy_integrates_it(measured):
    """Car up by 5 m in 1.5 s; the kernels of cabledrive.simulation.travel.kernels,
    cabledrive.simulation.travel.cells, cabledrive.simulation.travel.cells and
    cabledrive.simulation.travel.kernels.

    The rope's own mass, 3 g, is all that differs.
    """
    found = cd.simulate(
        routed(TRACTION),
        2.0,
        travel=PlannedMove(moves={"car.y": 5.0}, rise=1.5),
        scheme=Scheme(segments=2),
        recording=Recording(rate=200.0),
    )
    truth = Traction(100e3, (20.0, 10.0), (60.0, 50.0), 0.2)
    drops = truth.run(rise(-25.0, 1.5), 2.0, found.time)
    elastic = 5.0 * (drops[-1, 0] / 5.0 + 1.0)
    errors = [
        np.abs(found.channel(name) + drop).max()
        for name, drop in zip(("car.y", "weight.y"), drops.T, strict=True)
    ]
    swing = np.abs(drops.sum(axis=1)).max()  # what is not rigid
    measured(
        f"traction sheave against scipy: {max(errors):.1e} m of 5 m, elastic part {swing:.3f} m; budget of "
        f"energy {found.energy_budget_error:.1e}"
    )
    assert abs(elastic) > 1e-3
    assert max(errors) < 1e-3 * swing
    assert found.energy_budget_error < 1e-5
    assert found.channel("creep_loss")[-1] > 0.0


def test_a_heavy_rope_is_wound_as_scipy_winds_material_points(measured):
    """20 of 30 m of a rope of 15 kg with 50 kg on it go onto the drum in 1.8 s; points leave one by one."""
    duration, lift, time = 2.5, 20.0, 1.8
    found = cd.simulate(
        routed(HOIST),
        duration,
        travel=PlannedMove(moves={"load.y": lift}, rise=time),
        scheme=Scheme(segments=16),
        recording=Recording(rate=100.0),
    )
    truth = Hoist(1e6, 0.5, 30.0, 50.0, 0.25, 12)
    places = truth.run(rise(lift / 0.25, time), duration, found.time)
    rigid = 30.0 - np.array([0.25 * rise(lift / 0.25, time)(t)[0] for t in places[:, 0]])
    error = np.abs((30.0 - found.channel("load.y"))[: len(places)] - places[:, 1]).max()
    elastic = np.abs(places[:, 1] - rigid).max()
    measured(
        f"hoist of a heavy rope against material points: {error:.1e} m of 20 m, elastic part {elastic:.2f} "
        f"m; budget of energy {found.energy_budget_error:.1e}"
    )
    assert error < 2e-3 * elastic
    assert found.energy_budget_error < 1e-5


def _chirp(t, mean, slope, size, phase, frequency, rate):
    return mean + slope * t + size * np.cos(phase + 2 * np.pi * (frequency * t + rate * t * t))


def test_the_load_swings_at_its_modes_wherever_it_is(measured):
    """Slowly wound up with a first push: frequency of its place against `modes` there, brake on."""
    drive = routed(HOIST)
    time = 40.0
    found = cd.simulate(
        drive,
        time,
        travel=PlannedMove(moves={"load.y": 20.0}, rise=time),
        start=Start(speeds={"load.y": 0.02}),
        recording=Recording(rate=2000.0),
    )
    tension, errors = found.channel(f"mean tension, {found.spans[0]}"), []
    for middle in (8.0, 20.0, 32.0):
        near = np.abs(found.time - middle) < 0.75
        at, curve = found.time[near] - middle, tension[near] - tension[near].mean()
        place = -30.0 + float(np.interp(middle, found.time, found.channel("load.y")))
        there = cd.modes(moved(drive, {"load.y": place}), count=1, motor="held").longitudinal[0].frequency
        size = 1.4 * curve.std()
        fits = [
            curve_fit(_chirp, at, curve, p0=[0.0, 0.0, size, phase, there, 0.0], full_output=True)
            for phase in (0, 2, 4)
        ]
        best = min(fits, key=lambda fit: float(np.sum(fit[2]["fvec"] ** 2)))
        errors.append(best[0][4] / there - 1.0)
    measured(f"frequency while hoisted against modes there: {', '.join(f'{e:+.1e}' for e in errors)}")
    assert np.abs(errors).max() < 5e-3, errors


def test_rope_runs_from_drum_to_drum_with_its_momentum():
    """Nothing pulls: both drums keep their rim speed while 6 m of rope change sides; no energy is lost."""
    found = cd.simulate(
        routed(DRUMS),
        2.0,
        travel=True,
        start=Start(speeds={"left": -15.0, "right": -10.0}),
        scheme=Scheme(segments=4),
        recording=Recording(rate=100.0),
    )
    for name, speed in (("left", -15.0), ("right", -10.0)):
        np.testing.assert_allclose(found.channel(f"speed of {name}"), speed, rtol=1e-9)
    changed = 0.5 * 6.0 * (0.2 * 15.0) ** 2 / 2.0  # kinetic energy of 3 kg at 3 m/s, from drum to drum
    assert np.ptp(found.channel("body_energy")) < 0.01 * changed
    assert found.energy_budget_error < 1e-6


@pytest.mark.parametrize(
    ("drive", "options", "words"),
    [
        (routed(HOIST), {"travel": PlannedMove(moves={"hook.y": 1.0}, rise=1.0)}, "slides no body"),
        (routed(HOIST), {"travel": PlannedMove(moves={"load.y": 30.5}, rise=1.0)}, "move: "),
        (routed(HOIST), {"travel": PlannedMove(moves={"load.y": 1.0}, rise=0.0)}, "must be above 0"),
        (routed(HOIST), {"travel": PlannedMove(moves={"load.y": 0.0}, rise=1.0)}, "no body moves"),
        (routed(HOIST), {"scheme": Scheme(model="weak")}, "exact law"),
        (routed(HOIST), {"scheme": Scheme(slack="tension-only")}, "leave --tension-only out"),
        (routed(HOIST.split("motor = ")[0].replace("2 kg m^2", "0 kg m^2")), {}, "has no mass"),
        (cd.load_drive("serpentine"), {}, "turns"),
        (cd.load_drive("ropeway-towers"), {}, "carriage"),
        (cd.load_drive("corexy"), {}, "holding_stiffness"),
    ],
)
def test_what_cannot_travel_is_refused_in_one_line(drive, options, words):
    refused(lambda: cd.simulate(drive, 0.1, **({"travel": True} | options)), words)


def test_a_drum_carries_the_rope_that_it_winds(measured):
    """Speed from the balance of energy of a rope that does not stretch, all of which moves with the load."""
    found = cd.simulate(
        routed(HOIST),
        6.0,
        travel=True,
        torque=lambda t: 150.0 * np.minimum(t / 0.5, 1.0),
        recording=Recording(rate=500.0),
    )
    assert "go less far" in found.stopped  # half of the span is wound
    height, turn = found.channel("load.y"), found.channel("drum")
    torques = found.channel("torque on drum")
    work = float(np.sum(0.5 * np.diff(turn) * (torques[1:] + torques[:-1])))
    raised = 50.0 * 9.81 * height[-1] + 0.5 * 9.81 * (30.0 * height[-1] - 0.5 * height[-1] ** 2)
    speed = np.sqrt(2.0 * (work - raised) / (2.5 / 0.25**2 + 50.0 + 0.5 * 30.0))
    last = found.time > found.time[-1] - 0.25  # over an oscillation of the load
    fitted = np.polyval(
        np.polyfit(found.time[last], found.channel("speed of load.y")[last], 1), found.time[-1]
    )
    measured(f"speed with 15 m of rope on the drum: {fitted:.3f} m/s, {speed:.3f} m/s by energy")
    assert fitted == pytest.approx(speed, rel=5e-3)
    assert found.energy_budget_error < 1e-5


@pytest.mark.kernel
def test_a_load_beside_its_drum_stays_where_it_hangs_and_damping_is_in_the_balance():
    """cabledrive.simulation.travel: the weight of a slanting rope pulls its load aside and down."""
    beside = HOIST.replace('["0.25 m", "-30 m"]', '["9 m", "-30 m"]')
    found = cd.simulate(
        routed(beside), 0.1, travel=True, scheme=Scheme(segments=4), recording=Recording(rate=1e3)
    )
    assert np.ptp(found.channel("load.y")) < 1e-6
    damped = TRACTION.replace('"0.1 g/m"', '"0.5 kg/m", axial_damping = "2 kN s"')
    damped = damped.replace('"1 kg m^2"', '"1 kg m^2", viscous_friction = "3 N m s/rad"')
    moving = Start(speeds={"sheave": 2.0})
    found = cd.simulate(routed(damped), 0.05, travel=True, start=moving, scheme=Scheme(segments=4))
    assert found.energy_budget_error < 2e-6
    assert found.channel("viscous_loss")[-1] > 0.1


@pytest.mark.parametrize("duration", [0.3, pytest.param(0.03, marks=pytest.mark.kernel)])
def test_a_loop_travels_as_it_moves(duration, measured):
    """Without weight and strings nothing tells the rope that passes from that which moves in its place."""
    drive = cd.load_drive("dissertation-2", overrides=["layout.gravity=0"])
    asked = {"torque": Sine(amplitude=0.02, frequency=5.0), "recording": Recording(rate=1000.0)}
    asked |= {"scheme": Scheme(segments=16)}
    there, passing = (cd.simulate(drive, duration, travel=travel, **asked) for travel in (False, True))
    apart = np.abs(there.load_angle - passing.channel("load pulley")).max() / np.ptp(there.load_angle)
    measured(f"{apart:.1e} of {np.ptp(there.load_angle):.3g} rad")
    assert apart < 1e-5


def test_rope_that_comes_to_rest_behind_a_moving_block_gives_its_energy_up():
    """Half of a tackle's rope stands still, the other moves at twice the speed of the load."""
    found = cd.simulate(
        routed(TACKLE),
        0.05,
        travel=True,
        start=Start(speeds={"load.y": 2.0, "drum": 16.0, "block": -20.0}),
        scheme=Scheme(segments=2),
    )
    assert found.channel("load.y")[-1] == pytest.approx(0.1, rel=0.01)
    assert found.energy_budget_error < 1e-7
