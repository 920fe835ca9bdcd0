"""What was asked of a carriage, and how its verdict is found."""

from cabledrive.report.blocks import Cell, Table
from cabledrive.report.numbers import quantity
from cabledrive.report.study.goals_table import goals_table, load_range
from cabledrive.report.wording import texts
from cabledrive.studies.study import Goals

say = texts("study_carriage_goals")


def carriage_method() -> str:
    """How the verdict of a carriage is found, for the provenance."""
    return say("method")


def asked_of_carriage(goals: Goals) -> Table:
    """The goals of a study with a carriage."""
    error, hung = goals.carriage_error, goals.hanging_mass
    assert goals.travel is not None
    rows: list[tuple[Cell, ...]] = [
        ("Error of the carriage", quantity(error, "m", 3) if error else "none given"),
        ("Each move", say("move", goals=goals)),
        ("Pulses", f"{goals.pulses}, rises of order {goals.order}"),
        ("Largest torque", quantity(goals.torque, "N m", 3) if goals.torque else "the motor's limit"),
        ("Below the carriage", say("hung", goals=goals) if hung else "no hanging mass"),
        ("Load pulley", load_range(goals, "as in the file")),
        ("Test", say("test", goals=goals)),
    ]
    return goals_table(rows)
