"""What `export` refuses in one line, with nothing written; exported models."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

import cabledrive as cd
from cabledrive.export.descriptions import mjcf_files, modelica_files
from cabledrive.export.source import lumped_models
from cabledrive.reduction.lumped_chain import state_space
from cabledrive.rig.laws.controller_file import controller_numbers
from command import call, refused
from export.designs import DRIVE, OWN, loop_of
from other_units import in_other_units


def with_vectors(gains, state, measurement, reference):
    error = reference[:4] - measurement
    return state, error[0]


def with_a_longer_state(gains, state, measurement, reference):
    return measurement, reference[0]


def by_name(gains, state, measurement, reference):
    return state, gains["p"] * (reference[0] - measurement[0])


OUTSIDE = [
    ({"step": with_vectors}, "test_export_refusals.py:"),
    ({"step": with_a_longer_state}, "state of shape"),
    ({"step": by_name, "gains": {"p": 1.0}}, "its gains cannot be exported"),
    ({"step": eval("lambda g, s, m, r: (s, 0.0)")}, "cannot be exported"),
]
CABLE = {"format": "fmu2", "what": "cable"}
ROWS = [
    ("dissertation-3", {"format": "c99", "controller": "no-law"}, "no-law"),
    ("elevator", {"format": "c99"}, "3000 N m"),
    ("no-such-drive", {"format": "c99"}, "no-such-drive"),
    ("dissertation-3", {"format": "hdl"}, "hdl"),
    ("dissertation-3", {"format": "mjcf", "what": "loop"}, "loop"),
    ("dissertation-3", {"format": "fmu2", "float32": True}, "float32"),
    ("dissertation-3", {"format": "mjcf", "float32": True}, "float32"),
    ("dissertation-1", CABLE | {"format": "c99"}, "fmu2 or fmu3"),
    ("dissertation-1", CABLE | {"controller": "pd"}, "holds no controller"),
    (DRIVE, {"format": "c99", "controller": OWN, "float32": True}, "your own"),
    (DRIVE, {"format": "c99", "controller": OWN, "what": "loop"}, "your own"),
    *((DRIVE, {"format": "c99", "controller": replace(OWN, **one)}, named) for one, named in OUTSIDE),
]


@pytest.mark.parametrize("source, options, named", ROWS)
def test_refused_in_one_line_with_nothing_written(source, options, named, tmp_path):
    refused(lambda: cd.export_to(tmp_path / "out", source, **options), named)
    assert list(tmp_path.iterdir()) == []


def test_a_full_folder_an_empty_study_and_another_layout_are_refused(tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("mine")
    with pytest.raises(cd.InputRefused, match="not empty"):
        cd.export_to(tmp_path / "full", "dissertation-3", "c99")
    (tmp_path / "study").mkdir()
    with pytest.raises(cd.InputRefused, match=r"controller\.json"):
        cd.export_to(tmp_path / "out", tmp_path / "study", "c99")
    (tmp_path / "controller.json").write_text(json.dumps({"drive_hash": "0"}))
    with pytest.raises(cd.InputRefused, match=r"controller\.json"):
        cd.export_to(tmp_path / "out", tmp_path / "controller.json", "c99")
    assert not (tmp_path / "out").exists()


# --- The law of a study without yes leaves only on demand, with its reason in the firmware
REASON = "the log contradicts the assumptions: the angles lag the torque by 2 ms */ of late"


@pytest.fixture
def study(tmp_path):
    """A study's folder whose verdict is unknown, made by hand."""

    def written(verdict, **more):
        folder = tmp_path / "study"
        folder.mkdir()
        data = controller_numbers(loop_of("pd"), DRIVE, "motor")
        data |= {"study": {"verdict": verdict, "reason": REASON, **more}}
        (folder / "controller.json").write_text(json.dumps(data))
        cd.save_drive(DRIVE, str(folder / "drive.toml"))
        return folder

    return written


def test_the_law_of_a_study_without_yes_is_refused_with_the_reason(study, tmp_path):
    asked = call("export", study("unknown"), "--format", "c99", "-o", tmp_path / "firmware")
    assert asked.exit_code == 2
    assert "lag the torque by 2 ms" in asked.output
    assert "--anyway" in asked.output
    assert not (tmp_path / "firmware").exists()


def test_a_law_that_misses_the_goal_with_the_gain_that_is_exported_is_refused(study, tmp_path):
    tried = {"draws": 400, "misses": 6, "holds": False}
    asked = call("export", study("yes", as_written=tried), "--format", "c99", "-o", tmp_path / "firmware")
    assert asked.exit_code == 2
    assert "misses the goal on 6 of 400 lumped plants" in asked.output
    assert not (tmp_path / "firmware").exists()


@pytest.mark.parametrize("what", ["controller", "loop"])
def test_the_reason_stands_in_the_header_and_the_readme(what, study, tmp_path):
    arguments = ("--format", "c99", "--what", what, "--anyway", "-o", tmp_path / "firmware")
    asked = call("export", study("unknown"), *arguments)
    assert asked.exit_code == 0, asked.output
    header = next((tmp_path / "firmware").glob("cabledrive_l*.h")).read_text()
    first = header[: header.index("*/")]
    assert "verdict of its study is unknown" in first
    assert "lag the torque by 2 ms * / of late" in first
    assert "lag the torque by 2 ms" in (tmp_path / "firmware" / "README.md").read_text()


def test_a_copy_of_a_doubtful_law_stays_doubtful(study, tmp_path):
    cd.export_to(tmp_path / "firmware", study("no"), "c99", anyway=True)
    with pytest.raises(cd.InputRefused, match="its study is no"):
        cd.export_to(tmp_path / "again", tmp_path / "firmware", "c99")


# --- Models for other programs: MuJoCo, Modelica, printer firmware
DRIVES = ("dissertation-2", "dissertation-3")


@pytest.mark.parametrize("name", DRIVES)
def test_mujoco_oscillates_at_the_frequencies_of_the_chain(name, measured):
    """Stiffness by MuJoCo's own passive forces, inertia by its own accelerations."""
    mujoco = pytest.importorskip("mujoco", reason="needs mujoco")
    drive = cd.load_drive(name).listed
    files = mjcf_files(drive)
    gaps = []
    for number, chain in lumped_models(drive).items():
        model = mujoco.MjModel.from_xml_string(files[f"model-{number}.xml"])
        data, n = mujoco.MjData(model), chain.size
        stiffness, inertia = np.zeros((n, n)), np.zeros((n, n))
        model.dof_frictionloss[:] = 0.0
        mujoco.mj_forward(model, data)
        rest = data.qfrc_passive.copy()
        for i in range(n):
            data.qpos[:] = np.eye(n)[i] * 1e-3
            mujoco.mj_forward(model, data)
            stiffness[:, i] = -(data.qfrc_passive - rest) / 1e-3
            data.qpos[:] = 0.0
            data.qfrc_applied[:] = np.eye(n)[i]
            mujoco.mj_forward(model, data)
            with_torque = data.qacc.copy()
            data.qfrc_applied[:] = 0.0
            mujoco.mj_forward(model, data)
            inertia[:, i] = with_torque - data.qacc
        found = np.sqrt(np.sort(np.abs(np.linalg.eigvals(inertia @ stiffness))))
        a, _ = state_space(chain)
        wanted = np.sqrt(np.sort(np.abs(np.linalg.eigvals(-a[n:, :n]))))
        gaps.append(np.abs(found - wanted).max() / max(wanted.max(), 1.0))
    measured(f"{name}: {max(gaps):.1e}")
    assert max(gaps) < 1e-5, f"observed {gaps}"


@pytest.mark.parametrize("time", [1.0, 0.01])
def test_mujoco_moves_a_machine_as_its_chain_however_fast_that_is(time, measured):
    """A hundred times as fast, its fastest mode of 9.2 kHz diverged at steps of 0.1 ms."""
    mujoco = pytest.importorskip("mujoco", reason="needs mujoco")
    drive = in_other_units(DRIVE, (1.0, 1.0, time))
    chain = lumped_models(drive)[4]
    model = mujoco.MjModel.from_xml_string(mjcf_files(drive)["model-4.xml"])
    model.dof_frictionloss[:], data = 0.0, mujoco.MjData(model)
    data.qfrc_applied[0] = 0.02 / time**2 - chain.offsets[0]
    steps = round(0.05 * time / model.opt.timestep)
    mujoco.mj_step(model, data, nstep=steps)
    a, b = state_space(chain)
    pushed = np.pad(np.column_stack((a, 0.02 / time**2 * b[:, 0])), ((0, 1), (0, 0)))
    exact = expm(pushed * steps * model.opt.timestep)[:3, -1]
    off = float(np.abs(data.qpos / exact - 1.0).max())
    measured(f"{100 * off:.2f} % at steps of {1e6 * model.opt.timestep:.3g} us")
    assert off < 0.03


@pytest.mark.parametrize("name", DRIVES)
def test_the_equations_of_the_modelica_text_are_those_of_the_chain(name):
    """Its equations, evaluated in Python line by line, accelerate as the state space does."""
    drive = cd.load_drive(name).listed
    generator = np.random.default_rng(3)
    for number, chain in lumped_models(drive).items():
        text = modelica_files(drive)[f"Model{number}.mo"]
        n = chain.size
        angle, speed = generator.standard_normal(n), generator.standard_normal(n)
        values = {"angle": angle, "speed": speed, "torque": 0.7, "load_torque": -0.2, "tanh": np.tanh}
        for key, value in re.findall(r"parameter Real (\w+)(?:\[n\])?(?:\(.*?\))? = (.*?);", text):
            values[key] = eval(value.replace("{", "[").replace("}", "]"))
        equations = text.partition("\nequation\n")[2].partition("\nend ")[0].replace("\n", " ").split(";")
        acceleration = {}
        for one in filter(None, map(str.strip, equations)):
            left, right = one.split(" = ", 1)
            right = re.sub(r"\[(\d+)\]", lambda hit: f"[{int(hit[1]) - 1}]", right)
            if left.startswith("stretch"):
                values[left] = eval(right, values)
                values[f"rate_{left}"] = eval(right.replace("angle", "speed"), values)
            elif left.startswith("inertia"):
                i = int(left[8])
                acceleration[i] = eval(right, values) / chain.inertias[i - 1]
            elif left.startswith("force"):
                values[left] = eval(re.sub(r"der\((\w+)\)", r"rate_\1", right), values)
            else:
                assert one == "der(angle) = speed"
        a, b = state_space(chain)
        torques = np.array(chain.offsets) - np.array(chain.coulomb) * np.tanh(50.0 * speed)
        torques[0] += 0.7
        torques[-1] += -0.2
        wanted = (a @ np.concatenate((angle, speed)) + b @ torques)[n:]
        found = np.array([acceleration[i + 1] for i in range(n)])
        np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-10 * np.abs(wanted).max())
