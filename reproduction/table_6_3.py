"""Table 6.3: estimates and bounds by their definitions."""

from math import pi, sqrt

from cabledrive.parameters import Drive, load_drive
from reproduction.item import DIFFERS, ERRATUM, Item, Outcome, outcome, place
from reproduction.judge import compared, erratum, unknown


def drive_3() -> Drive:
    """Configuration 3."""
    return load_drive("dissertation-3")


def table_6_3(quick: bool) -> Outcome:
    """Table 6.3: estimates and bounds by their definitions.

    ``quick``: changes nothing here.
    """
    drive = drive_3()
    assert drive.motor is not None
    assert drive.lumped is not None
    assert drive.lumped.cable_stiffness is not None
    first, second = drive.motor.inertia + drive.drive_pulley.inertia, drive.load_pulley.inertia
    stiffness = 2 * drive.lumped.cable_stiffness * drive.drive_pulley.radius**2
    beta = stiffness / second
    viscous, coulomb = drive.motor.viscous_friction, drive.motor.coulomb_friction
    values = {
        "beta_n": beta,
        "p1": 1.0,
        "p3": stiffness / first + beta,
        "p4": viscous * beta / first,
        "p5": coulomb * beta / first,
        "p7": 1.0 / first,
    }
    p5 = (ERRATUM, f"c1 beta_n/J1 is ten times the print. {place('erratum-table-6-3-p5')}")
    p7 = (
        ERRATUM,
        f"digits exchanged; its own bounds exclude it. {place('erratum-table-6-3-p7')}",
    )
    rows = (
        ("beta_n", "1157", None, None),
        ("p1", "1", "0.95", "1.05"),
        ("p3", "2718.9", "2637", "2800"),
        ("p4", "2059.8", "1998", "2121"),
        ("p5", "2498.3", "2423", "2573"),
        ("p7", "547", "556", "591"),
    )
    items: list[Item] = []
    for name, printed, low, high in rows:
        otherwise = {"p5": p5, "p7": p7}.get(name, (DIFFERS, "not explained"))
        items.append(
            compared(
                f"table-6-3-{name.replace('_', '-')}",
                f"Table 6.3: {name}",
                printed,
                values[name],
                "",
                tolerance=2e-4 * float(printed),
                note="rounding of its factors",
                otherwise=otherwise,
            )
        )
        for side, bound, sign in (("min", low, -1), ("max", high, 1)):
            if bound is None:
                continue
            share = 0.05 if name == "p1" else 0.03
            items.append(
                compared(
                    f"table-6-3-{name}-{side}",
                    f"Table 6.3: {side} of {name}, the estimate {'+' if sign > 0 else '-'} {100 * share:.0f} "
                    "%",
                    bound,
                    values[name] * (1 + sign * share),
                    "",
                    tolerance=0.999 if name != "p1" else 0.0,
                    note="the share is read off the rows; the print cuts the decimals of its bounds",
                    otherwise=p5 if name == "p5" else (DIFFERS, "not explained"),
                )
            )
    for name in ("p2", "p6"):
        items.append(
            unknown(
                f"table-6-3-{name}",
                f"Table 6.3, Section 6.7.2: {name} and its bounds",
                None,
                "",
                f"announced, not printed. {place('erratum-table-6-3-missing')}",
            )
        )
    ring = sqrt(beta * (1 + second / first)) / (2 * pi)
    items.append(
        erratum(
            "section-6-5-beta",
            "After (6.47): beta from the fundamental natural frequency",
            "measured as the natural frequency",
            f"sqrt(beta) is the anti-resonance, {sqrt(beta) / (2 * pi):.2f} Hz; the natural frequency is "
            f"{ring:.2f} Hz",
            "",
            place("erratum-6-47-beta"),
        )
    )
    return outcome(items)
