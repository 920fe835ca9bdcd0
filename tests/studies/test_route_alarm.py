"""The alarm for a motion of a machine with routes, against the loop's alarm and an integrator of its own."""

from dataclasses import replace
from math import pi, sqrt
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import cabledrive as cd
from cabledrive.mechanics.holding import DRIVE_PULLEY, FREE, LOAD_PULLEY
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.response import responses
from cabledrive.mechanics.rest import rest_state
from cabledrive.modal.mode import LONGITUDINAL, TRANSVERSE
from cabledrive.modal.route_network import network_of_routes
from cabledrive.modal.spectrum import Spectrum
from cabledrive.modal.tuning import first_modes, tuned_pretension, tuning_factor
from cabledrive.parameters.drive_file import drive_from_text, packaged_text
from cabledrive.reduction import sagging_model as sagging
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.stretch_runs import extremes_run
from cabledrive.reduction.stretches import StretchModel, new_stretch_state, numbers_of
from cabledrive.reduction.threshold import joint_threshold, mode_thresholds
from cabledrive.reduction.waves import waves_of
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start
from cabledrive.studies import motion_stages
from cabledrive.studies.alarm import alarm
from cabledrive.studies.excited_modes import lines_of
from cabledrive.studies.machine_pairs import machine_pairs
from cabledrive.studies.motion_snapshot import longitudinal_of
from cabledrive.studies.planned_motion import PlannedMotion, read_motion
from cabledrive.trajectories import pulse
from command import answer, refusal
from network_samples import as_route, as_routes, without_gravity
from oracles.alarm_validation import true_motion
from resonance_samples import damped, damped_loop

PRINTER = Path(__file__).parent.parent / "parameters" / "routes" / "printer.toml"


def straight_modes(network):
    """The first modes along and across of its ropes without their sag."""
    first = Spectrum(network_of_routes(network, hanging=False)).first(
        {LONGITUDINAL: 4, TRANSVERSE: 4}, distinct=True
    )
    return first[LONGITUDINAL][0], first[TRANSVERSE][0]


def damped_route(loop):
    route = as_route(loop)
    return replace(
        route,
        cable=replace(route.cable, transverse_damping=2.0, axial_damping=0.02),
        pulley=tuple(replace(pulley, viscous_friction=2e-5) for pulley in route.pulley),
    )


@pytest.mark.parametrize(("share", "number"), [(0.5, 1), (2.0, 1), (4.0, 1), (2.0, 6)])
def test_a_loop_as_a_route_has_the_alarm_of_the_loop(share, number, measured):
    """Of the torque that the file of the loop counts as the rope runs."""
    loop = damped_loop()
    loop = replace(loop, cable=replace(loop.cable, pretension=loop.cable.pretension / number**2))
    route = damped_route(loop)
    pairs = cd.resonance(route)
    time = np.linspace(0.0, 1.5, 15_001)
    torque = share * pairs.threshold_here * np.sin(2.0 * np.pi * pairs.pulley_frequency * time)
    motion = PlannedMotion(time=time, torque=torque)
    reverse = PlannedMotion(time=time, torque=-torque)  # of a pulley that the rope passes clockwise
    expected, found = (
        alarm(one, own, floor=1e-5 / number**3) for one, own in ((loop, motion), (route, reverse))
    )
    assert found.verdict == expected.verdict
    first = [max(one.largest for one in who.modes if one.number == number) for who in (expected, found)]
    measured(f"{share} of the threshold: {1e3 * first[0]:.4g} mm, as a route {1e3 * first[1]:.4g} mm")
    if share > 1.0:
        assert first[1] == pytest.approx(first[0], rel=0.05)
    nearest = found.passages[0]
    assert nearest.kind == "1:2"
    assert nearest.amplitude == pytest.approx(share, rel=0.02)
    assert not nearest.passes


def test_a_mode_that_carriages_bring_into_resonance_is_looked_at():
    """Eight hang on each span: the seventh mode is at 1:2, where a string alone has its fourth."""
    places = (np.arange(8) + 0.5 + 0.2 * np.cos(np.arange(8))) / 8.0
    loop = damped_loop()
    loop = replace(
        loop,
        cable=replace(loop.cable, pretension=1.1),
        carriage=tuple(
            cd.Carriage(mass=8e-4, position=place, span=span, guided=False)
            for span in ("upper", "lower")
            for place in places
        ),
    )
    route = damped_route(loop)
    pair = cd.resonance(route, torque=1.0).pairs[0]
    time = np.linspace(0.0, 60.0 / pair.longitudinal_hz, 3601)
    torque = 4.0 * pair.threshold_torque * np.sin(2.0 * np.pi * pair.longitudinal_hz * time)
    motion = PlannedMotion(time=time, torque=torque)
    reverse = PlannedMotion(time=time, torque=-torque)  # of a pulley that the rope passes clockwise
    known, found = alarm(loop, motion, floor=1e-9), alarm(route, reverse, floor=1e-9)
    grown = [max(who.modes, key=lambda mode: mode.largest) for who in (known, found)]
    assert grown[0].number == grown[1].number > 4
    growth = [np.log(own.largest / 1e-9) for own in grown]
    assert growth[0] == pytest.approx(growth[1], rel=0.05)


@pytest.mark.parametrize("gap", [1e-4, 3e-2])
def test_carriages_on_rails_may_stand_close_together(gap):
    """What lies between has its first mode where the longest stretch has its fortieth, or is one more."""
    loop = cd.load_drive("dissertation-transporter", overrides=["cable.transverse_damping=2"]).listed
    own = loop.carriage[0]
    loop = replace(loop, carriage=(own, replace(own, position=own.position + gap)))
    spans = {pair.section for pair in cd.resonance(loop, torque=0.01).pairs if pair.span == "upper"}
    assert len(spans) == 2 + (gap > 0.75 / 40.0)


def swept_model(scale):
    """One longitudinal mode that swings freely and two coupled transverse ones."""
    matrix = np.array([[240.0, 80.0], [80.0, 160.0]])
    return StretchModel(
        natural=np.array([60.0]),
        damping=np.zeros((1, 1)),
        torque_shape=np.zeros((1, 1)),
        motions=np.zeros((0, 1)),
        transverse=scale * np.array([[30.0, 33.0]]),
        mass=np.ones((1, 2)),
        loss=np.array([[0.3, 0.5]]),
        sag=np.zeros((1, 2)),
        coupling=np.stack([matrix, 0.0 * matrix])[:, None],
        square=np.zeros((1, 1, 2, 2)),
        carried=np.zeros((1, 1)),
        probes=np.array([[[1.0, 0.6], [0.7, -0.8]]]),
        tension=np.zeros((0, 2)),
        raised=np.zeros((0, 1)),
        direct=np.zeros((2, 1, 2)),
        bend=np.zeros((1, 1, 2)),
        softness=np.zeros(1),
        shoved=np.array([[[1.0], [0.5]]]),
        friction_shape=np.zeros((0, 1)),
    )


def test_a_sweep_through_resonance_grows_as_a_general_integrator_has_it(measured):
    """1:2 and sum type at once, frequencies changing, damping: DOP853 to 1e-10."""
    steps, models = 12000, (swept_model(0.97), swept_model(1.02))
    h, time = 4.0 / steps, np.linspace(0.0, 4.0, steps + 1)
    stages = list(motion_stages.stages_along(models, time[:-1] / 4.0, np.full((steps, 1), 1e-3)))
    state, done = new_stretch_state(numbers_of(models[0], h)), 0
    state.modes[0] = 1.0
    top, seen = np.zeros((1, 2)), (np.zeros((1, 2)), np.zeros((1, 2)), np.ones(1), np.zeros((0, 1)))
    for model, torque in stages:
        extremes_run(numbers_of(model, h), state, torque, done, 0.0, (top, *seen))
        done += len(torque)
    matrix, loss, push = np.array([[240.0, 80.0], [80.0, 160.0]]), np.array([0.3, 0.5]), np.array([1.0, 0.5])

    def rate(t, y):
        omega = (0.97 + 0.05 * t / 4.0) * np.array([30.0, 33.0])
        pull = np.cos(60.0 * t) * matrix
        return np.append(y[2:], 1e-3 * push - loss * y[2:] - omega**2 * y[:2] - pull @ y[:2])

    fine = solve_ivp(
        rate,
        (0.0, 4.0),
        np.zeros(4),
        t_eval=time,
        method="DOP853",
        rtol=1e-10,
        atol=1e-14,
        max_step=0.01,
    )
    expected = np.abs(np.array([[1.0, 0.7], [0.6, -0.8]]) @ fine.y[:2])
    growth = expected.max() / expected[:, fine.t < 0.2].max()
    measured(f"grown {growth:.1f} times; ratio {top.max() / expected.max():.5f}")
    assert growth > 10.0
    assert top.max() == pytest.approx(expected.max(), rel=0.01)


def test_a_move_of_the_head_passes_a_resonance_that_the_machine_at_rest_has_not():
    """The first string mode of one strand falls from above to below half the longitudinal mode."""
    machine = cd.load_drive(str(PRINTER)).listed
    time = np.linspace(0.0, 0.4, 2001)
    head = 0.06 + 0.30 * time / 0.4
    motion = PlannedMotion(time=time, torque=np.zeros(time.size), places={"head.x": head})
    found = alarm(machine, motion)
    passing = [one for one in found.passages if one.passes and one.kind == "1:2"]
    assert any(one.span in ("left clamp to motor", "upper idler to right clamp") for one in passing)
    still = alarm(machine, replace(motion, places={"head.x": np.full(time.size, 0.2)}))
    assert not any(one.passes for one in still.passages)
    assert found.poses == 13
    assert still.poses == 1


def test_a_smooth_move_excites_nothing_though_modes_enter_and_leave_the_list():
    """20 mm in 0.15 s, no mode below 75 Hz: what is there is the floor, in six modes of two planes."""
    machine, way = cd.load_drive("printer-idlers"), pulse(-0.02, 0.15, 0.05, pulses=2, order=9)
    time = np.linspace(0.0, way.duration, 2001)
    place, _, rate = way(time, 2)
    places, torque = {"head.x": 0.2 + place}, 0.0386 * rate / np.abs(rate).max()
    found = alarm(machine, PlannedMotion(time=time, torque=torque, places=places))
    assert found.verdict == "safe"
    assert found.largest_transverse < 6e-5, found.largest_transverse


def test_the_command_reads_places_and_torques_of_other_motors(tmp_path):
    file = tmp_path / "motion.csv"
    file.write_text("time [s],torque [N m],head.x [mm]\n0,0.01,150\n0.05,-0.01,180\n0.1,0,180\n")
    found = answer("resonance", str(PRINTER), "--motion", str(file))["motion"]
    assert found["verdict"] in ("safe", "dangerous", "unknown")
    assert found["limit"] == 5e-4
    assert any("places of bodies given" in line for line in found["assumptions"])
    assert read_motion(file, cd.load_drive(str(PRINTER)).listed).places["head.x"][1] == pytest.approx(0.18)
    wrong = tmp_path / "wrong.csv"
    wrong.write_text("time [s],torque [N m],tail.x [m]\n0,0,0\n1,0,0\n")
    assert "tail.x" in refusal("resonance", str(PRINTER), "--motion", str(wrong))
    two = tmp_path / "two.csv"
    two.write_text("time [s],torque [N m],torque motor b [N m]\n0,0,0\n1,0,1\n")
    corexy = cd.load_drive(str(PRINTER.parent / "corexy.toml")).listed
    assert read_motion(two, corexy).torques["motor b"][1] == 1.0


def test_a_place_that_the_machine_cannot_take_is_refused_in_one_line():
    machine = cd.load_drive(str(PRINTER)).listed
    time = np.linspace(0.0, 0.1, 11)
    with pytest.raises(cd.InputRefused, match="give places as columns"):
        alarm(machine, PlannedMotion(time=time, torque=np.full(11, 50.0)))


# --- Pairs near internal resonance of machines with routes, against those of a loop
UPPER = f"{DRIVE_PULLEY} to {LOAD_PULLEY}"


@pytest.mark.parametrize("name", ["tuned", "linear-axis", "slack axis", "elevator", "ropeway"])
def test_pairs_have_the_thresholds_of_the_averaged_equations(name, measured):
    """Of the pulley mode, section by section; modes, shapes and losses share no code."""
    settings = ["cable.transverse_damping=2", "pulley.1.viscous_friction=1e-3"]
    if name == "slack axis":
        name, settings = "linear-axis", [*settings, "cable.pretension=20 N"]
    if name == "ropeway":  # else its rope goes slack first
        settings = ["cable.transverse_damping=0.2", "cable.pretension=700 kN"]
    loop = damped_loop() if name == "tuned" else cd.load_drive(name, overrides=settings).listed
    loop = without_gravity(loop)
    known, off = cd.resonance(loop, torque=1.0), []
    for one in [p for p in known.pairs if p.tuning and p.threshold_torque][:8]:  # lowest first
        model = autoparametric_model(loop, number=one.numbers[0], at_rest=True)
        own = next(
            torque
            for torque, mode in zip(mode_thresholds(model), model.modes, strict=True)
            if mode.span == one.span and np.allclose(mode.section, one.section)
        )
        off.append(abs(float(own) / one.threshold_torque - 1.0))
    measured(f"{name}: thresholds apart by {100.0 * max(off):.2g} % at most")
    assert max(off) < 0.01
    growing = [p for p in known.pairs if p.threshold_torque]
    assert len({one.longitudinal_hz for one in growing}) > (name != "tuned")
    if name == "elevator":  # of its second longitudinal mode, far below that of the pulley mode
        lowest = min(one.threshold_torque for one in growing)
        verdicts = [cd.resonance(one, torque=1.1 * lowest).verdict for one in (loop, as_route(loop))]
        assert verdicts == ["resonant", "resonant"]


def test_a_carriage_that_hangs_is_not_damped_as_its_cable_is(measured):
    """The amplitude of a simulated pluck decays by the cable's share of what moves, in both models."""
    gamma, mass = 6.0, 2e-3
    drive = replace(without_gravity(cd.load_drive("dissertation-1").listed), carriage=())
    drive = replace(
        drive,
        cable=replace(drive.cable, transverse_damping=gamma),
        carriage=(cd.Carriage(mass=mass, position=0.4, guided=False),),
    )
    model = autoparametric_model(drive, number=1)
    network = network_of(as_route(drive))
    along, across = straight_modes(network)
    waves = waves_of(
        network, along[:1], [next(mode for mode in across if mode.span == UPPER and mode.plane == "w")]
    )
    mode = next(
        own for own in cd.modes(drive, count=4).transverse if own.span == "upper" and own.plane == "w"
    )
    stretch = 1.0 + drive.cable.prestrain
    run = cd.simulate(
        drive,
        0.5,
        start=Start(plucks=(Pluck(height=1e-5, shape=lambda x: mode.shape("upper", x / stretch)[0]),)),
        scheme=Scheme(segments=60),
    )
    energy = run.channel("rope_energy") + run.channel("strain_energy")
    rate = -np.polyfit(run.time, np.log(energy), 1)[0]
    measured(f"decay {rate:.4f} 1/s, {gamma * model.cable_share[0]:.4f} and {waves.losses[1][0]:.4f}")
    assert rate == pytest.approx(gamma * model.cable_share[0], rel=0.02)
    assert waves.losses[1][0] == pytest.approx(gamma * model.cable_share[0], rel=1e-3)


def test_verdict_changes_at_the_lowest_threshold():
    drive = cd.load_drive("serpentine")
    found = cd.resonance(drive)
    assert found.threshold_here == min(p.threshold_torque for p in found.pairs if p.threshold_torque)
    above, below = (cd.resonance(drive, torque=share * found.threshold_here) for share in (1.01, 0.3))
    assert (above.verdict, below.verdict) == ("resonant", "safe")
    assert found.detuning == found.frequency_ratio - 0.5
    with pytest.raises(cd.InputRefused, match="load torque"):
        cd.resonance(drive, load_torque=1.0)


def test_a_threshold_of_a_mode_that_is_mostly_across_is_in_doubt():
    """By the strain that ropes along hold in the mode that excites; a line on the lowest threshold."""
    for name in ("serpentine", "printer-idlers"):
        found = machine_pairs(cd.load_drive(name).listed)
        along = {
            mode.frequency: sum(own for (_, way), own in mode.strain_by_span.items() if way == "along")
            for mode in found.modes.modes
        }
        weak = [(torque, at) for at, torque in found.thresholds if torque and along[at] < 0.5]
        said = [one for one in found.doubt if "mostly across" in one]
        assert len(said) == len(weak[:1])
        for one in said:
            assert one.startswith(f"from {min(weak)[0]:.4g} N m at {min(weak)[1]:.4g} Hz on")


def test_a_route_is_tuned_as_the_loop_that_it_is():
    """Whose pulleys stand where they do at any pretension."""
    loop = damped(2.0, 5.0)
    layout = replace(loop.layout, gravity=0.0, span_length=None, pulley_distance=loop.pulley_distance)
    loop = replace(loop, cable=replace(loop.cable, pretension=5.0), layout=layout)
    known, found = cd.resonance(loop, torque=0.01), cd.resonance(as_route(loop), torque=0.01)
    assert found.tuned_pretension == pytest.approx(known.tuned_pretension, rel=1e-5)
    assert found.threshold_torque == pytest.approx(known.threshold_torque, rel=2e-3)


@pytest.mark.parametrize(("name", "span"), [("dissertation-2", 0), ("printer-belt", 1)])  # without a carriage
def test_a_route_under_gravity_is_tuned_where_the_formula_of_the_straight_rope_has_it(name, span, measured):
    """Within the share by which sag moves it; two modes veer there, and the ratio of the belt jumps."""
    drive = cd.load_drive(name).listed
    known = tuned_pretension(drive)
    found = drive.cable.pretension * tuning_factor(drive.machine, span)
    measured(f"{found:.5g} N for {known:.5g}")
    assert found == pytest.approx(known, rel=5e-3)


@pytest.mark.parametrize(("share", "grows"), [(0.9, False), (1.1, True)])
def test_at_the_tuned_pretension_of_a_printer_a_belt_grows_above_the_threshold_alone(share, grows, measured):
    """In time, on ropes in segments: the belt plucked by a ten-thousandth of a millimetre."""
    drive = cd.load_drive("printer-idlers")
    smooth = {
        part: tuple(replace(own, coulomb_friction=0.0) for own in getattr(drive, part))
        for part in ("body", "pulley", "motor")
    }
    found = cd.resonance(drive, torque=0.01)
    tuned = replace(drive, cable=replace(drive.cable, pretension=found.tuned_pretension), **smooth)
    pulley, span = cd.resonance(tuned, torque=0.01).pulley_frequency, found.nearest_span
    run = cd.simulate(
        tuned,
        2.5,
        torque=Sine(amplitude=share * found.threshold_torque, frequency=pulley),
        start=Start(plucks=(Pluck(height=1e-7, span=span, shape="half-sine"),)),
        scheme=Scheme(segments=40),
        recording=Recording(rate=2000.0),
    )
    across = np.abs(run.midpoint(span)[:, 2])
    early, late = (across[(run.time > at) & (run.time < at + 0.2)].max() for at in (1.0, 2.3))
    measured(f"{share} of the threshold: {late / early:.3g} times as large after 1.3 s")
    assert (late > early) == grows


def test_remedies_of_a_machine_with_routes_make_it_safe():
    options = ["resonance", "printer-idlers", "--torque", "5 mN m", "--set"]
    found = answer(*options, "cable.pretension=10.5 N")
    assert found["verdict"] == "resonant"
    raised, lowered, limited = found["remedies"]
    assert raised["value"] > 10.5 > lowered["value"]
    for change in (raised, lowered):
        assert answer(*options, f"cable.pretension={change['value']!r} N")["verdict"] == "safe"
    assert limited["value"] < 5e-3
    slack = answer(*options[:-3], "--torque", "0.1 N m")
    assert slack["verdict"] == "close"
    assert "goes slack" in slack["reasons"][-1]
    weighty = cd.resonance(cd.load_drive("lift-2-to-1"))
    assert "weights and springs" in weighty.missing["tuned_pretension"]


LIFT = (
    packaged_text("lift-2-to-1")
    + """
[excitation]
torque_ripple = 0.5
orders = ["sheave=traction sheave*NUMBER", "rails=car.y/5m"]
speed = "car.y=0.2m/s:1m/s"
"""
)


@pytest.mark.parametrize(("number", "verdict"), [(1, "safe"), (6, "resonant")])
def test_an_order_excites_the_pairs_whose_frequency_it_reaches(number, verdict):
    """At 1 m/s of the car, 2 m/s of the rope, the sheave of 0.16 m turns 1.989 times a second."""
    found = cd.resonance(drive_from_text(LIFT.replace("NUMBER", str(number))))
    assert found.verdict == verdict
    excited = [pair.longitudinal_hz for pair in found.pairs if pair.threshold_torque is not None]
    assert any(hertz <= number * 2.0 / (2 * pi * 0.16) for hertz in excited) == (verdict == "resonant")
    assert found.torque == pytest.approx(400.0)


def test_orders_without_a_ripple_have_no_amplitude_to_judge():
    text = LIFT.replace("NUMBER", "6").replace("torque_ripple = 0.5\n", "")
    assert cd.resonance(drive_from_text(text)).verdict == "unknown"


# --- Thresholds of pairs: the 1:2 formula of the averaged equations, the sum type by Floquet's theorem
@pytest.mark.parametrize("pretension", [3.15, 3.28377, 3.5])
def test_one_to_two_pairs_have_the_thresholds_of_the_averaged_equations(pretension):
    drive, number = damped(2.0, 5.0), 1
    drive = replace(drive, cable=replace(drive.cable, pretension=pretension))
    model = autoparametric_model(drive, number=number, at_rest=True)
    expected = mode_thresholds(model)[0]
    pairs = [p for p in cd.resonance(drive, torque=1.0).pairs if p.tuning and p.span == "upper"]
    found = next(p for p in pairs if p.numbers == (number, number))
    assert found.threshold_torque == pytest.approx(expected, rel=2e-3), found


def test_a_sum_pair_grows_above_its_threshold_and_not_below(measured):
    """Two oscillators under q = Q cos Wt: the largest Floquet multiplier crosses one at the threshold.

    Of two spans one carries a hanging mass: its pieces are strained unevenly.
    """
    settings = ["cable.transverse_damping=4", "pulley.1.viscous_friction=2e-5", "cable.pretension=3"]
    settings.append("carriage=[{mass=3e-4, position=0.37, guided=false}]")
    drive = cd.load_drive("dissertation-2", overrides=settings).listed
    network = network_of(as_routes(drive))
    along, across = straight_modes(network)
    upper = [m for m in across if (m.span, m.plane) == (network.drive.spans[0], "w")]
    waves = waves_of(network, along[:1], upper[:2])
    own, mass = np.array([2.0 * pi * mode.frequency for mode in upper[:2]]), np.ones(2)
    loss, coupled = waves.losses[1], float(waves.couplings[0, 0, 1])
    forcing = float(own.sum()) + 0.5
    kappa = abs(coupled) / (4 * sqrt(mass[0] * mass[1] * own[0] * own[1]))
    least = sqrt(0.25 * loss[0] * loss[1] * (1 + 4 * 0.5**2 / (loss[0] + loss[1]) ** 2))

    def largest(amplitude):
        def rates(t, y):
            pull = coupled * amplitude * np.cos(forcing * t) * y[[1, 0]] / mass
            return np.concatenate((y[2:], -loss * y[2:] - own**2 * y[:2] - pull))

        period = 2 * pi / forcing
        columns = [
            solve_ivp(rates, (0, period), start, rtol=1e-10, atol=1e-13).y[:, -1] for start in np.eye(4)
        ]
        return float(np.max(np.abs(np.linalg.eigvals(np.array(columns).T))))

    below, above = largest(0.97 * least / kappa), largest(1.03 * least / kappa)
    measured(f"largest multiplier {below:.4f} at 0.97, {above:.4f} at 1.03 of the threshold")
    assert below < 1.0 < above


# --- A motion that ends before the pulley mode has turned once is judged like any other
def test_a_motion_of_a_millisecond_is_judged(tmp_path):
    """A ninth of a period cannot excite: what is there at the end is the floor and hardly more."""
    path = tmp_path / "move.csv"
    path.write_text("time [ms],torque [mN m],pretension [N],carriage [mm]\n0,0,3.30,250\n1,4.2,3.30,250\n")
    found = alarm(cd.load_drive("dissertation-transporter").listed, read_motion(path), floor=1e-5, limit=5e-4)
    largest = max(mode.largest for mode in found.modes)
    assert found.verdict == "safe"
    assert 1e-5 < largest < 1.2e-5, largest
    assert all(0.0 <= mode.time <= 1e-3 for mode in found.modes)


def test_a_motion_beyond_any_number_is_not_a_defect(tmp_path):
    """Growth between two edges that no double holds; the torque of such a motion is no machine's."""
    path = tmp_path / "move.csv"
    path.write_text("time [s],torque [N m]\n" + "".join(f"{k / 100},{1e9 * (-1) ** k}\n" for k in range(100)))
    with pytest.raises(cd.NotComputed, match="diverges: plan a smaller or a slower motion"):
        alarm(cd.load_drive("dissertation-2").listed, read_motion(path), floor=1e-5, limit=5e-4)


# --- The alarm where a span weighs as much as a rim: modes that are not kept carry the torque's strain
LENGTH, DENSITY = 10.0, 0.1


def level_loop():
    """A level loop of 500 N whose span weighs as much as either rim."""
    rim = cd.Pulley(radius=0.1, inertia=DENSITY * LENGTH * 0.1**2)
    return cd.Drive(
        name="level",
        kind="loop",
        cable=cd.Cable(
            youngs_modulus=1e10,
            area=1e-5,
            mass_per_length=DENSITY,
            pretension=500.0,
            transverse_damping=0.5,
            axial_damping=10.0,
        ),
        layout=cd.Layout(span_length=LENGTH),
        pulley=(rim, rim),
    )


@pytest.mark.parametrize("mode", [2, 3])
def test_torque_at_a_mode_of_a_heavy_span_shakes_it_as_far_as_in_the_full_model(mode, measured):
    """A cosine, which leaves the loop where it is; with rims that move the cable level 0.73 and 0.32 mm."""
    drive = level_loop()
    state = rest_state(drive)
    tension = np.mean([piece.mean_tension for piece in state.stretches])
    omega = mode * pi / LENGTH * np.sqrt(tension / (DENSITY / (1.0 + drive.cable.prestrain)))
    time = np.linspace(0.0, 3.0, 6000)
    motion = PlannedMotion(time=time, torque=state.holding_torque + np.cos(omega * time))
    found = alarm(drive, motion, floor=1e-5, limit=3e-3)
    highest, rng = 1.5 * omega / (2 * pi), np.random.default_rng(0)
    true = true_motion(drive, motion, floor=1e-5, modes=6, highest=highest, rng=rng).driven
    measured(f"mode {mode}: {1e3 * found.largest_transverse:.3f} mm, full model {1e3 * true:.3f} mm")
    assert found.largest_transverse == pytest.approx(true, rel=0.05)


@pytest.mark.parametrize("pushed", [DRIVE_PULLEY, LOAD_PULLEY])
def test_static_strain_is_that_of_a_ring_of_beads(pushed):
    """A force at one rim, each bead accelerating alike; numpy alone."""
    drive = level_loop()
    cable, network = drive.cable, network_of(as_routes(drive), motor=FREE)
    mass = np.full(100, cable.mass_per_length * drive.layout.span_length / 50)
    mass[::50] += [one.inertia / one.radius**2 for one in drive.pulley]
    force = np.where(np.arange(mass.size) == (0 if pushed == DRIVE_PULLEY else 50), 1.0, 0.0)
    out = force - mass / mass.sum()  # what must leave each bead as a difference of tensions
    tension = -np.cumsum(out)  # of the piece behind each bead, up to a constant
    strain = (tension - tension.mean()) / (cable.youngs_modulus * cable.area)  # the ring closes
    force = network.motion.dense(-0.1 * network.motion.angle(int(pushed == LOAD_PULLEY)))
    found = sagging._static(waves_of(network, [], []), sagging.rigid_motions(network), force)[0][0]
    beads = strain.reshape(2, 50) / (1.0 + drive.cable.prestrain)
    middles = (np.arange(50) + 0.5) / 50
    expected = [np.interp(waves_of(network, [], []).inside, middles, own) for own in beads]
    np.testing.assert_allclose(found, expected, atol=0.02 * np.abs(found).max())


def test_a_torque_at_the_pulley_mode_is_a_line_of_the_tensions_at_its_frequency():
    drive = level_loop()
    network = network_of(as_routes(drive), motor=FREE)
    along = longitudinal_of(network, 2)
    model, omega = sagging.sagging_model(waves_of(network, list(along), []), []), 2 * pi * along[0].frequency
    h = 2.0 * pi / omega / 40.0
    torque = np.sin(omega * h * np.arange(4000))[:, None]
    history = motion_stages.integrate([(model, torque)], h, history=True)[1]
    size, found, duration = lines_of(history, model, h)
    assert found[size.argmax()] == pytest.approx(omega, abs=2.0 * pi / duration)


def test_two_ropes_side_by_side_have_the_threshold_of_one_of_twice_the_section():
    """Both of a mode between held ends, of which one moves, and of one with a body, which moves both."""
    one = cd.load_drive("serpentine")
    cable = one.cable
    half = {"mass_per_length": cable.mass_per_length / 2, "pretension": cable.pretension / 2}
    thin = replace(cable, given_rigidity=cable.axial_rigidity / 2, youngs_modulus=None, area=None, **half)
    thin = replace(thin, axial_damping=cable.axial_damping / 2)
    two = replace(one, cable=thin, route=tuple(replace(route, ropes=2) for route in one.route))
    found = [
        sorted(p.threshold_torque for p in cd.resonance(m).pairs if p.threshold_torque) for m in (one, two)
    ]
    assert found[0]
    np.testing.assert_allclose(found[1][: len(found[0])], found[0], rtol=1e-6)


def test_a_line_that_friction_holds_does_not_move_without_a_torque():
    """What friction holds in place of a torque shakes the sag no more than in time: not at all."""
    drive, time = cd.load_drive("camera-line").listed, np.linspace(0.0, 10.0, 1001)
    found = alarm(drive, PlannedMotion(time=time, torque=np.zeros(time.size)), limit=1e-3)
    hung = Start(from_equilibrium=True)
    run = cd.simulate(drive, 2.0, start=hung, scheme=Scheme(segments=40), recording=Recording(rate=200.0))
    assert np.ptp(run.midpoint("upper"), axis=0).max() < 1e-12
    assert found.verdict == "safe"
    assert max(mode.driven for mode in found.modes) < 1e-6


def test_modes_near_each_other_grow_together_as_floquets_theorem_has_it(measured):
    """Two longitudinal modes a hundredth apart, coupled by their damping, three across, at one torque."""
    rng, along = np.random.default_rng(3), np.array([60.0, 60.6])
    across, losses = np.array([29.9, 30.2, 31.0]), np.array([0.4, 0.5, 0.3])
    shapes, push = np.array([[1.0, 0.4], [-0.6, 0.8]]), np.array([1.0, 0.7])
    lost = shapes.T @ shapes
    coupling = rng.normal(size=(2, 3, 3))
    coupling = 40.0 * (coupling + coupling.transpose(0, 2, 1))
    stiff = np.diag(along**2) - along[1] ** 2 * np.eye(2) + 1j * along[1] * lost
    waves = SimpleNamespace(
        along=[SimpleNamespace(frequency=w / (2.0 * np.pi)) for w in along],
        across=[SimpleNamespace(frequency=w / (2.0 * np.pi)) for w in across],
        losses=(np.diag(lost), losses),
        forced=lambda number: np.linalg.solve(stiff, push),
        couplings=coupling,
    )
    found = joint_threshold(waves, 1, 1e3)
    period = 2.0 * np.pi / along[1]

    def largest(torque):
        """Largest multiplier over a period of the torque, along modes in their steady motion."""
        swing = np.linalg.solve(stiff, torque * push)

        def rate(t, y):
            z = y.reshape(6, 6)
            q = np.real(swing * np.exp(1j * along[1] * t))
            pull = (
                across[:, None] ** 2 * z[:3] + losses[:, None] * z[3:] + np.tensordot(q, coupling, 1) @ z[:3]
            )
            return np.concatenate([z[3:], -pull]).ravel()

        end = solve_ivp(rate, (0.0, period), np.eye(6).ravel(), method="DOP853", rtol=1e-11, atol=1e-12)
        return np.abs(np.linalg.eigvals(end.y[:, -1].reshape(6, 6))).max()

    share = brentq(lambda share: largest(share * found) - 1.0, 0.5, 2.0)
    measured(f"threshold {found:.4g} N m, {share:.4f} of it by Floquet")
    assert share == pytest.approx(1.0, abs=0.03)


SAGS_AND_DRAGS = """
schema = 1
name = "loop that sags, at 1:2, whose pulley mode meets its own second mode across"
kind = "loop"
layout = {span_length = 4.21244}
motor = {inertia = 1.5285e-6, viscous_friction = 3.5266e-6, holding_stiffness = 0.76558}
pulley = [
    {radius = 0.030749, inertia = 2.6363e-6, viscous_friction = 5.2631e-6},
    {radius = 0.07034, inertia = 1.0306e-3, viscous_friction = 1.2828e-4},
]
[cable]
axial_rigidity = 1363.3
mass_per_length = 1.7532e-3
pretension = 1.2049
transverse_damping = 0.75434
axial_damping = 0.013633
"""


def test_drag_across_ties_the_pulley_mode_to_a_mode_across_beside_it(measured):
    """6.602 and 6.618 Hz, closer than they are damped: their motion is that of the waves, and so it grows."""
    drive = drive_from_text(SAGS_AND_DRAGS)
    found, machine = machine_pairs(drive), drive.plain
    (hertz, together), alone = found.together[0], min(pair.least for pair in found.pairs)
    slack = dict(found.slack)[hertz]
    network = network_of(machine)
    turn = responses(machine, np.array([hertz]), ["drive pulley"])[0, 0, 0]
    modes_along = [mode for mode in found.modes.modes if not mode.clamped and mode.plane != "v"]
    waves = waves_of(network, modes_along, [], hanging=True)
    number = [mode.frequency for mode in modes_along].index(hertz)
    forced = waves.forced(number) @ waves.turns[:, 0]
    by_itself = waves.turns[number, 0] ** 2 / (2.0 * np.pi * hertz * waves.losses[0][number])
    measured(f"turn {abs(forced / turn):.4f} of the waves', by one mode {abs(by_itself / turn):.3f}")
    assert forced == pytest.approx(turn, rel=0.01)
    torque = 1.3 * together
    assert torque < 0.8 * alone
    pluck = Start(plucks=(Pluck(height=1e-7, plane="v", shape="half-sine"),), from_equilibrium=True)
    run = cd.simulate(
        drive,
        45.0,
        torque=Sine(amplitude=torque, frequency=hertz),
        start=pluck,
        scheme=Scheme(segments=12),
        recording=Recording(rate=100.0),
    )
    early, late = (
        np.sqrt(np.mean(run.midpoint("upper")[(run.time > t) & (run.time < t + 2.0), 1] ** 2))
        for t in (25.0, 43.0)
    )
    swing = np.ptp(run.channel("mean tension, upper")[run.time > 35.0]) / 2.0
    tension = np.mean(run.channel("mean tension, upper"))
    measured(f"rate {np.log(late / early) / 18.0:.3f} 1/s; swing {swing / tension:.4f}, {torque / slack:.4f}")
    assert late > 2.0 * early
    assert swing / tension == pytest.approx(torque / slack, rel=0.05)


def test_a_line_that_sags_has_the_pulley_mode_and_the_pairs_of_its_hanging_rope():
    """As loop and as routes; in time it grows under 0.36 N m at 5.16 Hz, off the straight cable's 4.99 Hz."""
    settings = ["pulley.1.coulomb_friction=0", "motor.coulomb_friction=0", "cable.pretension=410 N"]
    line = cd.load_drive("camera-line", overrides=settings).listed
    known, found = (cd.resonance(one, torque=0.36, details=False) for one in (line, as_routes(line)))
    certified = [mode.frequency for mode in cd.modes(line, count=6).longitudinal]
    assert np.min(np.abs(known.pulley_frequency / np.array(certified) - 1.0)) < 1e-9
    assert known.verdict == found.verdict == "resonant"
    np.testing.assert_allclose(known.threshold_here, found.threshold_here, rtol=1e-6)
    assert any("grow together" in words for words in known.left_out)


def test_the_pulley_mode_of_a_finger_does_not_change_with_the_label_of_a_mode():
    """Its joints keep their frequencies whether more strain is along or across the tendon."""
    fingers = (cd.load_drive("tendon-finger", overrides=[f"cable.pretension={n} N"]) for n in (20, 24, 30))
    modes = [first_modes(network_of(as_routes(one)))[0].frequency for one in fingers]
    np.testing.assert_allclose(modes, modes[0], rtol=1e-3)
