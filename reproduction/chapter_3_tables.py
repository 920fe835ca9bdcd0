"""Tables 3.1 and 3.2: the rig of chapter 3 and its frequencies."""

from cabledrive.parameters import load_drive
from reproduction.carriage_table import PRINTED, QUANTITIES, table_3_2
from reproduction.item import ERRATUM, Entry, Item, Outcome, outcome, place
from reproduction.judge import claimed, compared, taken

CONFIGURATIONS = {1: ("7.316e-6", "7.316e-6"), 2: ("0.0011", "7.316e-6")}
COMMON = {
    "r1": ("3", 100.0, "cm"),
    "r2": ("3", 100.0, "cm"),
    "E": ("2.6", 1e-9, "GPa"),
    "A": ("4.26e-7", 1.0, "m^2"),
    "rho": ("4.9e-4", 1.0, "kg/m"),
    "L": ("1", 1.0, "m"),
    "T0": ("5", 1.0, "N"),
}
PLACES = {
    "fundamental": "erratum-table-3-2-mixture",
    "second": "erratum-table-3-2-in-phase",
    "transverse": "erratum-3-14-length",
    "rigid": "erratum-table-3-2-rigid-supports",
}


def table_3_1(quick: bool) -> Outcome:
    """Every row of Table 3.1 beside the packaged drives.

    ``quick``: changes nothing here.
    """
    items: list[Item] = []
    for number, (first, second) in CONFIGURATIONS.items():
        drive = load_drive(f"dissertation-{number}")
        where, cable = f"Table 3.1, configuration {number}", drive.cable
        assert cable.youngs_modulus is not None
        assert cable.area is not None
        used = {
            "r1": drive.drive_pulley.radius,
            "r2": drive.load_pulley.radius,
            "E": cable.youngs_modulus,
            "A": cable.area,
            "rho": cable.mass_per_length,
            "L": drive.span_length,
            "T0": cable.pretension,
        }
        head = f"table-3-1-{number}"
        inertias = (drive.drive_pulley.inertia, drive.load_pulley.inertia)
        if number == 1:
            items.append(taken(f"{head}-j1", f"{where}: J1", first, inertias[0], "kg m^2"))
        else:
            pulley = load_drive("dissertation-1").drive_pulley.inertia
            anchor = place("erratum-table-3-1-drive-inertia")
            why = f"0.0011 is the motor's own J11; the pulley adds 0.7 %. {anchor}"
            both = inertias[0] + pulley
            items.append(
                compared(
                    f"{head}-j1",
                    f"{where}: J1, motor and pulley",
                    first,
                    both,
                    "kg m^2",
                    note=why,
                    otherwise=(ERRATUM, why),
                    tested=False,
                )
            )
        items.append(taken(f"{head}-j2", f"{where}: J2", second, inertias[1], "kg m^2"))
        for key, (printed, factor, unit) in COMMON.items():
            items.append(taken(f"{head}-{key.lower()}", f"{where}: {key}", printed, factor * used[key], unit))
    return outcome(items)


def table_3_2_items(quick: bool) -> Outcome:
    """Every number of Table 3.2, by certified modes; where it differs, the conventions that give the print.

    ``quick``: changes nothing here.
    """
    data = table_3_2()
    keys = {words: key for key, words in QUANTITIES.items()}
    items = []
    for row in range(data.sizes["row"]):
        at = data.isel(row=row)
        number, words = int(at["configuration"]), str(at["quantity"].item())
        key, printed = keys[words], PRINTED[number].get(keys[words])
        if printed is None:
            continue
        mixture, why = float(at["mixture"]), str(at["explanation"].item())
        reason = f"{why}; so computed: {mixture:.2f} Hz. {place(PLACES[key])}"
        items.append(
            compared(
                f"table-3-2-{number}-{key}",
                f"Table 3.2, configuration {number}: {words.lower()}",
                printed,
                float(at["computed"]),
                "Hz",
                otherwise=(ERRATUM, reason),
            )
        )
    ratio = float(data["computed"][1] / data["computed"][0])
    items.append(
        claimed(
            "section-3-2-gap",
            "Section 3.2: gap between the first two frequencies",
            "large gap between the first two natural longitudinal frequencies",
            f"second over first in configuration 1: {ratio:.2f}; the second printed is the third",
            ratio > 2.0,
            otherwise=(ERRATUM, "no large gap"),
            note=f"the in-phase mode is the second, the gap is there. {place('erratum-table-3-2-in-phase')}",
        )
    )
    return outcome(items)


ENTRIES = (
    Entry(name="table-3-1", chapter="3", covers=("Table 3.1",), compute=table_3_1),
    Entry(name="table-3-2", chapter="3", covers=("Table 3.2",), compute=table_3_2_items),
)
