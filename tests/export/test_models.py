"""Models for other programs: MuJoCo, Modelica, printer firmware."""

import re

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.export.descriptions import mjcf_files, modelica_files
from cabledrive.export.source import lumped_models
from cabledrive.reduction.lumped_chain import state_space

DRIVES = ("dissertation-2", "dissertation-3")


@pytest.mark.parametrize("name", DRIVES)
def test_mujoco_oscillates_at_the_frequencies_of_the_chain(name, measured):
    """Stiffness by MuJoCo's own passive forces, inertia by its own accelerations."""
    mujoco = pytest.importorskip("mujoco", reason="needs mujoco")
    drive = cd.load_drive(name)
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


@pytest.mark.parametrize("name", DRIVES)
def test_the_equations_of_the_modelica_text_are_those_of_the_chain(name):
    """Its equations, evaluated in Python line by line, accelerate as the state space does."""
    drive = cd.load_drive(name)
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
