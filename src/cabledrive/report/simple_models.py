"""What simpler formulas say of a machine, beside its certified modes."""

from collections.abc import Iterator

from cabledrive.modal.lateral import lateral_mode
from cabledrive.modal.rigid_supports import against_lumped_springs, against_rigid_supports
from cabledrive.parameters import Drive
from cabledrive.report.blocks import Cell, Column, RowGroup, Table
from cabledrive.report.numbers import fixed, number

_FEW = 4


def simple_models_table(drive: Drive) -> Table:
    """Frequencies by closed formulas beside the exact ones, as far as each formula applies."""
    return Table(
        caption="What simpler models make of this machine.",
        columns=(
            Column(title="Model"),
            Column(title="Its frequency", unit="Hz", numeric=True),
            Column(title="Exact", unit="Hz", numeric=True),
            Column(title="Deviation", unit="%", numeric=True),
        ),
        groups=(RowGroup(rows=tuple(_row(*line) for line in _models(drive))),),
    )


def _models(drive: Drive) -> Iterator[tuple[str, float, float]]:
    """Name of the model, its frequency, the certified one [Hz]."""
    along, across = against_rigid_supports(drive)
    if not all(pulley.fixed for pulley in drive.pulley):
        lumped = against_lumped_springs(drive)
        yield "Pulleys on springs without mass, no carriage", lumped.simple, lumped.exact
    yield "Bare span between rigid supports, along (3.14a)", along.simple, along.exact
    yield "Bare span between rigid supports, across (3.14b)", across.simple, across.exact
    for carriage in _alone(drive)[:_FEW]:
        lateral = lateral_mode(drive, carriage)
        name = f"Carriage {carriage} hanging on a cable without mass (3.35)"
        yield name, lateral.approximate, lateral.exact
        yield "The same with a third of the cable’s mass added", lateral.corrected, lateral.exact


def _alone(drive: Drive) -> list[int]:
    """Numbers of the carriages that hang on the cable with no other hanging between the same supports."""
    alone = []
    for span in drive.spans:
        stretch: list[int] = []
        for carriage in (*drive.carriages_on(span), None):
            if carriage is not None and not carriage.guided:
                stretch.append(next(i for i, c in enumerate(drive.carriage) if c is carriage))
            else:
                alone += stretch if len(stretch) == 1 else []
                stretch = []
    return sorted(alone)


def _row(model: str, simple: float, exact: float) -> tuple[Cell, ...]:
    deviation = 100.0 * (simple / exact - 1.0)
    sign = "+" if deviation >= 0.05 else ""
    return model, number(simple), number(exact), sign + fixed(deviation + 0.0, 1).replace("−0.0", "0.0")
