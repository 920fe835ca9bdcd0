"""The plants of the rig: inertias with friction that sticks, the distributed cable; parts few runs enter."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import cabledrive as cd
from cabledrive.control.observers import FlankLaw
from cabledrive.parameters import load_drive
from cabledrive.reduction.network_axis import as_axis, axis_drive
from cabledrive.reduction.network_chain import network_chains
from cabledrive.rig import Disturbance, Motion, RigOptions
from cabledrive.rig.closed_loop.cable_plant import CableNumbers, CableRun, act, axis_like
from cabledrive.rig.closed_loop.chain_kernels import DIVERGED, WENT_SLACK, PairNumbers
from cabledrive.rig.closed_loop.chain_plant import chain_numbers, linear_step
from cabledrive.rig.closed_loop.loop import close_loop, loop_at_rest, run
from cabledrive.rig.closed_loop.loop_kernels import new_plant_state, plant_step, see_chain, sense_pair
from cabledrive.rig.front_door import own_law
from cabledrive.rig.laws.controllers import DesignSpec, plant_chain
from cabledrive.rig.plant_samples import over, sampled_chain, sampled_loops
from control_chains import INTERVAL, model, row_of, states_of
from network_samples import as_routes
from oracles.readable_plant import ReadablePlant
from rig_runs import loop_of, track

CHAIN = model(4)
LOOSE = replace(CHAIN, coulomb=(0.0,) * 3, offsets=(0.0,) * 3)
COUNT = 2 * np.pi / 10_000
"""Of an encoder [rad]: what a law can see."""


def readable(commands, plant, start=None):
    """States after each command by the plant for the reader, from rest or a state."""
    x, slip, states = [0.0] * 7 if start is None else [float(v) for v in start], 0, []
    if start is not None and start[3] != 0.0:
        slip = int(np.sign(start[3]))
    for u in commands:
        x, slip = plant.moved(x, slip, float(u), INTERVAL)
        states.append(x)
    return np.array(states)


def motion(commands, *, substeps=1, rate=0.0, smooth=False, chain=CHAIN):
    """States after each command, from rest."""
    plant = chain_numbers(chain, INTERVAL, RigOptions(substeps=substeps, smooth_friction=smooth), rate=rate)
    return states_of(plant, commands)


def wave(samples):
    t = INTERVAL * np.arange(samples)
    return 0.12 * np.sin(2 * np.pi * 2.0 * t) + 0.05 * np.sin(2 * np.pi * 9.0 * t)


@pytest.mark.parametrize("rate", [0.0, 2 * np.pi * 1000.0])
def test_motion_hardly_depends_on_the_internal_step(rate, measured):
    """Sticking, breaking loose and turning fall on internal steps: some ten-thousandths of a count."""
    one = motion(wave(1500), rate=rate)
    for substeps in (6, 20):
        other = motion(wave(1500), rate=rate, substeps=substeps)
        worst = np.abs(one - other)[:, :3].max()
        measured(f"{substeps} internal steps move it by {worst:.1e} rad")
        assert 0.0 < worst < 5e-4 * COUNT, f"{substeps} steps: observed {worst:.2e} rad"


@pytest.mark.parametrize("rate", [0.0, 2 * np.pi * 1000.0])
def test_smoothed_friction_is_of_second_order_in_the_internal_step(rate, measured):
    u = wave(1000)
    fine = motion(u, smooth=True, substeps=128, rate=rate)[-1, 2]
    errors = [abs(motion(u, smooth=True, substeps=k, rate=rate)[-1, 2] - fine) for k in (4, 8, 16)]
    measured(", ".join(f"{error:.1e}" for error in errors) + " rad")
    assert errors[0] < 0.02 * COUNT
    assert errors[1] < errors[0] / 3.0
    assert errors[2] < errors[1] / 3.0


@pytest.mark.kernel
@pytest.mark.parametrize("rate", [0.0, 2 * np.pi * 1000.0])
def test_motion_is_that_of_the_equations_written_out(rate):
    """Sticking, letting go and turning under a wave of torque, with and without a torque loop."""
    u = wave(300)[::2]
    theirs = readable(u, ReadablePlant(chain=CHAIN, rate=rate))
    ours = motion(u, rate=rate)
    assert np.ptp(np.sign(theirs[:, 3])) >= 1.0, "the motor neither sticks nor turns"
    assert np.abs(ours - theirs)[:, :3].max() < 1e-4 * COUNT
    np.testing.assert_allclose(ours[:, 3:6], theirs[:, 3:6], atol=1e-4 * np.abs(theirs[:, 3:6]).max())


@pytest.mark.kernel
@pytest.mark.parametrize("speed", [3.0, -3.0])
def test_friction_of_the_load_slows_it_whichever_way_it_turns(speed):
    """c tanh(50 w) of the load, against the equations."""
    chain = replace(LOOSE, coulomb=(0.0, 0.0, 0.02))
    start = np.array([0.0, 0.0, 0.0, speed, speed, speed, 0.0])
    plant = chain_numbers(chain, INTERVAL, RigOptions(smooth_friction=True))
    x = states_of(plant, np.zeros(50), start)[-1]
    theirs, free = (readable(np.zeros(50), ReadablePlant(chain=one), start)[-1] for one in (chain, LOOSE))
    assert abs(x[5]) < abs(free[5])
    np.testing.assert_allclose(x - free, theirs - free, atol=1e-3 * np.abs(theirs - free).max())


@pytest.mark.kernel
@pytest.mark.parametrize("play, slack, start", [(0.03, np.inf, 0.04), (0.0, 0.05, -0.15), (0.03, 0.05, 0.15)])
def test_backlash_and_slack_spans_move_as_the_equations_written_out(play, slack, start):
    """Released from a wound-up joint and cable; contacts fall on internal steps, hence the tolerance."""
    given = np.array([start, 0.0, -start, 0.0, 0.0, 0.0, 0.0])
    plant = chain_numbers(LOOSE, INTERVAL, RigOptions(substeps=40, forbid_slack=False), links=(play, slack))
    ours = states_of(plant, np.zeros(100), given)
    theirs = readable(np.zeros(100), ReadablePlant(chain=LOOSE, play=play, slack=slack), given)
    size = np.abs(theirs).max(axis=0) + 1e-12
    np.testing.assert_array_less(np.abs(ours - theirs).max(axis=0) / size, 2e-3)


@pytest.mark.kernel
def test_friction_of_a_pulley_inside_the_row_holds_as_well():
    inner = replace(CHAIN, coulomb=(0.03, 0.01, 0.0), offsets=(0.0,) * 3)
    held = motion(np.full(200, 0.029), chain=inner)
    assert np.all(held[:, :6] == 0.0)
    # The motor lets go at 0.03 N m and winds the joint up by twice what is beyond, which the pulley holds.
    between = motion(np.full(2000, 0.034), chain=inner)
    assert between[:, 0].max() == pytest.approx(0.008 / CHAIN.stiffness[0], rel=0.2)
    assert between[-1, 3] == 0.0
    assert np.all(between[:, 1:3] == 0.0)


def test_energy_only_falls_without_torque(measured):
    """Stored energy after each sample, from a wound-up cable, until friction holds the motor."""
    chain = replace(CHAIN, offsets=(0.0,) * 3)
    plant = chain_numbers(chain, INTERVAL, RigOptions())
    states = states_of(plant, np.zeros(2000), [0, 0, 0.2, 0, 0, 0, 0])
    stored = 0.5 * (np.diff(states[:, :3]) ** 2 @ plant.stiffness + states[:, 3:6] ** 2 @ plant.inertia)
    rises = np.diff(stored).max() / stored[0]
    measured(f"largest rise in a sample {rises:.1e} of the energy at the start")
    assert rises < 1e-12
    assert stored[-1] < 0.05 * stored[0]
    assert states[-1, 3] == 0.0


DRIVE = load_drive("dissertation-3").listed
SMOOTH = RigOptions(ideal_sensors=True, smooth_friction=True)
SHORT = Motion(angle=20.0, rise=0.2, dwell=0.05)


@pytest.mark.parametrize("law, plant", [("darc-1", 1), ("darc-3", 3), ("darc-4-damped", 4)])
def test_many_plants_score_what_single_runs_score(law, plant):
    loop = loop_of(law, DRIVE, SHORT, SMOOTH, f"model-{plant}")
    found = over(sampled_loops(loop, 20, 5))
    many = np.column_stack((found.peak_torque, found.saturated))
    single = np.array([run(one, log=False).state.summary[4:6] for one in sampled_loops(loop, 20, 5)])
    np.testing.assert_array_equal(many, single)


IDEAL = RigOptions(ideal_sensors=True)


def on_cable(controller, options=IDEAL, **choices):
    return track(DRIVE, controller=controller, plant="cable", options=options, **choices)


@pytest.mark.kernel
def test_cable_starts_as_its_row_of_inertias_does():
    """Twenty samples: too short for the cable's own modes to matter."""
    motion = Motion(angle=20.0, rise=0.002, dwell=0.001)
    options = replace(IDEAL, segments=4)
    found = [run(loop_of("pd", DRIVE, motion, options, plant)) for plant in (None, "cable")]
    row, cable = (done.log[: len(done.log), 0] for done in found)
    assert np.abs(row).max() > 1e-4
    assert np.abs(row - cable).max() < 0.05 * np.abs(row).max(), (
        f"observed {np.abs(row - cable).max():.2e} rad"
    )


def test_cable_comes_nearer_to_itself_with_more_segments(measured):
    row = track(DRIVE, controller="darc-4", options=IDEAL).load_angle
    angles = {n: on_cable("darc-4", replace(IDEAL, segments=n)).load_angle for n in (4, 8, 12, 24, 32)}
    off = {n: np.degrees(np.abs(angle - row).max()) for n, angle in angles.items()}
    coarse, fine = (np.degrees(np.abs(angles[n] - angles[32]).max()) for n in (4, 8))
    apart = ", ".join(f"{n} segments {size:.4f}" for n, size in off.items())
    measured(f"from the row: {apart} deg; 4 and 8 from 32: {coarse:.4f}, {fine:.4f} deg")
    assert fine < 0.6 * coarse
    assert fine < 0.002, f"observed {fine:.5f} deg"


def test_cable_as_printed_is_softer_than_the_design_believes(measured):
    """EA/L is 438 N/m without damping, the design believes 850: as a lumped chain with those numbers."""
    soft = load_drive(
        "dissertation-3", overrides=["lumped.cable_stiffness=438", "lumped.cable_damping=0"]
    ).listed
    row = track(DRIVE, controller="darc-4-damped", plant_drive=soft, options=IDEAL).summary
    said, undamped = (
        on_cable(law, replace(IDEAL, as_printed=True)).summary for law in ("darc-4-damped", "darc-4")
    )
    words = f"darc-4-damped {said['peak_error_deg']:.3f} (row {row['peak_error_deg']:.3f})"
    measured(f"{words}, darc-4 {undamped['peak_error_deg']:.3f} deg")
    assert said["peak_error_deg"] == pytest.approx(row["peak_error_deg"], rel=0.03)
    assert said["peak_error_deg"] > 0.5
    assert said["cable"]["stiffness"] == pytest.approx(438.0)
    assert on_cable("darc-4-damped").summary["cable"]["stiffness"] == pytest.approx(850.0)


def test_load_on_the_pulley_turns_it_and_can_make_a_span_slack(measured):
    """Some milliseconds after the lumped chain: a span that hangs keeps some tension for a while."""
    push = Disturbance(torque=0.9, start=0.1, end=0.5)
    result = on_cable("darc-4", replace(IDEAL, disturbances=(push,)))
    assert result.incomplete is not None
    assert "slack" in result.incomplete
    row = track(DRIVE, controller="darc-4", options=replace(IDEAL, disturbances=(push,)))
    later, least = len(result.time) - len(row.time), result.tensions.min() / DRIVE.cable.pretension
    measured(f"ends {1e3 * (result.time[-1] - row.time[-1]):.1f} ms after the row, at {100 * least:.2f} %")
    assert 0 < later < 50


def test_a_law_runs_on_the_ropes_of_a_loop_as_on_those_of_the_same_machine_with_routes(measured):
    """Spans that are cut elsewhere, coordinates of other names and order, angles of the other sense."""
    loop = replace(DRIVE, lumped=None)
    mirrored = as_routes(replace(loop, motor=replace(loop.motor, offset_torque=-loop.motor.offset_torque)))
    routes = replace(mirrored, sensors=loop.sensors)  # it goes the other way round
    runs = [on_cable("pd", plant_drive=plant) for plant in (loop, routes)]
    off = max(np.abs(runs[0].angles[:, k] - runs[1].angles[:, k]).max() for k in range(3))
    measured(f"angles {off:.1e} rad apart")
    assert off < 1e-12
    # the spans, which hang alike but for the sense, change places
    np.testing.assert_allclose(np.sort(runs[0].tensions), np.sort(runs[1].tensions), atol=1e-4)


@pytest.mark.parametrize("name", ["corexy", "capstan-arm", "finger-tendon", "printer-idlers"])
def test_a_drawn_machine_has_the_drawn_chain(name):
    """Of certified modes, whatever it leaves out: stiffness and damping follow EA to first order."""
    drive, rng = as_axis(load_drive(name).listed), np.random.default_rng(11)
    usual = plant_chain(drive, None)
    for _ in range(2):
        wanted = sampled_chain(usual, rng)
        rough = tuple(one + 0.3 * rng.random() * max(wanted.coulomb) for one in wanted.coulomb)
        wanted = replace(wanted, coulomb=rough)
        machine = axis_like(drive, wanted)
        if drive.chain_of:
            chains = {chain.load: chain for chain in network_chains(machine.plain)}
            found = plant_chain(axis_drive(chains[drive.axis.load]), None)
        else:
            found = plant_chain(as_axis(machine, drive.axis.load), None)
        for key, tolerance in (("inertias", 1e-4), ("coulomb", 1e-9), ("viscous", 1e-9)):
            scale = max(np.abs(getattr(wanted, key)).max(), 1e-12)
            np.testing.assert_allclose(getattr(found, key), getattr(wanted, key), atol=tolerance * scale)
        np.testing.assert_allclose(found.stiffness, wanted.stiffness, rtol=3e-3)
        np.testing.assert_allclose(found.damping, wanted.damping, rtol=3e-3)


def test_idlers_that_rub_hold_back_a_load_on_ropes_more_than_in_its_chain(measured):
    arm, peaks = load_drive("capstan-arm"), []
    smooth = [replace(own, coulomb_friction=0.0) for own in arm.pulley]
    free = replace(arm, pulley=tuple(smooth), motor=(replace(arm.motor[0], coulomb_friction=0.0),))
    for drive in (arm, free):
        for plant in (None, "cable"):
            found = cd.track(drive, controller="pd", plant=plant, options=IDEAL).summary
            peaks.append(found["peak_error_deg"])
    measured(", ".join(f"{peak:.5f}" for peak in peaks) + " deg: chain and ropes, then without friction")
    assert peaks[1] > 1.1 * peaks[0]
    assert peaks[3] == pytest.approx(peaks[2], rel=0.03)


UPRIGHT = """
schema = 1
name = "upright"
kind = "route"
cable = { axial_rigidity = "20 kN", mass_per_length = "10 g/m", pretension = "100 N" }
body = [{ name = "head", mass = "0.9 kg", at = ["15 mm", "0.3 m"], moves = "y", travel = "0.1 : 0.6 m" }]
route = [{ name = "belt", path = ["l", "-drive", "-far", "r"] }]
motor = { pulley = "drive", inertia = "6e-5 kg m^2", torque_limit = "0.4 N m" }
sensors = { motor_encoder = 20000, sample_rate = "4 kHz" }
[[pulley]]
name = "drive"
at = ["0 m", "0 m"]
radius = "15 mm"
inertia = "1e-6 kg m^2"
[[pulley]]
name = "far"
at = ["0 m", "0.8 m"]
radius = "15 mm"
inertia = "1e-6 kg m^2"
[[anchor]]
name = "l"
on = "head"
at = ["15 mm", "0.28 m"]
[[anchor]]
name = "r"
on = "head"
at = ["15 mm", "0.32 m"]
"""


def upright(tmp_path, text=UPRIGHT):
    path = tmp_path / "upright.toml"
    path.write_text(text)
    return load_drive(path).listed


def test_the_axis_of_a_carriage_is_followed_alike_on_both_plants_and_from_both_forms_of_file():
    """A printer's belt in its file of two pulleys: its chain, and on the cable the same within 4e-3."""
    counts = [f"sensors.{name}_encoder=8192" for name in ("motor", "load")]
    drive = load_drive("printer-belt", overrides=["sensors.sample_rate=5 kHz", *counts]).listed
    with pytest.raises(cd.InputRefused, match="name the axis of one"):
        cd.track(drive, controller="lqi")
    with pytest.raises(cd.InputRefused, match="no axis of this machine: take carriage 0 along"):
        as_axis(drive, "head")
    axis, other = as_axis(drive, "carriage 0 along"), as_axis(drive.machine.plain)
    assert (axis, axis.axis.words) == (other, other.axis.words)
    chain, cable = (
        cd.track(axis, controller="lqi", motion=Motion(angle=0.8, rise=0.06), plant=plant)
        for plant in (None, "cable")
    )
    assert np.abs(cable.load_angle - chain.load_angle).max() < 4e-3 * 0.8


def test_what_a_motor_holds_at_rest_is_off_its_limit(tmp_path):
    """m g r of the head; a motor that cannot hold it is refused."""
    weight = (0.9 + 0.04 * 0.01) * 9.81 * 0.015
    axis = as_axis(upright(tmp_path))
    assert axis.motor.torque_limit == pytest.approx(0.4 - weight, rel=1e-3)
    assert axis.axis.words["held_torque"] == pytest.approx(weight, rel=1e-3)
    with pytest.raises(cd.InputRefused, match=r"to hold 0\.132"):
        as_axis(upright(tmp_path, UPRIGHT.replace("0.4 N m", "0.1 N m")))


def test_a_way_beyond_what_a_body_may_travel_is_refused(tmp_path):
    drive = upright(tmp_path)
    for angle in (1500.0, -1000.0):
        with pytest.raises(cd.InputRefused, match="outside its travel"):
            cd.track(drive, controller="pd", motion=Motion(angle=angle, rise=5.0))


def test_a_drawn_machine_has_the_drawn_load_be_it_a_body_or_a_carriage(tmp_path):
    """A carriage clamped to a closed belt, and friction that is round-off before the load."""
    lines = [
        'carriage = [{ name = "head", mass = "0.9 kg", position = "0.3 m" }]',
        'route = [{ name = "belt", closed = true, path = ["-drive", "-far"] }]',
    ]
    kept = [
        line for line in UPRIGHT.split("[[anchor]]")[0].splitlines() if not line.startswith(("body", "route"))
    ]
    start = kept.index('kind = "route"') + 1
    belt = upright(tmp_path, "\n".join([*kept[:start], *lines, *kept[start:]]))
    belt = replace(belt, layout=replace(belt.layout, gravity=0.0))
    jointed = UPRIGHT.replace("torque_limit", 'joint_stiffness = "3 N m/rad", torque_limit')
    jointed = upright(tmp_path, jointed.replace('"1e-6 kg', '"4e-5 kg', 1).replace("10 g/m", "0.1 g/m"))
    machines = {"carriage": belt, "corexy": load_drive("corexy"), "joint": jointed}
    for name, drive in machines.items():
        drive = as_axis(drive)
        usual = plant_chain(drive, None)
        heavier = (*(1.1 * own for own in usual.inertias[:-1]), 1.3 * usual.inertias[-1])
        coulomb = (usual.coulomb[0] + 0.02 * (name == "corexy"), *usual.coulomb[1:])
        wanted = replace(usual, inertias=heavier, coulomb=coulomb)
        found = plant_chain(as_axis(axis_like(drive, wanted), drive.axis.load), None)
        np.testing.assert_allclose(found.inertias, wanted.inertias, rtol=3e-3)
        np.testing.assert_allclose(found.coulomb, wanted.coulomb, atol=1e-12)


def test_the_cable_as_plant_names_the_span_nearest_to_1_to_2(tmp_path):
    """Of spans of unlike lengths the shorter one is tuned."""
    text = UPRIGHT.replace("upright", "tuned").replace('pretension = "100 N"', 'pretension = "24.4 N"')
    drive = upright(tmp_path, text + '[layout]\ngravity = "0 m/s^2"\n')
    said = cd.track(drive, controller="pd", plant="cable", motion=Motion(angle=20.0, rise=0.5)).summary[
        "cable"
    ]
    spans = {one.span: one.frequency for one in reversed(cd.modes(drive, count=10).transverse)}
    ratios = [frequency / said["pulley_mode_hz"] for frequency in spans.values()]
    assert said["frequency_ratio"] == pytest.approx(min(ratios, key=lambda one: abs(one - 0.5)))
    assert len(set(np.round(ratios, 3))) > 1


# --- Parts of the loop that few runs enter
BRIEF = Motion(angle=0.05, rise=0.02, dwell=0.002)


@pytest.mark.kernel
def test_an_eccentric_encoder_shows_the_load_off_by_its_sine():
    loop = short_loop()
    state = loop_at_rest(loop)
    state.x[:] = 0.1 * np.arange(1.0, state.x.size + 1.0)
    eccentric = loop.plant._replace(eccentricity=2e-3, turning=2.0, phases=np.array([0.0, 0.0, 0.4]))
    see_chain(loop.plant, 10.0, state)
    np.testing.assert_array_equal(state.work[: state.x.size], state.x)
    assert see_chain(eccentric, 10.0, state) == 0
    off = state.work[: state.x.size] - state.x
    assert off[2] == pytest.approx(2e-3 * np.sin(2.0 * 0.3 + 0.4), rel=1e-12)
    assert np.count_nonzero(off) == 1
    assert see_chain(loop.plant, 0.2, state) == DIVERGED
    assert see_chain(loop.plant._replace(twist_limit=0.05), 10.0, state) == WENT_SLACK


def short_loop():
    drive = cd.load_drive("dissertation-3").listed
    controller = own_law(cd.OwnController(step=max, initial_state=np.zeros(3)), DesignSpec(drive, BRIEF))
    return close_loop(DesignSpec(drive, BRIEF), controller, np.random.default_rng(1))


@pytest.mark.kernel
def test_both_encoders_of_a_pair_count_from_places_of_their_own():
    loop, count = short_loop(), 6e-4
    law = FlankLaw(*np.zeros(len(FlankLaw._fields)))._replace(preload=0.2, stiffness=100.0)
    pair = PairNumbers(law=law, phase=0.3, start=0.01, joint=np.array([-1, -1]), record=np.zeros((0, 6)))
    rig = loop.rig._replace(counts=np.full(3, count), phases=np.full(3, -0.3))
    state = loop_at_rest(loop)
    first, second = 500.35 * count, 466.4 * count
    state.x[:2], state.work[0] = (first - second + 0.02, 0.0), 0.5 * (first + second)
    pressed = sense_pair(pair, rig, state)
    seen = [count * np.floor(angle / count + phase + 0.5) for angle, phase in ((first, -0.3), (second, 0.3))]
    assert state.readings[0] == pytest.approx(np.mean(seen), abs=1e-15)
    assert pressed == pytest.approx(0.5 * (seen[0] - seen[1]) + 0.002, abs=1e-15)


@pytest.mark.kernel
def test_a_plant_takes_all_the_momentum_that_its_command_gives_after_the_delay():
    loop = short_loop()
    still = dict.fromkeys(("viscous", "coulomb", "offset"), np.zeros(3))
    plant = loop.plant._replace(**still, current_rate=0.0, twist_limit=np.inf)
    rig = loop.rig._replace(late_samples=0, late_part=0.3 * loop.rig.interval)
    state = new_plant_state(plant, rig)
    for _ in range(6):
        plant_step(plant, rig, state, 0.1, 0.0, 0.0)
    assert plant.inertia @ state.x[3:6] == pytest.approx(0.1 * 5.7 * rig.interval, rel=1e-12)


@pytest.mark.kernel
def test_the_motor_of_a_cable_has_its_older_command_until_the_delay_has_passed():
    """A step spreads its torque half a step to both sides; a torque loop follows by its time constant."""
    rig = short_loop().rig._replace(interval=1e-3, late_part=0.3e-3)
    at_rest = dict.fromkeys(CableNumbers._fields, 0)
    for rate in (0.0, 700.0):
        numbers = CableNumbers(**at_rest)._replace(steps=5, rate=rate)
        run = CableRun(**dict.fromkeys(CableRun._fields))._replace(numbers=numbers, torques=np.empty((5, 1)))
        kernel = getattr(act, "py_func", act)
        end = kernel(run, rig, np.array([2.0, -1.0]), 0.4, 0.25)
        given = run.torques[:, 0] - 0.25
        if rate:
            kept = np.exp(-rate * 0.2e-3)
            filtered = [0.4]
            for command in (2.0, 0.5, -1.0, -1.0, -1.0):
                filtered.append(kept * filtered[-1] + (1.0 - kept) * command)
            np.testing.assert_allclose([*given, end], filtered, rtol=1e-14)
        else:
            np.testing.assert_allclose(given, [2.0, 2.0, -1.0, -1.0, -1.0], atol=1e-12)
            assert end == -1.0


@pytest.mark.parametrize("size", [1, 2, 4])
def test_a_linear_sample_is_the_motion_of_inertias_and_springs(size):
    """Newton's equations of the row, written out and integrated, the torque loop as a lag before them."""
    chain, rate = row_of(size, np.random.default_rng(size)), 3000.0
    begin, (command, motor, load) = 0.1 * np.random.default_rng(7).normal(size=2 * size + 1), (0.5, 0.2, -0.3)

    def rates(_, y):
        angle, speed, torque = y[:size], y[size:-1], np.zeros(size)
        torque[0] += y[-1] + motor
        torque[-1] += load
        for i, (k, c) in enumerate(zip(chain.stiffness, chain.damping, strict=True)):
            pull = k * (angle[i + 1] - angle[i]) + c * (speed[i + 1] - speed[i])
            torque[i : i + 2] += pull, -pull
        turned = (torque - chain.viscous * speed) / chain.inertias
        return np.concatenate((speed, turned, [rate * (command - y[-1])]))

    end = solve_ivp(rates, (0.0, INTERVAL), begin, rtol=1e-11, atol=1e-13).y[:, -1]
    found = linear_step(chain, INTERVAL, rate) @ np.concatenate((begin, [command, motor, load]))
    np.testing.assert_allclose(found, end, rtol=1e-8, atol=1e-10)
