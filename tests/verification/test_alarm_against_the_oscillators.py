"""The alarm of planned motions: no miss against the oscillators, no false alarm beyond the margin."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.modes.tuning import tuned_pretension
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.motion_kernels import exact_stiffness, linear_response, march_from, transitions
from cabledrive.studies.alarm import ALARM, alarm
from cabledrive.studies.parametric_growth import nonlinear_largest
from cabledrive.studies.planned_motion import PlannedMotion, course_of
from resonance_samples import damped

FLOOR, LIMIT = 1e-5, 5e-4


def transporter():
    drive = cd.load_drive("dissertation-transporter", overrides=["cable.transverse_damping=2"])
    load = replace(drive.load_pulley, viscous_friction=3e-6)
    return replace(drive, pulley=(drive.drive_pulley, load))


def drives():
    """Three machines, each near the tuning of its empty span."""
    machines = damped(2.0, 8.0), transporter(), cd.load_drive("printer-belt")
    return [replace(m, cable=replace(m.cable, pretension=tuned_pretension(m))) for m in machines]


def random_motion(drive, rng, duration=2.0):
    """A chirp near the pulley mode, a jerk on top, a drift of the tension, a travelling carriage.

    Its size makes the pulley mode swing to 3-80 % of the amplitude at which a span goes slack.
    """
    time = np.linspace(0.0, duration, 20_001)
    model = autoparametric_model(drive)
    ratio = np.linspace(rng.uniform(0.96, 1.02), rng.uniform(0.98, 1.04), time.size)
    phase = model.natural * np.cumsum(ratio) * (time[1] - time[0])
    jerk = 3 * np.tanh((time - rng.uniform(0, duration)) / 0.01) * rng.integers(0, 2)
    tension = drive.cable.pretension * np.linspace(*rng.uniform(0.93, 1.07, 2), time.size)
    carriage = None
    if drive.carriage:
        ends = drive.carriage[0].position * rng.uniform(0.9, 1.1, 2)
        carriage = ends[0] + (ends[1] - ends[0]) * 0.5 * (1 - np.cos(np.pi * time / duration))
    unit = PlannedMotion(time=time, torque=np.sin(phase) + jerk, pretension=tension, carriage=carriage)
    course = course_of(drive, unit, 1)
    share = 10 ** rng.uniform(-1.5, -0.1)
    return replace(unit, torque=unit.torque * share * np.min(course.slack) / np.max(np.abs(course.q)))


def true_largest(drive, motion):
    """Nonlinear oscillators from a floor at two dozen instants, over two phases and each mode."""
    largest = 0.0
    for number in (1, 2, 3):
        course = course_of(drive, motion, number)
        for start in np.linspace(0, course.time.size, 24, endpoint=False).astype(int):
            for mode in range(course.across.shape[0]):
                largest = max(largest, float(nonlinear_largest(course, mode, int(start), FLOOR)[mode]))
    return largest


def judged(count, seed):
    """Rows of what the alarm and the oscillators say."""
    rng, machines = np.random.default_rng(seed), drives()
    for number in range(count):
        drive = machines[number % len(machines)]
        motion = random_motion(drive, rng)
        result = alarm(drive, motion, floor=FLOOR, limit=LIMIT)
        if result.slack:
            continue
        truth = true_largest(drive, motion)
        yield drive.name, result, truth


def check(rows, measured):
    misses = [row for row in rows if row[2] > LIMIT and row[1].verdict != ALARM]
    false = [row for row in rows if row[2] <= LIMIT * np.exp(-0.5) and row[1].verdict == ALARM]
    table = [(name, result.verdict, result.modes[0].largest, truth) for name, result, truth in rows]
    beyond = sum(truth > LIMIT for _, _, truth in rows)
    measured(
        f"{len(rows)} motions, {beyond} beyond the limit: {len(misses)} missed, {len(false)} false alarms"
    )
    assert not misses, table
    assert not false, table


def test_alarm_misses_nothing_of_a_few_motions(measured):
    check(list(judged(3, 1)), measured)


@pytest.mark.verify
def test_alarm_on_fifty_motions_of_three_drives(measured):
    rows = list(islice(judged(80, 0), 50))
    assert len(rows) == 50
    assert sum(truth > LIMIT for _, _, truth in rows) >= 10
    check(rows, measured)


@pytest.mark.kernel
def test_compiled_march_along_a_motion_equals_its_python():
    """cabledrive.reduction.motion_kernels, compiled and as Python."""
    rng, n, h = np.random.default_rng(0), 200, 1e-3
    natural, damping, force = 500 + rng.uniform(-1, 1, n), rng.uniform(1, 5, n), rng.standard_normal(n)
    across, lift = 250 + rng.uniform(-1, 1, (2, n)), 1e7 * rng.standard_normal((2, n))
    cubic, push = 1e7 * np.ones((2, 2)), 1e5 * rng.standard_normal((2, n))
    edges = np.array([0, 90, n])

    def runs(kernel):
        place, rate = np.empty(n), np.empty(n)
        kernel(linear_response)(natural, damping, force, h, place, rate)
        out = np.empty((2, 2, 2))
        kernel(transitions)(across[0], lift[0], place, 2.0, h, edges, out)
        a, b, top = np.array([1e-4, 2e-4]), np.zeros(2), np.zeros(2)
        state = (place[20], rate[20], a, b, top)
        kernel(march_from)(20, natural, damping, force, push, across, lift, cubic, 2.0, h, *state)
        return place, out, top, kernel(exact_stiffness)(1e4, h)

    for one, other in zip(runs(lambda k: k), runs(lambda k: getattr(k, "py_func", k)), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9)


def test_transition_turns_by_exactly_the_frequency():
    n, h, w = 1000, 1e-3, 700.0
    out = np.empty((1, 2, 2))
    transitions(np.full(n, w), np.zeros(n), np.zeros(n), 0.0, h, np.array([0, n]), out)
    assert np.trace(out[0]) / 2 == pytest.approx(np.cos(w * n * h), abs=1e-9)


def test_motion_far_from_tuning_is_safe():
    time = np.linspace(0, 1, 1001)
    result = alarm(cd.load_drive("dissertation-2"), PlannedMotion(time=time, torque=1e-4 * np.sin(10 * time)))
    assert result.verdict == "safe"
    assert result.remedy == "none needed"


@pytest.mark.parametrize(
    "change, word",
    [
        ({"time": np.array([0.0, 0.0])}, "ascend"),
        ({"torque": np.array([0.0, np.nan])}, "finite"),
        ({"carriage": np.array([0.1, 0.2])}, "carriage"),
    ],
)
def test_motions_that_make_no_sense_are_refused(change, word):
    fields = {"time": np.array([0.0, 1.0]), "torque": np.zeros(2)} | change
    with pytest.raises(cd.InputRefused, match=word):
        alarm(damped(2.0, 8.0), PlannedMotion(**fields))


def test_floor_above_the_limit_is_refused():
    motion = PlannedMotion(time=np.array([0.0, 1.0]), torque=np.zeros(2))
    with pytest.raises(cd.InputRefused, match="floor"):
        alarm(damped(2.0, 8.0), motion, floor=1e-3, limit=1e-4)
