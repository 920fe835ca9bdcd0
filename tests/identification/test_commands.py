"""`experiment`, `identify` and `response` from the command line: statuses, one line each, JSON as agreed."""

import json

import pytest

from cabledrive.app.main import main


def run(capsys, *arguments):
    """Status, standard output and standard error of one call."""
    try:
        status = main([str(a) for a in arguments])
    except SystemExit as end:
        status = end.code
    out = capsys.readouterr()
    return status or 0, out.out, out.err


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rig")
    (folder / "excitation.toml").write_text('kind = "sines"\nduration = "20 s"\n')
    arguments = ["--excitation", str(folder / "excitation.toml"), "-o", str(folder / "log.csv"), "--quiet"]
    with pytest.raises(SystemExit) as end:
        main(
            ["experiment", "dissertation-3", "--model", "1", "--set", "sensors.sample_rate=1 kHz", *arguments]
        )
    assert not end.value.code
    return folder / "log.csv"


def test_an_experiment_is_identified(log, capsys):
    """Model 1 of configuration 3: 0.004092 kg m^2, 0.0031, 0.0376, -0.0006."""
    status, out, _ = run(capsys, "identify", log, "--json")
    answer = json.loads(out)
    assert status == 0
    assert answer["identifiable"] is True
    truth = {
        "inertia": 0.004092,
        "viscous_friction": 0.0031,
        "coulomb_friction": 0.0376,
        "offset_torque": -0.0006,
    }
    for name, value in truth.items():
        entry = answer["parameters"][name]
        assert entry["low"] - entry["standard_error"] < value < entry["high"] + entry["standard_error"], name
        assert set(entry) >= {"value", "unit", "low", "high", "standard_error"}
    assert {"model", "residual", "data"} <= set(answer)


def test_a_plain_column_serves_as_input(log, capsys):
    status, out, _ = run(
        capsys, "response", log, "--input", "command voltage [V]", "--response", "torque", "--json"
    )
    answer = json.loads(out)
    at = answer["frequency_hz"].index(pytest.approx(3.0, abs=1e-6))
    assert status == 0
    assert answer["magnitude"][at] == pytest.approx(1.6218, rel=0.01)  # Eq. (4.20)


def test_a_measured_response_is_read_at_the_door(tmp_path, capsys):
    (tmp_path / "r.csv").write_text(
        "frequency [Hz],magnitude [dB],phase [deg]\n1,0,0\n2,-20,-90\n2,-20,-90\n"
    )
    status, out, _ = run(capsys, "response", tmp_path / "r.csv", "--json")
    answer = json.loads(out)
    assert status == 0
    assert answer["magnitude"] == pytest.approx([1.0, 0.1])
    assert answer["phase_deg"] == pytest.approx([0.0, -90.0])
    assert answer["deviation"][0] is None
