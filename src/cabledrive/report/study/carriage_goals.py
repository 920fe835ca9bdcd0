"""What was asked of a carriage, and how its verdict is found."""

from cabledrive.report.blocks import Cell, Column, RowGroup, Table
from cabledrive.report.numbers import number, quantity
from cabledrive.studies.study import Goals

CARRIAGE_METHODS = ("No theorem bounds the error of the scheduled law: the figures are results of the runs.",)


def asked_of_carriage(goals: Goals) -> Table:
    """The goals of a study with a carriage."""
    error, hung = goals.carriage_error, goals.hanging_mass
    assert goals.travel is not None
    rows: list[tuple[Cell, ...]] = [
        ("Error of the carriage", quantity(error, "m", 3) if error else "none given"),
        (
            "Each move",
            f"{quantity(goals.travel, 'm', 4)} in {goals.duration:g} s, {goals.dwell:g} s rest, and back",
        ),
        ("Pulses", f"{goals.pulses}, rises of order {goals.order}"),
        ("Largest torque", quantity(goals.torque, "N m", 3) if goals.torque else "the motor's limit"),
        ("Below the carriage", _hung(goals) if hung else "no hanging mass"),
        ("Load pulley", _load(goals)),
        ("Test", f"{goals.carriage_draws} plants with a carriage, seed {goals.seed}"),
    ]
    return Table(
        caption="Goals.",
        columns=(Column(title="Goal"), Column(title="Value")),
        groups=(RowGroup(rows=tuple(rows)),),
    )


def _hung(goals: Goals) -> str:
    assert goals.hanging_mass is not None
    assert goals.line_length is not None
    return f"{quantity(goals.hanging_mass, 'kg', 4)} on a line of {quantity(goals.line_length, 'm', 4)}"


def _load(goals: Goals) -> str:
    if goals.load_inertia is None:
        return "as in the file"
    low, high = goals.load_inertia
    return f"{number(low, 4)} to {number(high, 4)} kg m²"
