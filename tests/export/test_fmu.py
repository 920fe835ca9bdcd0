"""FMUs validate, step as the interpreted loop to the bit, and refuse what they do not offer."""

import shutil
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.export.blocks import cable_block, controller_block, new_loop, system_block
from cabledrive.export.c99 import self_test, system_package
from cabledrive.export.door import write_folder
from cabledrive.export.fmu import fmu_package
from cabledrive.export.source import plant_loop
from cabledrive.export.translation.source import interpreted
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.assembly import rotor_turn
from cabledrive.mechanics.network.response import network_response
from cabledrive.reduction.modal_cable import modal_cable
from cabledrive.reduction.stretch_kernels import cable_motion, cable_step, start_cable
from cabledrive.reduction.stretches import new_stretch_state
from cabledrive.rig.closed_loop.loop_kernels import loop_step
from export.designs import COMPILERS, WARNINGS, checked, source_of
from network_samples import as_routes

fmpy = pytest.importorskip("fmpy", reason="needs fmpy")
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
ERROR = 3


@cache
def package(version, what, law="darc-4"):
    source = source_of(law)
    block = controller_block(source) if what == "controller" else system_block(source, what)
    files, _ = fmu_package(block, version)
    return next(iter(files.values()))


class Slave:
    """An FMU stepped by hand."""

    def __init__(self, folder, version, what, law="darc-4", content=None):
        path = folder / "one.fmu"
        path.write_bytes(content or package(version, what, law))
        self.described = fmpy.read_model_description(str(path))
        kind = {2: fmpy.fmi2.FMU2Slave, 3: fmpy.fmi3.FMU3Slave}[version]
        self.version, self.place = version, fmpy.extract(str(path), str(folder / "fmu"))
        identity = {2: self.described.guid, 3: self.described.instantiationToken}[version]
        self.fmu = kind(
            guid=identity,
            unzipDirectory=self.place,
            modelIdentifier=self.described.coSimulation.modelIdentifier,
            instanceName="one",
        )
        self.numbers = {one.name: one.valueReference for one in self.described.modelVariables}
        self.fmu.instantiate()

    def start(self, **values):
        if self.version == 2:
            self.fmu.setupExperiment(startTime=0.0)
        self.set(**values)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, **values):
        if values:
            setter = self.fmu.setReal if self.version == 2 else self.fmu.setFloat64
            setter([self.numbers[name] for name in values], list(values.values()))

    def get(self, *names):
        getter = self.fmu.getReal if self.version == 2 else self.fmu.getFloat64
        return list(getter([self.numbers[name] for name in names]))

    def step(self, k, size):
        self.fmu.doStep(currentCommunicationPoint=k * size, communicationStepSize=size)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("what", ["controller", "plant", "loop"])
def test_the_description_is_valid(version, what, tmp_path):
    from fmpy.validation import validate_fmu

    (tmp_path / "one.fmu").write_bytes(package(version, what))
    assert validate_fmu(str(tmp_path / "one.fmu")) == []


@pytest.mark.parametrize("version", [2, 3])
def test_the_controller_steps_as_the_interpreted_kernel_to_the_bit(version, tmp_path):
    law = source_of("darc-4").law
    vectors = self_test(law, 300)
    one = Slave(tmp_path, version, "controller")
    one.start()
    names = [v.name for v in one.described.modelVariables if v.causality == "input"]
    found = []
    for k, row in enumerate(np.column_stack((vectors.readings, vectors.references)).tolist()):
        one.set(**dict(zip(names, row, strict=True)))
        one.step(k, law.sample_time)
        found.append(one.get("command")[0])
    assert found == vectors.commands.tolist()


@pytest.mark.kernel  # cabledrive.rig.closed_loop.loop_kernels
@pytest.mark.parametrize(
    "law, samples",
    [("darc-4", 20), *(pytest.param(law, 10_000, marks=pytest.mark.verify) for law in ("darc-4", "lqg"))],
)
def test_the_loop_steps_as_the_interpreted_loop_to_the_bit(law, samples, tmp_path, measured):
    source = source_of(law)
    plant = plant_loop(source)
    state, step = new_loop(source.law, plant), interpreted(loop_step)
    angle, rise, dwell = 0.3, 0.2 * samples * source.law.sample_time, 0.1 * samples * source.law.sample_time
    state.path.motion.scalars[:] = (source.law.load_gear * angle, rise, dwell, 1.0)
    one = Slave(tmp_path, 2, "loop", law)
    one.start(angle=angle, rise=rise, dwell=dwell, pulses=1.0)
    numbers = (source.law.observer, source.law.law, source.law.reference, source.law.torque_limit)
    for k in range(samples):
        push = 0.01 if k % 60 > 30 else 0.0
        command, _ = step(plant.plant, plant.rig, *numbers, state, 0.0, push)
        one.set(load_torque=push)
        one.step(k, source.law.sample_time)
        found = one.get("command", "load_angle", "motor_speed", "slip")
        x = state.plant.x
        assert found == [command, x[2], x[3], float(state.plant.discrete[0])], f"sample {k}"
    measured(f"{law}: {samples} samples equal to the bit")


@pytest.mark.parametrize("version", [2, 3])
def test_a_step_of_another_size_is_an_error(version, tmp_path):
    one = Slave(tmp_path, version, "plant")
    one.start()
    with pytest.raises(fmpy.fmi1.FMICallException if version == 2 else Exception) as failed:
        one.step(0, 1e-3)
    assert getattr(failed.value, "status", ERROR) == ERROR
    assert one.get("load_angle") == [0.0]


@pytest.mark.parametrize("version", [2, 3])
def test_a_state_can_be_kept_and_taken_up_again(version, tmp_path):
    one = Slave(tmp_path, version, "plant")
    one.start()
    time = source_of("darc-4").law.sample_time

    def run(first):
        angles = []
        for k in range(first, first + 40):
            one.set(command=0.2)
            one.step(k, time)
            angles += one.get("load_angle")
        return angles

    run(0)
    fmu = one.fmu
    kept = fmu.getFMUstate() if version == 2 else fmu.getFMUState()
    first = run(40)
    (fmu.setFMUstate if version == 2 else fmu.setFMUState)(kept)
    assert run(40) == first
    assert first[-1] > 0.0


@pytest.mark.verify
@pytest.mark.parametrize("what", ["plant", "loop"])
def test_plant_and_loop_in_c_are_the_interpreted_kernels_to_the_bit(what, tmp_path):
    write_folder(tmp_path / "c", system_package(source_of("darc-4"), what))
    for compiler in COMPILERS:
        done = checked(tmp_path / "c", "-O2", *WARNINGS, compiler=compiler)
        assert done.returncode == 0, done.stdout


# --- The distributed cable in modes as an FMU: the kernel to the bit, the exact machine nearly
DRIVES = {"loop": "dissertation-1", "network": "corexy"}


@cache
def cable_package(name, version):
    block = cable_block(cd.load_drive(name))
    files, notes = fmu_package(block, version)
    return next(iter(files.values())), notes, block.words["cable"]


def slave(folder, name, version):
    return Slave(folder, version, "cable", content=cable_package(name, version)[0])


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", DRIVES.values())
def test_the_cable_steps_as_the_interpreted_kernel_to_the_bit(name, version, tmp_path, measured):
    from fmpy.validation import validate_fmu

    cable, samples = cable_package(name, version)[2], 120
    one = slave(tmp_path, name, version)
    assert validate_fmu(str(tmp_path / "one.fmu")) == []
    listed = [v.name for v in one.described.modelVariables]
    torques = listed[: len(cable.inputs)]
    n = len(cable.inputs) + (len(cable.spans) if cable.sine else 0)
    state, step = new_stretch_state(cable.numbers), interpreted(cable_step)
    plucks = np.array([1e-3, -4e-4]) if cable.sine else np.zeros(0)
    one.start(**{f"pluck_{span}": value for span, value in zip(cable.spans, plucks.tolist(), strict=False)})
    interpreted(start_cable)(plucks, state)
    tensions, places, speeds = np.zeros(len(cable.spans)), *np.zeros((2, len(cable.motions)))
    generator = np.random.default_rng(4)
    for k in range(samples):
        given = 1e-3 * generator.standard_normal(len(torques))
        one.set(**dict(zip(torques, given.tolist(), strict=True)))
        one.step(k, cable.interval)
        step(cable.numbers, state, given, tensions)
        interpreted(cable_motion)(cable.numbers, state, places, speeds)
        expected = [*places.tolist(), *speeds.tolist(), *tensions.tolist()]
        assert one.get(*listed[n : n + len(expected)]) == expected, f"sample {k}"
    assert one.get("holds") == [1.0]
    assert np.abs(places).max() > 0.0
    measured(f"{name}, FMI {version}: {samples} samples equal to the bit")


def test_a_slack_span_is_said(tmp_path):
    one, cable = slave(tmp_path, "dissertation-1", 2), cable_package("dissertation-1", 2)[2]
    one.start()
    one.set(motor_torque=50.0)
    for k in range(20):
        one.step(k, cable.interval)
    assert one.get("holds") == [0.0]
    one.set(motor_torque=0.0)
    one.step(20, cable.interval)
    assert one.get("holds") == [0.0]


@pytest.mark.kernel  # cabledrive.reduction.stretch_kernels
@pytest.mark.parametrize("name", ["corexy", "lift-2-to-1", "linear-axis", "camera-line"])
def test_a_network_in_modes_responds_as_its_exact_waves(name, measured):
    """The response to sampled inputs against the dynamic stiffness with its damping."""
    drive = cd.load_drive(name).listed
    cable, network = modal_cable(drive), network_of(as_routes(drive))
    numbers = cable.numbers
    rows = numbers.model.motions
    k = rows.shape[1]
    gaps = []
    for hertz in np.array([0.06, 0.13, 0.21]) * cable.highest:
        omega = 2.0 * np.pi * hertz
        z = np.exp(1j * omega * cable.interval)
        modes = np.linalg.solve(z * np.eye(2 * k) - numbers.along, numbers.push[:, 0])
        hold = (1.0 - np.exp(-1j * omega * cable.interval)) / (1j * omega * cable.interval)
        found = rows @ modes[:k] / hold
        turn = network.motion.dense(rotor_turn(network.motion, network.drive.driven[0]))[0]
        exact = network_response(network, np.array([omega]), turn, np.eye(rows.shape[0]))[0]
        gaps.append(float(np.abs(found - exact).max() / np.abs(exact).max()))
    measured(f"{name}: {100 * max(gaps):.2g} % of the largest motion up to a fifth of the highest mode")
    assert max(gaps) < 0.06, f"observed {gaps}"  # the modes left out give way as well


@pytest.mark.parametrize("name, rubs", [("dissertation-3", True), ("dissertation-transporter", False)])
def test_a_loop_that_the_fast_model_does_not_fit_is_written_as_linear_modes(name, rubs):
    """For its Coulomb friction, which is left out and said to be, or its carriage, which moves along."""
    block = cable_block(cd.load_drive(name))
    assert block.notes[0].startswith("linear modes of the network")
    assert [one.name for one in block.variables][:2] == ["drive_pulley_torque", "load_pulley_torque"]
    assert any("Coulomb friction is left out" in note for note in block.notes) is rubs
    assert any(one.name == "carriage_0_along_position" for one in block.variables) is not rubs


def test_the_cable_of_a_machine_without_a_motor_is_turned_where_a_run_turns_it(measured):
    drive, torque, samples = cd.load_drive("serpentine"), 0.5, 40
    cable = modal_cable(replace(drive, sensors=cd.Sensors(sample_rate=20e3)))
    assert cable.inputs == (("crank_torque", "N.m"), ("arm.turn_torque", "N.m"))
    state, tensions = new_stretch_state(cable.numbers), np.zeros(len(cable.spans))
    places, speeds = np.zeros((2, len(cable.motions)))
    for _ in range(samples):
        cable_step(cable.numbers, state, np.array([torque, 0.0]), tensions)
    cable_motion(cable.numbers, state, places, speeds)
    run = cd.simulate(drive, samples * cable.interval, torque=torque)
    exact = np.array(
        [run.rows[-1, [one.name for one in run.channels].index(name)] for name, _ in cable.motions]
    )
    gap = float(np.abs(places - exact).max() / np.abs(exact).max())
    measured(f"angles within {100 * gap:.2g} % of the nonlinear run")
    assert gap < 0.02, f"observed {gap}"


def test_the_tension_of_a_hanging_span_is_called_the_least_at_rest():
    """Of 40 m of rope the mean is 22 N above it; the spans of the fast model have one tension."""
    hanging, straight = (cable_block(cd.load_drive(name)) for name in ("lift-2-to-1", "dissertation-1"))
    words = [
        {one.about for one in block.variables if one.name.endswith("_tension")}
        for block in (hanging, straight)
    ]
    assert words == [{"least tension at rest, and how its mean changed"}, {"mean tension of the span"}]
    at_rest = cd.simulate(cd.load_drive("lift-2-to-1"), 1e-3)
    means = [
        at_rest.rows[0, k]
        for k, channel in enumerate(at_rest.channels)
        if channel.name.startswith("mean tension,")
    ]
    assert (np.array(means) - hanging.words["cable"].numbers.model.rest > 15.0).all(), f"observed {means}"


def test_a_loop_whose_fixed_pulley_nothing_drives_is_refused_by_what_is_missing():
    drive = cd.load_drive("dissertation-transporter").listed
    with pytest.raises(cd.InputRefused, match="no pulley turns by a torque"):
        modal_cable(replace(drive, pulley=tuple(replace(one, fixed=True) for one in drive.pulley)).machine)
    with pytest.raises(cd.InputRefused) as refused:
        modal_cable(replace(drive, pulley=(replace(drive.pulley[0], fixed=True), drive.pulley[1])).machine)
    assert "motor" not in str(refused.value), f"observed {refused.value}"


def test_ropes_that_lose_couple_the_modes_of_a_network(measured):
    """Three inertias on two springs, of which the light cable alone loses, by the matrices of its chain."""
    radius, rigidity, loss, joint, inertias = 0.02, 2e4, 10.0, 16.0, (5e-5, 2e-4, 2e-4)
    loop = cd.Drive(
        name="three inertias",
        kind="loop",
        cable=cd.Cable(given_rigidity=rigidity, mass_per_length=1e-6, pretension=100.0, axial_damping=loss),
        layout=cd.Layout(span_length=1.0, gravity=0.0),
        pulley=tuple(cd.Pulley(radius=radius, inertia=own) for own in inertias[:2]),
        motor=cd.Motor(inertia=inertias[2], joint_stiffness=joint),
    )
    machine = replace(as_routes(loop), sensors=cd.Sensors(sample_rate=20e3))
    model = modal_cable(machine).numbers.model
    link = 2.0 * radius**2 * np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    stiffness = rigidity * link + joint * np.array([[1.0, 0.0, -1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 1.0]])
    gaps = []
    for omega in 2.0 * np.pi * np.array([10.0, 50.0, 60.0, 120.0, 200.0]):
        modes = np.diag(model.natural**2 - omega**2) + 1j * omega * model.damping
        found = model.motions @ np.linalg.solve(modes, model.motions.T)
        exact = np.linalg.inv(stiffness + 1j * omega * loss * link - omega**2 * np.diag(inertias))
        gaps.append(float(np.abs(found / exact - 1.0).max()))
    measured(f"motions off by {max(gaps):.1e}")
    assert max(gaps) < 1e-3, f"observed {gaps}"
