"""What every command understands: --json, --set, -o, --force, --quiet; help, colours, version."""

import json
import os
import shlex
import subprocess
import sys

import jsonschema
import numpy as np
import pytest
from click import Context
from hypothesis import given, settings
from hypothesis import strategies as st

import cabledrive as cd
from cabledrive.app.main import main
from cabledrive.app.results import Answer, json_text, plain, provenance
from command import answer, call, object_of, refusal, run, write_log
from painted_marker import VirtualCamera, filmed
from printer_logs import samples, write_densities

COMMANDS = main.list_commands(Context(main))
EXAMPLES = {name: main.get_command(Context(main), name).epilog.split("Example:\n")[1] for name in COMMANDS}
CAMPAIGN = """
drive = "dissertation-3"
[vary]
"pulley.1.inertia" = { from = 0.002, to = 0.003, n = 4 }
[design]
kind = "grid"
[compute]
what = "modes"
"""

BRIEF = """
[motion]
angle = "10 deg"
duration = "0.1 s"
dwell = "0.1 s"
[acceptance]
draws = 10
cable_draws = 0
"""
SLOWLY = ("--set", "sensors.sample_rate=1 kHz")


def film(path):
    """A clip of a marker that swings, as the example of `camera` reads it."""
    cv2 = pytest.importorskip("cv2", reason="needs the extra camera")
    camera = VirtualCamera()
    swing = 80.0 + 20.0 * np.sin(2 * np.pi * 5.0 * np.arange(100) / camera.frame_rate)[:, None]
    size = (camera.columns, camera.rows)
    video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 30.0, size)
    for frame in filmed(camera, swing, np.random.default_rng(0)):
        video.write(np.repeat(frame[:, :, None], 3, axis=2))
    video.release()


@pytest.mark.parametrize("name", COMMANDS)
def test_help_has_one_example_and_it_runs_and_answers_as_its_schema_says(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert EXAMPLES[name].count("\n") == 0
    assert EXAMPLES[name] in call(name, "--help").output
    program, *arguments = shlex.split(EXAMPLES[name])
    if "log.csv" in arguments[1:2]:  # as the example of `experiment` makes it, of fewer samples
        assert call(*shlex.split(EXAMPLES["experiment"])[1:], *SLOWLY).exit_code == 0
    if name == "study":  # its drawing is tested elsewhere
        monkeypatch.setattr("cabledrive.report.study.results.study_html", lambda result: result.drive.name)
        (tmp_path / "few.toml").write_text(BRIEF)
        arguments += ["--goals", "few.toml", *SLOWLY]
    if name == "report":  # its chapter on what moves the frequencies is tested elsewhere
        monkeypatch.setattr("cabledrive.report.writing.effect_of_parameters", lambda context: None)
    if name == "compare":  # one law on few plants: tuning all of them is tested elsewhere
        arguments += ["--controllers", "lqi", "--draws", "2"]
    if name == "shaper":
        write_densities(tmp_path / arguments[1], samples([(48.3, 0.06, 1.0)], np.random.default_rng(0)))
    if "campaign.toml" in arguments:
        (tmp_path / "campaign.toml").write_text(CAMPAIGN)
        arguments = ["1" if word == "2" else word for word in arguments]  # two are tested elsewhere
    if "campaign.zarr" in arguments[1:2]:
        groups = CAMPAIGN.replace(", n = 4", "").replace('"grid"', '"saltelli"\nbase = 64')
        (tmp_path / "groups.toml").write_text(groups)
        assert call("sweep", "groups.toml", "-o", "campaign.zarr", "--workers", "1").exit_code == 0
    if "clip.avi" in arguments:
        film(tmp_path / "clip.avi")
    if name == "studio":  # it serves until it is stopped; that it does is tested elsewhere
        monkeypatch.setattr("uvicorn.Server.run", lambda server, sockets=None: None)
        arguments.append("--no-browser")
    elif name != "schema":
        arguments.append("--json")
    done = call(*arguments)
    assert (program, done.exit_code) == ("cabledrive", 0), done.stderr
    for option in {"-o", "--map", "--plot"}.intersection(arguments):
        assert (tmp_path / arguments[arguments.index(option) + 1]).stat().st_size > 0
    if "--json" in arguments:
        found, described = object_of(done.stdout), answer("schema", "--of", name)
        schema = jsonschema.Draft202012Validator(described)
        schema.validate(found)
        assert not list(unexplained(found))
        for key in found.keys() - {"provenance", "incomplete", "motor_reason"}:
            other = found | {f"{key}_misspelt": found[key]}
            assert key.endswith("_reason") or not schema.is_valid(
                {k: v for k, v in other.items() if k != key}
            ), key


def unexplained(found):
    """Names of figures that are null without a reason."""
    for key, value in found.items():
        told = found.keys() & {f"{key}_reason", "reason"} or key in found.get("reasons", ())
        if value is None and not told:
            yield key
        if key != "provenance":  # as the classes of methods have them
            for inner in value if isinstance(value, list) else [value]:
                yield from unexplained(inner) if isinstance(inner, dict) else ()


def test_output_holds_the_same_object(tmp_path):
    path = tmp_path / "modes.json"
    done = call("modes", "elevator", "--json", "-o", path)
    assert done.exit_code == 0
    assert json.loads(path.read_text()) == object_of(done.stdout)
    assert done.stderr == f"written to {path}\n"


@pytest.mark.parametrize("command", ["schema", "check elevator", "modes elevator"])
def test_existing_output_is_kept_unless_forced(command, tmp_path):
    path = tmp_path / "result"
    path.write_text("precious")
    words = "exists and is not overwritten: choose another name or add --force"
    assert refusal(*command.split(), "-o", path) == f"{path}: {words}"
    assert path.read_text() == "precious"
    assert call(*command.split(), "-o", path, "--force").exit_code == 0
    assert path.read_text() != "precious"
    assert os.listdir(tmp_path) == ["result"]


def test_text_survives_a_terminal_of_few_letters():
    done = run("check", "elevator", env={"PYTHONIOENCODING": "ascii"})
    assert (done.returncode, done.stderr) == (0, "")


# --- Results as JSON; what is heavy is imported where it is needed
@pytest.mark.parametrize("value", [float("nan"), float("inf"), -np.inf, np.float64("nan")])
def test_number_that_does_not_exist_or_is_not_finite_is_null_with_its_reason(value):
    assert plain({"x": value}) == {"x": None, "x_reason": "not a finite number"}
    assert plain({"x": [1.0, value]}) == {"x": [1.0, None], "x_reason": "not a finite number"}


values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=10,
)


@given(data=st.dictionaries(st.text(), values, max_size=4))
@settings(max_examples=50)
def test_whatever_is_found_becomes_one_json_object_in_ascii(data):
    text = json_text(Answer(data=data, text="", provenance=provenance()))
    assert text.isascii()
    assert object_of(text)["provenance"] == {"cabledrive": cd.__version__}


@pytest.fixture
def log(tmp_path, monkeypatch):
    """A log of 2 s at 1 kHz, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    write_log(tmp_path / "log.csv")
    return "log.csv"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("track", "dissertation-3", "--as-printed"), "--as-printed has no effect"),
        (("track", "dissertation-3", "--ideal-sensors", "--observer", "kalman"), "--observer has no effect"),
        (("simulate", "dissertation-2", "--duration", "1 ms", "--pluck-shape", "half-sine"), "no span is"),
    ],
)
def test_an_option_of_the_agreed_ones_without_effect_is_reported(arguments, words):
    done = call(*arguments, "--json")
    assert done.exit_code == 0
    assert words in done.stderr
    assert "has no effect" not in call(*arguments, "--json", "--quiet").stderr


def test_a_page_of_a_log_that_is_read_in_blocks_is_refused_before_the_work(log, monkeypatch):
    monkeypatch.setattr("cabledrive.identification.one_log.is_long", lambda recording: True)
    monkeypatch.setattr("cabledrive.identification.one_log.identify", None)  # were it begun: a defect
    assert "log.csv is too long to be drawn" in refusal("identify", log, "--report", "p.html")


def test_a_position_in_degrees_is_refused_with_a_mapping_that_works(log):
    with open(log) as file:
        content = file.read()
    with open("servo.csv", "w") as file:
        file.write(content.replace("angle [deg]", "position [deg]"))
    line = refusal("identify", "servo.csv")
    assert '"deg" is a unit of angle, position is in m: head it "angle [deg]"' in line
    assert '--column "torque=torque" --column "angle=position"' in line
    mapped = ("--column", "torque=torque", "--column", "angle=position")
    assert call("identify", "servo.csv", *mapped).stdout == call("identify", log).stdout


# --- The command starts fast: what is heavy is imported where it is needed
HEAVY = {"matplotlib", "numba", "pint", "scipy", "xarray", "pandas", "jinja2", "sympy"}


def imported(arguments):
    """Heavy packages that a process has imported after the command."""
    code = "import sys\nfrom click.testing import CliRunner\nfrom cabledrive.app.main import main\n"
    code += f"CliRunner().invoke(main, {arguments})\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return HEAVY & {name.split(".")[0] for name in done.stdout.split()}


COMPUTING = {"pint", "scipy", "numba", "jinja2"}  # pint's look for an installed dask brings jinja2 along


@pytest.mark.parametrize(
    ("line", "may"), [("--version", ()), ("--help", ()), ("modes", ()), ("modes dissertation-2", COMPUTING)]
)
def test_help_imports_nothing_heavy_and_modes_no_plotting_and_no_report(line, may):
    assert imported(line.split()) <= set(may)
