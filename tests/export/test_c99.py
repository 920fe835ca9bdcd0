"""A controller in C is the interpreted kernel to the bit, and behaves as firmware has to."""

import ctypes
import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.control.controller_kernels import (
    new_target_state,
    own_target_step,
    start_target,
    target_step,
)
from cabledrive.control.numbers import start_estimates
from cabledrive.export.blocks import target_kernel
from cabledrive.export.c99 import commands_of, controller_package, references_of, rippled_readings, self_test
from cabledrive.export.door import write_folder
from cabledrive.export.single_precision import MARGIN, differenced, self_test_gap, single_precision
from cabledrive.export.source import designed, designed_loop
from cabledrive.rig.laws.registry import CONTROLLERS, OPEN_LOOPS
from cabledrive.trajectories import pulse
from command import refused
from export.designs import (
    COMPILERS,
    DRIVE,
    OWN,
    WARNINGS,
    built,
    checked,
    loop_of,
    needs_cc,
    replayed,
    source_of,
    step,
)

LAWS = [name for name in CONTROLLERS if name not in OPEN_LOOPS]


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    folder = tmp_path_factory.mktemp("export") / "law"
    write_folder(folder, controller_package(source_of("darc-4")))
    return folder


class Law:
    """The exported controller as a shared library."""

    def __init__(self, folder):
        done = built(folder, "-O2", "-shared", "-fPIC", name="law.so")
        assert done.returncode == 0, done.stderr
        self.library = ctypes.CDLL(str(folder / "law.so"))
        self.state = (ctypes.c_double * 2000)()

    def start(self, y):
        self.library.cd_init(self.state, (ctypes.c_double * len(y))(*y))

    def step(self, y, ref):
        u = ctypes.c_double()
        arrays = [(ctypes.c_double * len(values))(*values) for values in (y, ref)]
        kept = self.library.cd_step(self.state, *arrays, ctypes.byref(u))
        return kept, u.value


@needs_cc
def test_the_self_test_fails_on_a_command_that_differs_in_its_last_bit(package, tmp_path):
    shutil.copytree(package, tmp_path / "law")
    lines = (tmp_path / "law" / "vectors.csv").read_text().splitlines()
    *inputs, command = lines[300].split(",")
    lines[300] = ",".join([*inputs, f"{np.nextafter(float(command), 1.0):.17g}"])
    (tmp_path / "law" / "vectors.csv").write_text("\n".join(lines) + "\n")
    assert checked(tmp_path / "law").returncode == 1


@needs_cc
@pytest.mark.parametrize("compiler", ["cc", *COMPILERS])
@pytest.mark.parametrize("level", ["-O0", "-O3"])
def test_no_compiler_warns_and_no_level_moves_a_bit(package, compiler, level):
    done = checked(package, level, *WARNINGS, compiler=compiler)
    assert done.returncode == 0, done.stdout
    assert "1000 samples, command kept at 7, largest difference 0 N m" in done.stdout


@needs_cc
@pytest.mark.parametrize("flag", ["-Ofast", "-ffast-math"])
def test_fast_math_is_refused_by_the_sources(package, flag):
    done = built(package, flag)
    assert done.returncode != 0
    assert "-ffast-math" in done.stderr


@needs_cc
@pytest.mark.verify
@pytest.mark.parametrize("name", LAWS)
def test_every_law_is_equal_to_the_bit_over_ten_thousand_samples(name, tmp_path, measured):
    source = source_of(name)
    files = controller_package(source)
    vectors = self_test(source.law, 10_000)
    files["vectors.csv"] = vectors.csv(source.law.encoders, source.law.columns)
    write_folder(tmp_path / "law", files)
    for compiler in COMPILERS:
        for level in ("-O0", "-O1", "-O2", "-O3"):
            done = checked(tmp_path / "law", level, *WARNINGS, compiler=compiler)
            assert done.returncode == 0, f"{compiler} {level}: {done.stdout}"
    measured(f"{name}: 0 N m over 10,000 samples, {', '.join(COMPILERS)}, -O0 to -O3")


@needs_cc
def test_readings_that_are_no_numbers_hold_the_last_command(package):
    law = Law(package)
    vectors = self_test(source_of("darc-4").law, 60)
    law.start(vectors.readings[0])
    for y, ref in zip(vectors.readings, vectors.references, strict=True):
        _, last = law.step(y, ref)
    for bad in (np.nan, np.inf, -np.inf):
        assert law.step([0.01, bad, 0.01], vectors.references[-1]) == (1, last)
    assert law.step(vectors.readings[-1], [np.nan] * 9) == (1, last)
    assert law.library.cd_missed(law.state) == 4
    u = ctypes.c_double()
    assert (law.library.cd_miss(law.state, ctypes.byref(u)), u.value) == (1, last)
    assert law.step(vectors.readings[-1], vectors.references[-1])[0] == 0
    assert law.library.cd_missed(law.state) == 0


@needs_cc
def test_a_plant_that_is_whole_samples_late_passes_its_self_test(tmp_path):
    drive = replace(DRIVE, sensors=replace(DRIVE.sensors, delay=1e-3))
    cd.export_to(tmp_path / "c", drive, "c99", controller="pd", what="plant")
    done = checked(tmp_path / "c", "-O2", "-fsanitize=undefined,float-divide-by-zero", *WARNINGS)
    assert done.returncode == 0, done.stdout
    assert done.stderr == ""


@needs_cc
@pytest.mark.parametrize("bits", [16, 32])
def test_counters_wrap_in_both_directions(package, bits):
    law = Law(package)
    word, read = {16: ctypes.c_uint16, 32: ctypes.c_uint32}[bits], getattr(law.library, f"cd_read{bits}")
    encoders, y = (ctypes.c_uint64 * 20)(), (ctypes.c_double * 3)()
    law.library.cd_encoders_init(encoders)
    top = 2**bits
    counts = source_of("darc-4").law.counts
    for place, expected in ((top - 3, 0), (2, 5), (top - 1, 2), (top // 2, 3 - top // 2)):
        read(encoders, (word * 3)(place, 0, place), y)
        assert y[0] == counts[0] * expected
        assert y[1] == 0.0
        assert y[2] == counts[2] * expected


@needs_cc
def test_a_counter_just_below_zero_costs_single_precision_no_count(tmp_path):
    """An angle of 2**32 counts is known to 256 of them in a float: the torque went to its limit."""
    law = differenced(source_of("pd").law)
    write_folder(tmp_path / "law", controller_package(replace(source_of("pd"), law=law), 1e-3))
    library = Law(tmp_path / "law").library
    for begin in (0, 2**32 - 5, 2**31 + 12345):
        encoders, y = (ctypes.c_uint64 * 20)(), (ctypes.c_float * 3)()
        for moved in (0, 1, 7, -2, 40000):
            library.cd_read32(encoders, (ctypes.c_uint32 * 3)(*[(begin + moved) % 2**32] * 3), y)
            assert list(y) == [np.float32(count) * np.float32(moved) for count in law.counts]


@needs_cc
def test_the_generator_in_c_makes_the_rows_of_the_interpreted_kernel(package):
    source = source_of("darc-4")
    rows = references_of(source.law, 300)
    law = Law(package)
    path, row = (ctypes.c_double * 200)(), (ctypes.c_double * 9)()
    time = 300 * source.law.sample_time
    double = ctypes.c_double
    law.library.cd_reference_init(path, double(0.02), double(0.4 * time), double(0.1 * time), 1)
    for k in range(300):
        law.library.cd_reference_row(path, double(k * source.law.sample_time), row)
        assert list(row) == rows[k].tolist()


@pytest.mark.kernel  # cabledrive.control.controller_kernels
def test_the_step_of_a_target_is_that_of_the_rig():
    """Readings and commands of a run on the rig, replayed: settled filter, same law; and one's own."""
    law = source_of("darc-3").law
    state = new_target_state(law.observer, law.law, law.late_samples)
    own, target = designed(DRIVE, OWN).law, own_target_step(step, True)
    kernel = target_kernel(own)
    for loop, one, begin, go in (
        (
            loop_of("darc-3"), law,
            lambda y: start_target(start_estimates(law.law), state, y),
            lambda y, row: target_step(law.observer, law.law, law.torque_limit, state, y, row),
        ),
        (
            designed_loop(DRIVE, OWN), own,
            lambda y: start_target(kernel.begin, kernel.state, y),
            lambda y, row: target(*kernel.numbers.values(), own.torque_limit, kernel.state, y, row),
        ),
    ):  # fmt: skip
        found, rig = replayed(loop, one, begin, go, 300)
        np.testing.assert_allclose(found, rig, rtol=1e-6, atol=1e-11)


def test_the_exported_folder_runs_on_the_rig_as_it_was_exported(tmp_path):
    out = tmp_path / "pd"
    found = cd.export_to(out, "dissertation-3", "c99", controller="pd")
    assert sorted(path.name for path in out.iterdir()) == found["files"]
    assert found["drive_hash"] == cd.content_hash(cd.load_drive("dissertation-3").listed)
    assert found["sample_time"] == pytest.approx(2e-4)
    done = cd.track(cd.load_drive(str(out / "drive.toml")).listed, controller=out)
    assert done.summary["controller"] == "pd"
    assert done.summary["gains"]["file"] == str(out / "controller.json")
    again = cd.export_to(tmp_path / "again", out, "c99")
    assert (tmp_path / "again" / "cabledrive_law.c").read_text() == (out / "cabledrive_law.c").read_text()
    assert again["files"] == found["files"]


def test_the_exported_folder_of_an_axis_of_routes_runs_from_its_own_file(tmp_path):
    """The file is the machine's, whose axis is the one that the law was made for."""
    out = tmp_path / "pd"
    cd.export_to(out, "printer-idlers", "c99", controller="pd")
    drive = cd.load_drive(str(out / "drive.toml")).listed
    assert cd.content_hash(drive) == cd.content_hash(cd.load_drive("printer-idlers"))
    assert cd.track(drive, controller=out).summary["controller"] == "pd"
    assert cd.export_to(tmp_path / "again", out, "c99", what="loop")["files"]


@pytest.mark.parametrize("order", ["nine", [9]])
def test_an_order_that_is_no_number_is_no_controller(order, tmp_path):
    cd.export_to(tmp_path / "pd", "dissertation-3", "c99", controller="pd")
    kept = tmp_path / "pd" / "controller.json"
    kept.write_text(json.dumps(json.loads(kept.read_text()) | {"order": order}))
    with pytest.raises(cd.InputRefused, match="is no controller"):
        cd.track(cd.load_drive("dissertation-3").listed, controller=kept)


def test_a_law_takes_the_rises_with_which_its_study_tested_it(tmp_path):
    """The exported reference, and a run of the rig from the folder, are of the order that is kept."""
    cd.export_to(tmp_path / "first", "dissertation-3", "c99", controller="lqg")
    kept = tmp_path / "first" / "controller.json"
    texts = {11: (tmp_path / "first" / "cabledrive_law.h").read_text()}
    kept.write_text(json.dumps(json.loads(kept.read_text()) | {"order": 9}))
    cd.export_to(tmp_path / "second", kept.parent, "c99")
    texts[9] = (tmp_path / "second" / "cabledrive_law.h").read_text()
    for order, text in texts.items():
        assert f"smooth rises of order {order}." in text
    run = cd.track(cd.load_drive("dissertation-3").listed, controller=kept.parent)
    assert run.summary["motion"]["order"] == 9
    expected = pulse(np.radians(45.0), 0.5, 0.5, order=9)(run.time, 0)[0]
    np.testing.assert_allclose(run.reference, expected, atol=1e-9)


def test_random_inputs_give_what_the_interpreted_kernel_gives(package):
    """Readings with infinities and NaN at random places, references of noise."""
    law = source_of("darc-4").law
    generator = np.random.default_rng(7)
    readings = rippled_readings(law, 200, generator)
    references = 1e-2 * generator.standard_normal((200, len(law.columns)))
    for bad in (np.nan, np.inf, -np.inf):
        readings[generator.integers(1, 200, 4), generator.integers(0, 3, 4)] = bad
        references[generator.integers(1, 200, 4), generator.integers(0, 9, 4)] = bad
    expected, kept = commands_of(law, readings, references)
    compiled = Law(package)
    compiled.start(readings[0])
    found = [compiled.step(y, row) for y, row in zip(readings, references, strict=True)]
    assert [bool(one) for one, _ in found] == kept.tolist()
    assert [u for _, u in found] == expected.tolist()


# --- A controller in single precision: other coordinates, the same closed loop, or a refusal
@pytest.mark.parametrize("name", ["darc-3", "darc-4-damped", "pid"])
def test_differences_of_angles_are_the_same_controller(name):
    """In double precision nothing but rounding changes."""
    law = source_of(name).law
    other = differenced(law)
    readings = rippled_readings(law, 150, np.random.default_rng(1))
    one, _ = commands_of(law, readings, references_of(law, 150))
    two, _ = commands_of(other, readings, references_of(other, 150))
    gap = np.abs(one - two).max() / np.abs(one).max()
    assert gap < 1e-7, f"observed {gap:.1e}"
    assert np.abs(one).max() > 0.01


@pytest.mark.parametrize("compiler", COMPILERS)
def test_single_precision_in_c_is_within_the_tolerance_of_its_self_test(compiler, tmp_path):
    source = source_of("pd")
    law = differenced(source.law)
    files = controller_package(replace(source, law=law), MARGIN * self_test_gap(law)[0])
    assert "typedef float real;" in files["cabledrive_law.h"]
    write_folder(tmp_path / "law", files)
    done = checked(tmp_path / "law", "-O2", *WARNINGS, "-Wdouble-promotion", compiler=compiler)
    assert done.returncode == 0, done.stdout
    assert "difference 0 N m" not in done.stdout  # single it is


@pytest.mark.verify
@pytest.mark.parametrize("name", ["darc-3", "darc-4", "darc-4-damped", "pd", "lqg"])
def test_the_closed_loop_keeps_its_error_in_single_precision(name, measured):
    _, factor, tolerance = single_precision(source_of(name))
    measured(f"{name}: factor {factor:.4f}, self-test {tolerance:.1e} N m")
    assert 0.5 < factor < 1.1


@pytest.mark.verify
@pytest.mark.parametrize("bound, words", [("ACCEPTED", "factor of 1"), ("TESTABLE", "amplifies rounding")])
def test_a_law_beyond_a_bound_is_refused_in_single_precision(bound, words, monkeypatch):
    monkeypatch.setattr(f"cabledrive.export.single_precision.{bound}", 1e-9)
    refused(lambda: single_precision(source_of("darc-4")), words)


# --- Every law on every packaged drive
PAIRS = [(drive, law) for drive in cd.packaged_drives("loop", "line") for law in CONTROLLERS]


@pytest.mark.verify
@needs_cc
@pytest.mark.parametrize("drive, law", PAIRS)
def test_a_pair_is_exported_and_passes_or_is_refused_as_track_refuses_it(drive, law, tmp_path):
    refused = None
    try:
        cd.export_to(tmp_path / "out", drive, "c99", controller=law)
    except (cd.InputRefused, cd.NotComputed) as refusal:
        refused = str(refusal)
    if refused is not None:
        with pytest.raises((cd.InputRefused, cd.NotComputed)):  # by what the law needs, or the motion first
            cd.track(cd.load_drive(drive).listed, controller=law)
        assert "\n" not in refused
        return
    done = checked(tmp_path / "out", "-O2", *WARNINGS)
    assert done.returncode == 0, done.stdout


# --- A controller of the user's own is exported by the same door: C is its step to the bit
def on_readings(gains, state, measurement, reference):
    stiffness, damping = gains
    speed = (measurement[0] - state[0]) / 2e-4
    state[0] = measurement[0]
    return state, stiffness * (reference[0] - measurement[0]) - damping * speed


UNFILTERED = cd.OwnController(
    step=on_readings,
    gains=(0.5, 0.02),
    initial_state=[0.0],
    name="unfiltered",
    measures="readings",
    follows="motion",
)


@needs_cc
@pytest.mark.parametrize("own", [OWN, UNFILTERED], ids=lambda own: own.name)
def test_a_controller_of_ones_own_passes_its_self_test_to_the_bit(own, tmp_path):
    made = cd.export_to(tmp_path / "c", DRIVE, "c99", controller=own)
    assert made["sample_time"] == pytest.approx(2e-4)
    done = checked(tmp_path / "c", "-O2", *WARNINGS)
    assert done.returncode == 0, done.stdout
    assert "1000 samples, command kept at 7, largest difference 0 N m" in done.stdout
