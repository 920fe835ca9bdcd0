"""Results as JSON, options with units: finite numbers or null with a reason; nothing ineffective unsaid."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cabledrive as cd
from cabledrive.app.results import Absent, Answer, json_text, plain, provenance
from command import call, object_of, refusal


def test_number_that_does_not_exist_is_null_with_its_reason():
    assert plain({"bound": Absent(reason="broken assumption")}) == {
        "bound": None,
        "bound_reason": "broken assumption",
    }


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -np.inf, np.float64("nan")])
def test_number_that_is_not_finite_is_null_with_a_reason(value):
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
    time = 1e-3 * np.arange(2000)
    table = np.column_stack([time, np.sin(6 * time), np.degrees(np.cos(6 * time))])
    monkeypatch.chdir(tmp_path)
    np.savetxt("log.csv", table, delimiter=",", header="time [s],torque [N m],angle [deg]", comments="")
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


def imported(statement):
    """Heavy packages that a process has imported after a statement."""
    code = f"import sys\n{statement}\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return HEAVY & {name.split(".")[0] for name in done.stdout.split()}


def invoke(*arguments):
    runner = "from click.testing import CliRunner\nfrom cabledrive.app.main import main\n"
    return f"{runner}CliRunner().invoke(main, {list(arguments)})"


@pytest.mark.parametrize("arguments", [("--version",), ("--help",), ("modes",)])
def test_asking_for_help_imports_nothing_heavy(arguments):
    assert imported(invoke(*arguments)) == set()


def test_modes_import_no_plotting_and_no_report():
    """But for jinja2, which pint's look for an installed dask brings along."""
    assert imported(invoke("modes", "dissertation-2")) <= {"pint", "scipy", "numba", "jinja2"}
