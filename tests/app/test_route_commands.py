"""Machines with routes at the command line: what answers, and what refuses in one line."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray

import cabledrive as cd
from cabledrive.mechanics import rest_state
from cabledrive.parameters import load_drive
from cabledrive.parameters.route import Body
from cabledrive.reduction.network_axis import as_axis
from cabledrive.report.machine.data import machine_warnings
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, simulate
from command import answer, call, object_of, the_line
from network_samples import as_routes

ROUTES = Path(__file__).parent.parent / "parameters" / "routes"


def test_a_machine_is_simulated_at_the_command_line(tmp_path):
    out = tmp_path / "run.nc"
    asked = ("--duration", "1 ms", "--segments", "4", "--torque-amplitude", "0.05", "--torque-frequency", "0")
    written = ("-o", out, "--plot", tmp_path / "run.svg", "--rate", "20 kHz")
    pluck = ("--pluck", "motor to lower idler=0.1 mm")
    found = answer("simulate", ROUTES / "printer.toml", *asked, *pluck, *written)
    assert out.is_file()
    assert (tmp_path / "run.svg").read_text().startswith("<?xml")
    assert found["energy_budget_error"] < 1e-6
    assert [span["name"] for span in found["spans"]][1] == "motor to lower idler"
    assert found["spans"][1]["midpoint_peak"] == pytest.approx(1e-4, rel=0.05)
    assert found["coordinates"]["motor"]["peak_to_peak"] > 0.0
    assert any("state of rest" in line for line in found["assumptions"])


def test_a_response_between_coordinates_that_symmetry_decouples_is_said_to_be_zero(tmp_path):
    """The head in the middle of a CoreXY moves in x alone; at 40 mm beside it, the beam moves with it."""
    text = Path(cd.__file__).parent.joinpath("parameters/drives/corexy.toml").read_text()
    for old, new in (("0.19", "0.23"), ("0.15", "0.19")):
        text = text.replace(f'["{old} m", "0.194 m"]', f'["{new} m", "0.194 m"]')
    (tmp_path / "middle.toml").write_text(text.replace('["0.17 m", "0.20 m"]', '["0.21 m", "0.20 m"]'))
    asked = "--input", "head.x", "--response", "beam.y"
    words = "a force on head.x does not move beam.y: zero but for round-off"
    assert words in answer("response", str(tmp_path / "middle.toml"), *asked)["warnings"]
    assert words not in answer("response", "corexy", *asked)["warnings"]


def test_a_torque_limit_that_slackens_an_axis_is_warned_of_at_the_closed_form_of_a_loop():
    """With a mass on a spring of its own beside it the loop is no longer one of two pulleys, but an axis."""
    drive = cd.load_drive("dissertation-3").listed
    machine, slack = as_routes(drive), 2.0 * drive.drive_pulley.radius * drive.cable.pretension
    beside = replace(
        machine, body=(Body(name="beside", at=(0.0, 0.5), moves=("x",), mass=1.0, stiffness=9e6),)
    )
    for own, words in ((machine, "the slack torque 2 r1 T0"), (beside, "a rope of the held axis goes slack")):
        for share in (0.99, 1.01):
            motor = replace(machine.motor[0], torque_limit=share * slack)
            lines = machine_warnings(replace(own, motor=(motor,)))
            assert [words in line for line in lines].count(True) == (share > 1.0)


def test_a_sample_rate_too_low_for_the_chain_of_an_axis_is_warned_of():
    """Ten samples a cycle of the first mode of the axis of the head of CoreXY."""
    highest = max(as_axis(cd.load_drive("corexy")).axis.words["frequencies_hz"])
    for share in (9.9, 10.1):
        drive = cd.load_drive("corexy", overrides=[f"sensors.sample_rate={share * highest} Hz"])
        assert any("sensors.sample_rate" in line for line in machine_warnings(drive)) == (share < 10.0)


@pytest.mark.parametrize("drive", ["dissertation-3", "linear-axis"])
def test_the_response_of_a_loop_is_its_inertia_far_below_its_modes_and_highest_at_the_first(drive):
    found, machine = answer("response", drive), cd.load_drive(drive).listed
    hertz, magnitude = np.array(found["frequency_hz"]), np.array(found["magnitude"])
    ratio = machine.drive_pulley.radius / machine.load_pulley.radius
    cable = 2.0 * machine.span_length * machine.cable.mass_per_length
    along = cable + sum(carriage.mass for carriage in machine.carriage)
    inertia = machine.drive_pulley.inertia + machine.motor.inertia + machine.load_pulley.inertia * ratio**2
    inertia += along * machine.drive_pulley.radius**2
    rubbing = machine.motor.viscous_friction + machine.drive_pulley.viscous_friction
    rubbing += machine.load_pulley.viscous_friction * ratio**2
    omega = 2.0 * np.pi * hertz[0]
    assert magnitude[0] == pytest.approx(1.0 / abs(inertia * omega**2 - 1j * rubbing * omega), rel=1e-2)
    first = cd.natural_frequencies(machine, count=1, motor="free")[0]
    peaks = np.flatnonzero((magnitude[1:-1] > magnitude[:-2]) & (magnitude[1:-1] > magnitude[2:])) + 1
    assert hertz[peaks[0]] == pytest.approx(first, rel=0.02)


def test_check_judges_a_planned_motion(tmp_path):
    """Places alone make the torque; loops take the torque."""
    time = np.linspace(0.0, 0.5, 51)
    share = 0.5 - 0.5 * np.cos(2.0 * np.pi * time)
    rows = np.column_stack([time, 0.15 + 0.1 * share, 0.01 * np.sin(4.0 * np.pi * time)])
    heads = {"places": "time [s],head.x [m]", "torques": "time [s],torque [N m]"}
    for name, head in heads.items():
        columns = {"places": [0, 1], "torques": [0, 2]}[name]
        np.savetxt(tmp_path / f"{name}.csv", rows[:, columns], delimiter=",", header=head, comments="")
    places, torques = str(tmp_path / "places.csv"), str(tmp_path / "torques.csv")
    found = answer("check", "printer-idlers", "--motion", places)["motion"]
    assert found["verdict"] == "holds"
    assert found["torque_from"] == "places"
    assert {row["by"] for row in found["pulleys"]} == {"teeth"}
    assert all(row["lowest_tension"] < 30.0 < row["highest_tension"] for row in found["spans"])
    assert "Planned motion: holds" in call("check", "printer-idlers", "--motion", places).stdout
    loop = answer("check", "dissertation-2", "--motion", torques)["motion"]
    assert loop["spans"][0]["name"] == "upper"
    assert loop["verdict"] == "unknown"  # its file gives no torque limit


ALL = {
    "check": (),
    "modes": ("--count", "4"),
    "resonance": (),
    "resonance --motion": ("--motion", "motion.csv"),
    "simulate": ("--duration", "1 ms", "--segments", "4"),
    "response": (),
    "track": (),
    "compare": ("--draws", "2", "-o", "compared"),
    "experiment": ("-o", "log.csv"),
    "study": ("--quick", "-o", "studied"),
    "report": ("-o", "page.html"),
    "export": ("--format", "c99", "-o", "exported"),
}


@pytest.mark.verify
@pytest.mark.parametrize("machine", cd.packaged_drives("route"))
@pytest.mark.parametrize("name", ALL)
def test_no_command_fails(name, machine, tmp_path, monkeypatch):
    """It answers, or ends with status 2 or 3 and one line."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "motion.csv").write_text("time [s],torque [N m]\n0,0.01\n0.05,-0.01\n0.1,0\n")
    result = call(name.split()[0], machine, *ALL[name])
    assert result.exit_code in (0, 2, 3), (name, machine, result.output)
    assert bool(result.stdout.strip()) == (result.exit_code == 0)
    assert result.exit_code == 0 or the_line(result.stderr)


@pytest.mark.parametrize(("pretension", "most"), [("2 N", 0.2), ("10 N", 0.02)])
def test_the_chain_of_an_axis_has_the_certified_mode_of_the_belt_that_hangs(pretension, most):
    """Among the waves across its spans, whose share of the response sag makes."""
    loose = [f"cable.pretension={pretension}", "layout.gravity=9.81"]
    drive = cd.load_drive("printer-idlers", overrides=loose)
    words = as_axis(drive).axis.words
    (own,) = words["frequencies_hz"]
    found = cd.modes(drive, below=1.2 * own, motor="free")
    assert found.certified
    assert any("sag" in mode.model for mode in found.transverse)
    assert min(abs(mode.frequency / own - 1.0) for mode in found.longitudinal) < 1e-11
    assert 0.005 < words["neglected_strings"] < most


def test_a_belt_so_loose_that_it_sags_and_swings_is_no_chain():
    loose = ["cable.pretension=1 N", "layout.gravity=9.81"]
    with pytest.raises(cd.InputRefused, match="transverse vibrations of the spans make up 3"):
        as_axis(cd.load_drive("printer-idlers", overrides=loose))


@pytest.mark.parametrize(
    ("name", "settings"), [("elevator", ()), ("dissertation-transporter", ("layout.inclination=90 deg",))]
)
def test_check_has_spans_of_a_loop_at_rest_as_its_catenaries(name, settings):
    """Tensions of the network are those of the loop, of one without a motor whose drive pulley is held."""
    found = answer("check", name, *(f"--set={one}" for one in settings))
    rest = rest_state(load_drive(name, overrides=settings).listed)
    for row in found["spans"]:
        own = [one for one in rest.stretches if one.span == row["name"]]
        ends = own[0].tensions[0], own[-1].tensions[1]
        assert (row["tension_start"], row["tension_end"]) == pytest.approx(ends, rel=1e-9)
    assert [row["name"] for row in found["pulleys"]] == ["load pulley", "drive pulley"]


# --- cabledrive simulate: what it answers, what it writes, how it ends
SHORT = ["--duration", "0.02", "--segments", "20"]
FORCED = ["--torque-amplitude", "0.02", "--torque-frequency", "81.7"]


def test_the_command_is_a_few_lines_over_the_public_function(tmp_path):
    path, page = tmp_path / "run.nc", tmp_path / "run.html"
    options = ["--pluck-upper", "1 mm", "--pluck", "lower=0.5 mm", "--pluck-shape", "half-sine"]
    options += ["--fields", "10", "-o", path, "--animate", page]
    found = answer("simulate", "dissertation-2", *SHORT, *FORCED, *options)
    plucks = (Pluck(height=1e-3, shape="half-sine"), Pluck(height=5e-4, span="lower", shape="half-sine"))
    result = simulate(
        load_drive("dissertation-2").listed,
        0.02,
        torque=Sine(amplitude=0.02, frequency=81.7),
        start=plucks,
        scheme=Scheme(segments=20),
        recording=Recording(fields=10),
    )
    del found["wall_time"], found["provenance"], found["error_estimate_reason"]
    expected = result.summary()
    for gone in ("wall_time", "interpreted", "stopped"):  # a time, and notes that there are none of
        del expected[gone]
    assert found == expected
    with xarray.open_dataset(path, engine="h5netcdf") as stored:
        np.testing.assert_array_equal(stored["load_angle"], result.load_angle)
        assert stored["field"].sizes["field_time"] == 21
    assert "prefers-reduced-motion" in page.read_text()


def test_a_picture_that_cannot_be_drawn_leaves_the_run_and_says_so(tmp_path, monkeypatch):
    """A slack span ends the run before there are records enough: status 3, the result written and printed."""
    monkeypatch.chdir(tmp_path)
    start = ("simulate", "dissertation-2", "--duration", "0.01", "--torque-amplitude", "1e3")
    done = call(*start, "--torque-frequency", "0", "-o", "run.nc", "--plot", "run.png", "--json")
    assert done.exit_code == 3
    assert (tmp_path / "run.nc").exists()
    assert not (tmp_path / "run.png").exists()
    assert object_of(done.stdout)["slack_events"]
    assert "not drawn: spectrum of" in done.stderr
