"""Tables 4.1 and 4.2: does the identification return what the virtual rig was given?"""

from cabledrive.identification.wrap_friction import inertias_of_the_rigs
from cabledrive.rig.bench.virtual_rig import BENCH_TESTS
from reproduction.bench_logs import identified
from reproduction.item import DIFFERS, Item, Outcome, outcome, place
from reproduction.judge import claimed, compared, unknown

WIDE = 3.5
"""Standard errors on each side of an estimate inside which a printed value must lie: 99.9 %."""

QUANTITIES = (
    ("inertia", "inertia", "kg m^2"),
    ("viscous_friction", "viscous", "N m s"),
    ("coulomb_friction", "coulomb", "N m"),
    ("offset_torque", "offset", "N m"),
)
PRINTED = {
    "motor": ("0.0011", "0.00216", "0.024", "-0.0057"),
    "motor and drive pulley": ("0.001742", "0.0031", "0.0376", "-0.0006"),
    "motor and load pulley": ("0.00345", "0.005", "0.045", "-0.0008"),
}


def table_4_1(quick: bool) -> Outcome:
    """Table 4.1: twelve estimates.

    ``quick``: changes nothing here.
    """
    items: list[Item] = []
    for rig in BENCH_TESTS:
        found = identified(rig)
        for (name, short, unit), printed in zip(QUANTITIES, PRINTED[rig.name], strict=True):
            estimate = found.parameters[name]
            width = WIDE * estimate.standard_error
            items.append(
                compared(
                    f"table-4-1-{rig.name.replace(' ', '-')}-{short}",
                    f"Table 4.1, {rig.name}: {name.replace('_', ' ')}",
                    printed,
                    estimate.value,
                    unit,
                    tolerance=width,
                    note="99.9 % interval of the estimate; from a virtual log, the measured one is lost",
                    otherwise=(DIFFERS, f"outside its 99.9 % interval of +- {width:.2g}"),
                )
            )
    items.append(
        unknown(
            "table-4-1-other-experiments",
            "Table 4.1: estimates of the experiments with 3 + 4 Hz and 1 + 5 Hz",
            None,
            "",
            f"described, but not printed. {place('erratum-table-4-1-excitations')}",
        )
    )
    growth = (0.005 / 0.00216, 0.045 / 0.024)
    items.append(
        claimed(
            "table-4-1-consistent",
            "Section 4.2.3: friction estimates of the three rigs",
            "fairly consistent, with only a small increase",
            f"b1 grows {growth[0]:.2g} times, c1 {growth[1]:.2g} times",
            False,
            otherwise=("erratum", f"not by the table itself. {place('erratum-table-4-1-consistency')}"),
        )
    )
    return outcome(items)


def table_4_2(quick: bool) -> Outcome:
    """Table 4.2: inertias by differences.

    ``quick``: changes nothing here.
    """
    found = inertias_of_the_rigs(*(identified(rig) for rig in BENCH_TESTS))
    exact = {
        "J1": ("0.001742", 0.001742),
        "J11": ("0.0011", 0.0011),
        "J12": ("0.000642", 0.001742 - 0.0011),
        "J2": ("0.00235", 0.00345 - 0.0011),
    }
    items = []
    for name, (printed, difference_) in exact.items():
        estimate = found[name]
        items.append(
            compared(
                f"table-4-2-{name.lower()}",
                f"Table 4.2: {name}, from the virtual logs",
                printed,
                estimate.value,
                "kg m^2",
                tolerance=WIDE * estimate.standard_error,
                note="99.9 % interval of the estimate",
            )
        )
        items.append(
            compared(
                f"table-4-2-{name.lower()}-arithmetic",
                f"Table 4.2: {name}, difference of Table 4.1",
                printed,
                difference_,
                "kg m^2",
            )
        )
    return outcome(items)
