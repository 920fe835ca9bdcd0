"""Machines with routes at the command line: what answers, and what refuses in one line."""

from pathlib import Path

import click
import numpy as np
import pytest

import cabledrive as cd
from cabledrive.app.main import main
from command import answer, call, refusal

ROUTES = Path(__file__).parent.parent / "parameters" / "routes"
COREXY = str(ROUTES / "corexy.toml")
TAKES_ROUTES = {"check", "modes", "map", "resonance", "simulate", "studio", "report"}
OTHERWISE = {"identify"}  # takes a drive for a ping alone, see below
AXES = {"track", "compare", "experiment", "study"}  # on the chain of an axis
ENDINGS = {"report": "page.html", "experiment": "log.csv", "simulate": "run.nc"}


def commands_of_a_drive():
    context = click.Context(main)
    for name in main.list_commands(context):
        command = main.get_command(context, name)
        if any(parameter.name in ("drive", "drives") for parameter in command.params):
            yield name, command


def required(name, command):
    """The options without which a command does not start, each with a value."""
    for parameter in command.params:
        if isinstance(parameter, click.Option) and parameter.required:
            yield parameter.opts[-1]
            yield ENDINGS.get(name, "out") if parameter.name == "output" else "1"


def test_every_command_that_takes_a_drive_takes_routes():
    """A new command joins one of these sets, and with it their tests."""
    assert {name for name, _ in commands_of_a_drive()} == TAKES_ROUTES | OTHERWISE | AXES


@pytest.mark.parametrize("name", sorted(AXES))
def test_a_machine_of_two_axes_asks_which_in_one_line_and_writes_nothing(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = refusal(name, COREXY, *required(name, dict(commands_of_a_drive())[name]))
    assert 'kind = "route"' in line
    assert "head.x, beam.y" in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("what", ["controller", "plant"])
def test_an_export_of_a_route_is_refused(what, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    form = "c99" if what == "controller" else "modelica"
    line = refusal("export", COREXY, "--format", form, "--what", what, "-o", "out")
    assert 'kind = "route"' in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "call_it",
    [
        lambda drive: cd.track(drive),
        lambda drive: cd.resonance(drive, load_torque=1.0),
        lambda drive: cd.derived_quantities(drive),
        lambda drive: cd.drive_warnings(drive),
        lambda drive: cd.modes(drive, at_torque=1.0),
        lambda drive: drive.span_length,
    ],
)
def test_python_refuses_what_routes_do_not_support(call_it):
    with pytest.raises(cd.InputRefused, match=r'kind = "route"'):
        call_it(cd.load_drive(COREXY))


def test_check_lists_every_span_with_length_wrap_and_tension():
    found = answer("check", str(ROUTES / "printer.toml"))
    names = [row["name"] for row in found["spans"]]
    assert names == [
        "left clamp to motor",
        "motor to lower idler",
        "lower idler to upper idler",
        "upper idler to right clamp",
    ]
    assert [row["length"] for row in found["spans"]] == pytest.approx([0.18, 0.4, 0.004732, 0.18])
    wraps = [row["wrap"] for row in found["spans"]]
    assert wraps[:3] == pytest.approx([np.pi, np.pi / 2, np.pi / 2])
    assert wraps[3] is None
    assert [row["tension"] for row in found["spans"]] == pytest.approx([30.0] * 4)
    assert found["derived"]["lowest_frequency_free_hz"] == pytest.approx(189.6749, abs=1e-4)
    assert found["derived"]["rigid_body_modes"] == 1
    assert found["warnings"] == []


def test_check_gives_the_friction_that_a_traction_sheave_needs():
    """|ln(T1/T2)| over the wrap; 1729 and 1565.5 N a rope without the ropes' weight."""
    light = [f"--set=route.{name}.mass_per_length=1e-9" for name in ("suspension", "compensation")]
    found = answer("check", str(ROUTES / "elevator.toml"), *light)
    sheave = next(row for row in found["pulleys"] if row["name"] == "traction sheave")
    assert sheave["tension_in"], sheave["tension_out"] == pytest.approx((1729.0, 1565.5), abs=0.1)
    assert sheave["needed_friction"] == pytest.approx(np.log(1729.0125 / 1565.5125) / np.pi, rel=1e-6)


def test_check_gives_which_belt_runs_askew():
    found = answer("check", COREXY, "--set", 'pulley.beam left a.at=["0 m", "0.213 m"]')
    askew = [line for line in found["warnings"] if "askew" in line]
    assert any("head left a to beam left a" in line and "head.x" in line for line in askew)
    assert float(askew[0].split(" by ")[1].split(" deg")[0]) == pytest.approx(4.95, abs=0.01)


def test_check_gives_the_safety_factor_of_a_belt_from_the_table():
    found = answer("check", str(ROUTES / "printer.toml"), "--set", 'cable.type="GT2-6mm"')
    assert found["spans"][0]["safety_factor"] == pytest.approx(113.0 / 30.0)


@pytest.mark.parametrize("name", ["corexy", "serpentine", "ropeway"])
def test_check_draws_a_machine(name, tmp_path):
    picture = tmp_path / f"{name}.svg"
    assert call("check", str(ROUTES / f"{name}.toml"), "--plot", str(picture)).exit_code == 0
    text = picture.read_text()
    assert text.startswith("<?xml")
    assert text.count("<path") > 20


def test_check_draws_a_loop(tmp_path):
    picture = tmp_path / "loop.png"
    assert call("check", "linear-axis", "--plot", str(picture)).exit_code == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_modes_says_which_waves_are_between_held_ends_and_how_the_rotors_are_held():
    found = answer("modes", COREXY, "--below", "140", "--motor", "held")
    assert (found["motor"], found["certified"], found["rigid_body_modes"]) == ("held", True, 0)
    clamped = [mode.get("clamped", False) for mode in found["modes"]]
    assert any(clamped)
    assert not all(clamped)
    assert {mode["kind"] for mode in found["modes"]} == {"longitudinal", "transverse"}
    assert all(mode["span"] for mode in found["modes"] if mode["kind"] == "transverse")


def test_modes_can_hold_a_body_by_name():
    free, held = (answer("modes", COREXY, "--below", "150", *extra) for extra in ((), ("--hold", "beam")))
    assert (free["rigid_body_modes"], held["rigid_body_modes"]) == (2, 1)
    assert held["hold"] == ["beam"]
    assert "did you mean" in refusal("modes", COREXY, "--hold", "heat")


def test_the_table_of_modes_names_spans():
    text = call("modes", COREXY, "--below", "75").stdout
    assert "rear left b to front left b" in text
    assert "Complete up to 75 Hz (certified)" in text


def test_a_machine_is_simulated_at_the_command_line(tmp_path):
    out = tmp_path / "run.nc"
    asked = ("--duration", "1 ms", "--segments", "4", "--torque-amplitude", "0.05", "--torque-frequency", "0")
    found = answer(
        "simulate",
        str(ROUTES / "printer.toml"),
        *asked,
        "--pluck",
        "motor to lower idler=0.1 mm",
        "-o",
        str(out),
        *("--plot", str(tmp_path / "run.svg"), "--rate", "20 kHz"),
    )
    assert out.is_file()
    assert (tmp_path / "run.svg").read_text().startswith("<?xml")
    assert found["energy_budget_error"] < 1e-6
    assert [span["name"] for span in found["spans"]][1] == "motor to lower idler"
    assert found["spans"][1]["midpoint_peak"] == pytest.approx(1e-4, rel=0.05)
    assert found["coordinates"]["motor"]["peak_to_peak"] > 0.0
    assert any("state of rest" in line for line in found["assumptions"])


@pytest.mark.parametrize(
    "option",
    [
        ["--pluck-upper", "1 mm"],
        ["--model", "fast"],
        ["--fields", "2", "-o", "run.nc"],
        ["--pluck", "1 mm"],
        ["--resume"],
        ["--plot", "run.svg"],
    ],
)
def test_what_simulate_does_not_do_on_routes_is_refused(option, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refusal("simulate", str(ROUTES / "printer.toml"), "--duration", "1 ms", *option)
    assert list(tmp_path.iterdir()) == []


def test_the_response_of_a_machine_has_its_rigid_mass_below_its_modes():
    """Place over torque is r / (M r^2 + J) / omega^2 far below the first mode."""
    found = answer(
        "response",
        str(ROUTES / "printer.toml"),
        "--input",
        "motor",
        "--response",
        "head.x",
        "--below",
        "100 Hz",
    )
    radius, head = 6.366e-3, 0.35
    belt = 8.3e-3 * (0.18 + 0.40 + 4.732e-3 + 0.18)
    inertia = 1.6e-7 + 54e-7 + (head + belt + 2 * 3e-8 / 4e-3**2) * radius**2
    omega = 2 * np.pi * found["frequency_hz"][0]
    assert found["magnitude"][0] == pytest.approx(radius / inertia / omega**2, rel=2e-3)
    refusal("response", "dissertation-3")
    refusal("response", str(ROUTES / "printer.toml"), "--response", "tail")


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


def test_check_judges_a_planned_motion_and_refuses_what_does_not_fit(tmp_path):
    """Places alone make the torque; a machine of two bodies wants both; loops take the torque."""
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
    assert loop["spans"][0]["name"] == "drive pulley to load pulley"
    assert loop["verdict"] == "unknown"  # its file gives no torque limit
    assert "add beam.y" in refusal("check", "corexy", "--motion", places)


def test_a_run_that_ends_early_is_headed_by_its_time_and_the_time_asked_for(tmp_path):
    """A constant torque drives the carriage over a part of a span before the half second is over."""
    done = call(
        *("simulate", str(ROUTES / "printer.toml"), "--duration", "0.5", "--travel"),
        *("--torque-amplitude", "1", "--torque-frequency", "0", "--torque-on", "motor"),
    )
    first = done.stdout.splitlines()[0]
    assert first.endswith(" s of 0.5 s asked for"), done.stdout + done.stderr
    assert float(first.rpartition(": ")[2].split(" s")[0]) < 0.5
