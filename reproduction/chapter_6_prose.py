"""Bounds, bandwidths and gains in the prose of sections 6.3 to 6.7."""

from math import pi

import numpy as np

from cabledrive.rig.bench.virtual_rig import BENCH_TESTS
from reproduction.item import DIFFERS, ERRATUM, Item, Outcome, outcome, place
from reproduction.judge import claimed, erratum, unknown
from reproduction.rig_runs import run


def prose(quick: bool) -> Outcome:
    """Bounds and gains of the prose of sections 6.5.1, 6.6.1 and 6.7.2.

    ``quick``: changes nothing here.
    """
    table = BENCH_TESTS[1]
    truth = {"p2": table.inertia, "p3": table.viscous, "p4": table.coulomb, "p5": table.offset}
    common = (("p3", 0.0029, 0.0033), ("p4", 0.035, 0.04), ("p5", -0.01, 0.01))
    rows = {"6-5-1": (("p2", 0.00165, 0.00185), *common), "6-6-1": common}
    items: list[Item] = []
    for section, bounds in rows.items():
        for name, low, high in bounds:
            nominal = truth[name]
            items.append(
                claimed(
                    f"section-{section}-{name}",
                    f"Section {section.replace('-', '.')}: bounds of {name}",
                    f"{low:g} to {high:g}",
                    f"{nominal:g} by Table 4.1 lies inside"
                    if low <= nominal <= high
                    else f"{nominal:g} lies outside",
                    low <= nominal <= high,
                    otherwise=(DIFFERS, "not explained"),
                    note="a choice of the print; what can be checked is that it holds Table 4.1",
                    tested=False,
                )
            )
    items.append(
        erratum(
            "section-6-6-1-p2",
            "Section 6.6.1: lower bound of p2",
            0.009,
            0.0009,
            "kg m^2",
            f"above its upper bound 0.0013. {place('erratum-6-6-1-bounds')}",
        )
    )
    for section, what, value, law in (
        ("6-4-1", "lambda/(2 pi)", 22.0, "darc-2"),
        ("6-5-1", "lambda/(2 pi)", 11.0, "darc-3"),
        ("6-6-1", "lambda/(2 pi)", 23.0, "darc-4"),
        ("6-7-2", "closed-loop bandwidth", 10.5, "backstepping"),
    ):
        found = run(law)
        hertz = float(found.summary["gains"]["bandwidth_hz"])
        items.append(
            claimed(
                f"section-{section}-bandwidth",
                f"Section {section.replace('-', '.')}: {what}",
                f"{value:g} Hz",
                f"stable on the rig of Model 4, {hertz:g} Hz; peak error "
                f"{found.summary['peak_error_deg']:.3f} deg",
                found.incomplete is None and abs(hertz / value - 1.0) < 1e-9,
                otherwise=(DIFFERS, "not explained"),
            )
        )
    ratio = 2 * pi * 13.0
    items.append(
        unknown(
            "section-6-5-1-gains",
            "Sections 6.5.1, 6.6.1: K_sigma = 2 pi 13 J1/beta and 2 pi 25 J11 J12/(beta km)",
            f"{ratio:.2f} and {2 * pi * 25:.2f} 1/s, times mu",
            "",
            "inputs: used as they are in the runs of this section",
        )
    )
    items.append(
        erratum(
            "section-6-3-orders",
            "Sections 6.3, 6.4: bounded derivatives of the reference that the laws need",
            "up to fourth for Model 1, sixth for Model 2",
            "second for Model 1, fourth for Model 2",
            "",
            f"what z_eq of each law ends with. {place('erratum-6-39-order')}",
        )
    )
    items.append(
        claimed(
            "section-6-3-condition",
            "(6.22): example of u_s2",
            "satisfies Condition 1",
            f"left side of Condition 1 reaches {_worst_of_6_22():.3f} epsilon",
            _worst_of_6_22() <= 1.0,
            otherwise=(ERRATUM, place("erratum-6-22-example")),
        )
    )
    return outcome(items)


def _worst_of_6_22() -> float:
    """Largest value of the left side of Condition 1 with the printed u_s2, over epsilon."""
    delta = np.geomspace(1e-3, 1e3, 2001)[:, None]
    sliding = np.linspace(0.0, 4.0, 2001) / (1.0 + delta**2) * (1.0 + delta)
    left = sliding * (1.0 + delta) - 0.25 * sliding**2 * (1.0 + delta**2)
    return float(left.max())
