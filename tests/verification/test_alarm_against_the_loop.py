"""The alarm, and the oscillators it trusts, against the exact loop: growth from a floor along random motions.

The loop is cut for one pretension and its carriages stand, so each random motion keeps the tension and the
place that it has half-way; torque, chirp and jerks are as they were.
"""

from dataclasses import replace

import numpy as np
import pytest
from test_alarm_against_the_oscillators import FLOOR, LIMIT, drives, random_motion

import cabledrive as cd
from cabledrive.studies.alarm import ALARM, alarm
from cabledrive.studies.alarm_referee import exact_largest, without_weight_and_friction
from cabledrive.studies.parametric_growth import nonlinear_largest
from cabledrive.studies.planned_motion import PlannedMotion, course_of

PRINTER = 2
MARGIN = 0.5
"""In the logarithm of the growth, as `cabledrive.studies.alarm.MARGIN`."""


def held(drive, motion):
    """The same motion with pretension and carriage as they are half-way."""
    middle = motion.time.size // 2
    drive = replace(drive, cable=replace(drive.cable, pretension=float(motion.pretension[middle])))
    if motion.carriage is not None:
        carriage = replace(drive.carriage[0], position=float(motion.carriage[middle]))
        drive = replace(drive, carriage=(carriage, *drive.carriage[1:]))
    return drive, PlannedMotion(time=motion.time, torque=motion.torque)


def compared(machines, count, seed, most_of_printer=0):
    """Per motion: drive, what the alarm says, and the largest motion by the loop and by the oscillators."""
    rng, printed = np.random.default_rng(seed), 0
    for turn in range(count):
        machine = without_weight_and_friction(machines[turn % len(machines)])
        drive, motion = held(machine, random_motion(machine, rng))
        if turn % len(machines) == PRINTER:
            printed += 1
            if printed > most_of_printer:
                continue
        result = alarm(drive, motion, floor=FLOOR, limit=LIMIT)
        if result.slack:
            continue
        worst = result.modes[0]
        starts = sorted({0.0, 0.5 * worst.start, worst.start, 0.5 * float(motion.time[-1])})
        exact, slack = exact_largest(drive, motion, worst.number, starts, FLOOR)
        course = course_of(drive, motion, worst.number)
        reduced = [
            max(nonlinear_largest(course, mode, int(start / course.h), FLOOR)[mode] for start in starts)
            for mode in range(exact.size)
        ]
        yield drive.name, result, float(exact.max()), float(max(reduced)), slack


def of_one_drive(rows):
    """Motions, alarms, how many pass the limit; ln(gain) of safe and of others; loop over oscillators."""
    safe, other = ([row[1].modes[0].gain for row in rows if (row[2] > LIMIT) == beyond] for beyond in (0, 1))
    raised = sum(row[1].verdict == ALARM for row in rows)
    gains = ", ".join(f"{min(some):.1f} to {max(some):.1f}" if some else "-" for some in (safe, other))
    over = [row[2] / row[3] for row in rows if not row[4]] or [np.nan]
    return (
        f"{len(rows)} motions, {raised} alarms, {len(other)} beyond; ln(gain) {gains}; "
        f"loop over oscillators {min(over):.2f} to {max(over):.2f}"
    )


def check(rows, measured):
    """No miss; false alarms only inside the margin; oscillators and loop within the margin of each other."""
    table = "\n".join(
        f"{name}: {result.verdict}, gain {result.modes[0].gain:.2f}, alarm {result.modes[0].largest:.3e}, "
        f"loop {exact:.3e}, oscillators {reduced:.3e}{', slack' if slack else ''}"
        for name, result, exact, reduced, slack in rows
    )
    misses = [row for row in rows if row[2] > LIMIT and row[1].verdict != ALARM]
    false = [row for row in rows if row[2] <= LIMIT * np.exp(-MARGIN) and row[1].verdict == ALARM]
    worst = max(abs(np.log(row[3] / row[2])) for row in rows if not row[4])
    for name in sorted({row[0] for row in rows}):
        measured(f"{name}: {of_one_drive([row for row in rows if row[0] == name])}")
    measured(f"{len(rows)} motions: {len(misses)} missed, {len(false)} false, worst {worst:.2f} in ln")
    assert not misses, table
    assert not false, table
    assert worst < MARGIN, f"{worst:.3f}\n{table}"


def test_alarm_agrees_with_the_exact_loop_on_a_few_motions(measured):
    rows = list(compared(drives()[:1], 2, 3))
    assert any(row[2] < LIMIT for row in rows)
    check(rows, measured)


@pytest.mark.verify
def test_alarm_on_the_exact_loop_for_all_motions_that_it_can_follow(measured):
    """All of 50 motions on dissertation-2 and the transporter, the first six of the printer."""
    rows = list(compared(drives(), 50, 0, 6))
    check(rows, measured)
    assert len(rows) >= 35
    assert sum(row[2] > LIMIT for row in rows) >= 10


def test_motions_that_the_loop_cannot_follow_are_refused():
    drive = drives()[0]
    motion = random_motion(drive, np.random.default_rng(0))
    with pytest.raises(cd.InputRefused, match="stand still"):
        exact_largest(drive, motion, 1, [0.0], FLOOR)
