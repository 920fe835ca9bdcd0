"""A controller of the user's own runs on the rig exactly as a packaged one."""

from types import SimpleNamespace

import numba
import numpy as np
import pytest

import cabledrive as cd
from cabledrive.control import ControllerProtocol
from cabledrive.control.linear_laws import pd_law, pid_law
from cabledrive.control.own_controller import checked_controller
from cabledrive.mechanics.compiled import numba_at_hand, why_plain
from cabledrive.reduction.models import lumped_model
from cabledrive.reduction.reflected import reflected
from cabledrive.rig import Disturbance, Motion, RigOptions, track
from cabledrive.rig.closed_loop.loop import close_loop, run
from cabledrive.rig.comparison import compared
from cabledrive.rig.laws.own_law import own_law
from cabledrive.rig.setting import sample_interval
from cabledrive.rig.trial import spec_for

DRIVE = cd.load_drive("dissertation-3")
CHAIN, INTERVAL = reflected(lumped_model(DRIVE, 4))[0], sample_interval(DRIVE)
SHORT = Motion(angle=5.0, rise=0.15, dwell=0.05, order=11)


def feedback(gains, state, measurement, reference):
    """State feedback on the reference's own torque: any of the packaged laws without memory."""
    return state, reference[-1] + gains @ (measurement - reference[:-1])


def with_memory(gains, state, measurement, reference):
    """A linear law with states, as its matrices say: command first, then the next state."""
    matrix, row = gains
    error = measurement - reference[:-1]
    command = reference[-1] + row @ np.concatenate((state, error))
    return matrix @ np.concatenate((state, error, np.array([0.0]))), command


def largest(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one - other).max())


DISTURBED = RigOptions(
    disturbances=(Disturbance(torque=0.3, start=0.1, end=0.2, on="motor"),),
    jitter=2e-6,
    blind=("load", 0.1, 0.11),
)


@pytest.mark.parametrize(
    "options, settings",
    [
        (RigOptions(), ()),
        (RigOptions(ideal_sensors=True, smooth_friction=True), ()),
        (RigOptions(observer="difference"), ()),
        (DISTURBED, ("sensors.delay=0.3 ms", "motor.torque_limit=0.25 N m")),
    ],
    ids=["encoders", "ideal", "difference", "delay, limit, dropout, jitter, disturbance"],
)
def test_a_pd_in_plain_python_is_the_packaged_pd(options, settings, measured):
    """Sample by sample: the same filter, feedforward, torque limit, delay, encoders."""
    drive = cd.load_drive("dissertation-3", overrides=settings)
    row = pd_law(reflected(lumped_model(drive, 4))[0], 5.0, INTERVAL).rows[0]
    packaged = track(drive, controller="pd", bandwidth=5.0, motion=SHORT, options=options)
    own = track(drive, controller=cd.OwnController(step=feedback, gains=row), motion=SHORT, options=options)
    assert bool(settings) == (packaged.summary["saturated_fraction"] > 0.0)
    torque, load = largest(packaged.torque, own.torque), largest(packaged.load_angle, own.load_angle)
    measured(f"{torque:.1e} N m, {load:.1e} rad")
    assert max(torque, load) < 1e-10, f"observed {torque:.1e} N m, {load:.1e} rad"
    assert own.interpreted == "controller"
    assert own.summary["interpreted"] == "controller"
    assert packaged.interpreted == why_plain()
    for key in ("peak_error_deg", "saturated_fraction", "invalid_samples", "encoder_error_deg"):
        assert own.summary[key] == pytest.approx(packaged.summary[key], abs=1e-9), key


def test_a_controller_with_memory_is_the_packaged_pid():
    drive = cd.load_drive("dissertation-3")
    packaged = track(drive, controller="pid", bandwidth=2.0, motion=SHORT)
    law = pid_law(CHAIN, 2.0, packaged.summary["gains"]["notch_hz"], INTERVAL)
    own = cd.OwnController(
        step=with_memory, gains=(law.matrix, law.rows[0]), initial_state=np.zeros(3), sample_time=INTERVAL
    )
    found = largest(packaged.torque, track(drive, controller=own, motion=SHORT).torque)
    assert found < 1e-9, f"observed {found:.1e} N m"


@pytest.mark.verify
def test_on_the_distributed_cable_too():
    row, options = pd_law(CHAIN, 5.0, INTERVAL).rows[0], RigOptions(segments=3)
    short = Motion(angle=3.0, rise=0.07, dwell=0.01, order=11)
    packaged = track(DRIVE, controller="pd", bandwidth=5.0, motion=short, options=options, plant="cable")
    own = cd.OwnController(step=feedback, gains=row)
    found = track(DRIVE, controller=own, motion=short, options=options, plant="cable")
    difference = largest(packaged.torque, found.torque)
    assert difference < 1e-10, f"observed {difference:.1e} N m"
    assert largest(packaged.tensions, found.tensions) < 1e-8


def test_readings_come_in_counts_and_the_wanted_motion_with_its_derivatives():
    seen = []

    def step(gains, state, measurement, reference):
        seen.append((measurement, reference))
        return state + 1.0, gains * (reference[0] - measurement[-1])

    own = cd.OwnController(
        step=step, gains=0.3, initial_state=[0.0], measures="readings", follows="motion", name="by counts"
    )
    found = track(DRIVE, controller=own, motion=SHORT)
    readings, reference = (np.array(part) for part in zip(*seen, strict=True))
    np.testing.assert_array_equal(readings, found.readings)
    np.testing.assert_allclose(reference[:, 0], found.reference * load_gear(), atol=1e-15)
    rate = np.gradient(reference[:, 0], INTERVAL)
    np.testing.assert_allclose(reference[5:-5, 1], rate[5:-5], atol=1e-3 * np.abs(rate).max())
    assert found.summary["controller"] == "by counts"


def load_gear() -> float:
    return DRIVE.load_pulley.radius / DRIVE.drive_pulley.radius


def test_draws_run_the_users_controller_on_the_same_plants():
    row = pd_law(CHAIN, 5.0, INTERVAL).rows[0]
    packaged = track(DRIVE, controller="pd", bandwidth=5.0, motion=SHORT, draws=2)
    own = track(DRIVE, controller=cd.OwnController(step=feedback, gains=row), motion=SHORT, draws=2)
    for key, value in packaged.summary["over_draws"].items():
        assert own.summary["over_draws"][key] == pytest.approx(value, abs=1e-9) if value is not None else True


def test_a_comparison_takes_it_beside_packaged_laws():
    options = RigOptions(forbid_slack=False)
    spec = spec_for(DRIVE, SHORT, options=options)
    own = cd.OwnController(step=feedback, gains=pd_law(CHAIN, 5.0, INTERVAL).rows[0], name="mine")
    found = compared(
        DRIVE, ["pd", own], ["damped"], 2, 5, spec, SHORT, options=options, settings={("pd", "damped"): 5.0}
    )
    assert [one.law for one in found] == ["pd", "mine"]
    assert np.isnan(found[1].setting)
    np.testing.assert_allclose(found[0].draws.scores, found[1].draws.scores, atol=1e-9)


def refused(**parts):
    parts = {"step": feedback, "gains": np.zeros(6)} | parts
    with pytest.raises(cd.InputRefused) as refusal:
        track(DRIVE, controller=SimpleNamespace(**parts), motion=SHORT)
    words = str(refusal.value)
    assert "\n" not in words
    return words


def late(value):
    """Right for a hundred samples, then the value as a command."""
    count = iter(range(10**6))

    def step(gains, state, measurement, reference):
        return state, (reference[-1] if next(count) < 100 else value)

    return step


@pytest.mark.parametrize(
    "parts, named",
    [
        ({"step": late(np.nan), "name": "broken"}, ["broken", "nan", "sample 100", "0.02 s"]),
        ({"step": late(np.zeros(2))}, ["shape (2,)", "sample 100"]),
        ({"step": late("fast")}, ["sample 100", "numbers"]),
        ({"step": lambda g, s, m, r: (np.zeros(3), 0.0)}, ["(3,)", "(0,)", "initial_state"]),
        ({"step": lambda g, s, m, r: 0.0}, ["(state, command)"]),
        ({"step": lambda g, s, m, r: (s * np.nan, 0.0), "initial_state": [1.0]}, ["state", "finite"]),
        ({"initial_state": [[1.0]]}, ["initial_state"]),
        ({"initial_state": "no"}, ["initial_state"]),
        ({"sample_time": 1e-3}, ["sample_time", "0.001 s", "0.0002 s"]),
        ({"sample_time": "fast"}, ["sample_time"]),
        ({"shafts": ("load", "motor")}, ["shafts", "motor, drive, load"]),
        ({"measures": "tension"}, ["measures", "states", "readings"]),
        ({"follows": 3}, ["follows", "inverse", "motion"]),
        ({"name": "lqg"}, ["lqg", "packaged"]),
        ({"name": ""}, ["name"]),
    ],
)
def test_what_it_must_not_return_or_be_is_named_in_one_line(parts, named):
    words = refused(**parts)
    assert all(part in words for part in named), words


@pytest.mark.parametrize("given", [feedback, 7, cd.OwnController, object(), ["pd"]])
def test_what_is_no_controller_is_one_line(given):
    with pytest.raises(cd.InputRefused, match="controller") as refusal:
        track(DRIVE, controller=given, motion=SHORT)
    assert "OwnController" in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_settings_of_packaged_laws_are_refused():
    own = cd.OwnController(step=feedback, gains=np.zeros(6))
    for setting in ({"bandwidth": 5.0}, {"adapt": False}):
        with pytest.raises(cd.InputRefused, match=next(iter(setting))):
            track(DRIVE, controller=own, motion=SHORT, **setting)


@pytest.mark.kernel
def test_the_loop_around_a_compiled_controller_is_that_sample_by_sample():
    """`cabledrive.rig.closed_loop.own_kernels` with `cabledrive.control.controller_kernels`, against the loop
    in Python, with a dropout and a memory.
    """
    spec = spec_for(DRIVE, SHORT)
    options = RigOptions(blind=("load", 0.1, 0.11))
    law = pid_law(CHAIN, 2.0, 28.0, INTERVAL)
    own = cd.OwnController(step=with_memory, gains=(law.matrix, law.rows[0]), initial_state=np.zeros(3))
    loop = close_loop(DRIVE, DRIVE, own_law(own, spec), SHORT, options, np.random.default_rng(1))
    plain = run(loop)
    np.testing.assert_array_equal(plain.log, run(loop).log)
    compiled = cd.OwnController(step=COMPILED, gains=own.gains, initial_state=np.zeros(3))
    found = run(close_loop(DRIVE, DRIVE, own_law(compiled, spec), SHORT, options, np.random.default_rng(1)))
    assert found.interpreted == (None if numba_at_hand() else "controller")
    assert plain.interpreted == "controller"
    assert found.state.summary[6] == plain.state.summary[6] > 0
    np.testing.assert_allclose(found.log, plain.log, rtol=0.0, atol=1e-9)


COMPILED = numba.njit(with_memory)


def test_a_compiled_controller_whose_numbers_overflow_is_named():
    gains = (np.full((3, 10), 1e30), np.zeros(9))
    own = cd.OwnController(step=COMPILED, gains=gains, initial_state=np.zeros(3), name="fifty")
    with pytest.raises(cd.InputRefused, match=r'"fifty" returned .* finite.* at t = .* s \(sample \d+\)'):
        track(DRIVE, controller=own, motion=SHORT)


def test_a_step_that_does_not_compile_is_one_line():
    @numba.njit
    def step(gains, state, measurement, reference):
        return state, reference.no_such_thing

    with pytest.raises(cd.InputRefused, match=r"own controller.*cannot be compiled") as refusal:
        track(DRIVE, controller=cd.OwnController(step=step), motion=SHORT)
    assert "\n" not in str(refusal.value)


def test_the_protocol_is_structural():
    class Mine:
        name, gains, initial_state, sample_time = "mine", 2.0, [0.0], None
        shafts, measures, follows = ("load",), "states", "motion"

        def step(self, gains, state, measurement, reference):
            return state, gains * (reference[0] - measurement[0]) - 0.01 * measurement[1]

    own = checked_controller(Mine())
    assert (own.name, own.shafts, own.follows) == ("mine", ("load",), "motion")
    assert isinstance(Mine(), ControllerProtocol)
    assert track(DRIVE, controller=Mine(), motion=SHORT).summary["controller"] == "mine"


def test_a_run_is_a_table_a_picture_and_a_few_lines(tmp_path):
    run_ = track(
        DRIVE, controller=cd.OwnController(step=feedback, gains=np.zeros(6), name="<own>"), motion=SHORT
    )
    table = run_.to_dataframe()
    assert list(table) == [
        *("reference", "load_angle", "error", "torque"),
        *("motor_encoder", "drive_encoder", "load_encoder"),
    ]
    assert np.degrees(table["error"].abs().max()) == pytest.approx(run_.summary["peak_error_deg"])
    np.testing.assert_array_equal(table.index, run_.time)
    figure = run_.plot()
    assert len(figure.axes) == 3
    assert figure.axes[1].lines[0].get_ydata().max() == pytest.approx(np.degrees(run_.error.max()))
    assert f"{run_.summary['peak_error_deg']:.4f} deg" in repr(run_)
    assert "interpreted" in repr(run_)
    assert "&lt;own&gt;" in run_._repr_html_()
    assert len(repr(run_)) < 600
