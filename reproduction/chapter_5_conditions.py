"""Figs. 5.2 and 5.3 and the prose of chapter 5: when the drive is in internal resonance."""

import numpy as np

from cabledrive.modal.tuning import span_frequency, tuned_pretension
from cabledrive.parameters import load_drive
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.averaging import averaged_coefficients
from reproduction.frequency_ratio import frequency_ratio, mass_ratios, resonant_load_ratio
from reproduction.item import DIFFERS, ERRATUM, Outcome, outcome, place
from reproduction.judge import claimed, compared, erratum, unknown
from reproduction.motions_of_chapter_5 import (
    tuned_drive,
)
from reproduction.panel import Panel, curve

TENSIONS = (2.0, 3.2838, 5.0, 10.0)
DRIVE_RATIOS = (1.0, 10.0, 1000.0)


def figure_5_2(quick: bool) -> Outcome:
    """Fig. 5.2: frequency ratio over the mass ratios, for some tensions.

    ``quick``: changes nothing here.
    """
    cable = load_drive("dissertation-2").cable
    chi2 = np.geomspace(0.1, 100.0, 120)
    panels, rising, cut = [], True, True
    for tension in TENSIONS:
        strain = tension / cable.axial_rigidity
        rows = np.array([frequency_ratio(chi1, chi2, strain) for chi1 in DRIVE_RATIOS])
        rising = rising and bool(np.all(np.diff(rows, axis=1) > 0) and np.all(np.diff(rows, axis=0) > 0))
        cut = cut and bool(rows.min() < 0.5 < rows.max())
        panels.append(
            Panel(
                figure="Fig. 5.2",
                title=f"Frequency ratio at T0 = {tension:g} N; tensions and ranges chosen",
                x="chi2",
                y="gamma",
                curves=tuple(
                    curve(f"chi1 = {c:g}", chi2, row) for c, row in zip(DRIVE_RATIOS, rows, strict=True)
                ),
                log_x=True,
            )
        )
    item = claimed(
        "figure-5-2",
        "Fig. 5.2: frequency ratio over mass ratios and tension",
        "surfaces for different tensions that the plane gamma = 1/2 cuts",
        f"gamma rises with either mass: {'yes' if rising else 'no'}; all {len(TENSIONS)} surfaces are cut: "
        f"{'yes' if cut else 'no'}",
        rising and cut,
        otherwise=(DIFFERS, "not explained"),
        note=f"with Le in gamma and chi. {place('convention-frequency-ratio')}",
    )
    return outcome([item], panels)


def figure_5_3(quick: bool) -> Outcome:
    """Fig. 5.3: contours of resonance, and configuration 2 on its own.

    ``quick``: changes nothing here.
    """
    drive = load_drive("dissertation-2")
    chi1 = np.geomspace(1.0, 3000.0, 400)
    curves, worst = [], 0.0
    for tension in TENSIONS:
        strain = tension / drive.cable.axial_rigidity
        chi2 = resonant_load_ratio(chi1, strain)
        shown = np.isfinite(chi2) & (chi2 < 100.0)
        back = [
            abs(float(frequency_ratio(a, b, strain)) - 0.5)
            for a, b in zip(chi1[shown], chi2[shown], strict=True)
        ]
        worst = max(worst, *back)
        curves.append(curve(f"T0 = {tension:g} N", chi1[shown], chi2[shown]))
    tuned = tuned_pretension(drive)
    own = mass_ratios(drive)
    on = float(resonant_load_ratio(own[0], tuned / drive.cable.axial_rigidity))
    items = [
        claimed(
            "figure-5-3",
            "Fig. 5.3: contours of the plane gamma = 1/2 with the surfaces of Fig. 5.2",
            "a family of curves, one for each tension",
            f"gamma on {len(TENSIONS)} explicit contours is 1/2 to {worst:.1g}",
            worst < 1e-9,
            otherwise=(DIFFERS, "the contour does not lie on the surface"),
        ),
        claimed(
            "figure-5-3-configuration-2",
            "Fig. 5.3: configuration 2 tuned by its tension alone (Section 5.2)",
            "only the tension was changed to satisfy (5.1); no value is printed",
            f"T0 = {tuned:.5f} N; chi2 of its contour {on:.6g}, of the drive {own[1]:.6g}",
            abs(on / own[1] - 1) < 1e-6,
            otherwise=(DIFFERS, "not explained"),
            note=(
                "the tension is computed; nothing printed to hold it against. "
                f"{place('erratum-5-2-pretension')}"
            ),
        ),
    ]
    panel = Panel(
        figure="Fig. 5.3",
        title="Pulleys in resonance; tensions chosen",
        x="chi1",
        y="chi2",
        curves=tuple(curves),
        log_x=True,
        log_y=True,
    )
    return outcome(items, [panel])


def section_5(quick: bool) -> Outcome:
    """Numbers of the prose of chapter 5.

    ``quick``: changes nothing here.
    """
    drive = tuned_drive(load_drive("dissertation-2"))
    model = autoparametric_model(drive)
    pulley = model.natural / (2 * np.pi)
    ratio = span_frequency(drive) / pulley
    c = averaged_coefficients(model)
    own = 0.75 - float(c.static[0, 0] / c.cubic[0, 0])
    cross = float((0.5 * c.cubic[0, 1] - c.static[0, 1]) / c.cubic[0, 0])
    return outcome(
        [
            compared(
                "section-5-ratio",
                "(5.1): longitudinal over transverse frequency",
                "2",
                1.0 / ratio,
                "",
                tolerance=1e-9,
                note="tuned so by its tension",
                tested=False,
            ),
            compared(
                "section-5-gamma",
                "Sections 5.1, 5.2.2: gamma at resonance",
                "0.5",
                ratio,
                "",
                tolerance=1e-9,
                tested=False,
            ),
            compared(
                "section-5-frequency",
                "Sections 5.2, 5.2.2: frequency of the torque, the longitudinal frequency",
                "81.6",
                pulley,
                "Hz",
                otherwise=(
                    ERRATUM,
                    f"81.55 Hz by the print's mixed conventions. {place('erratum-table-3-2-mixture')}",
                ),
            ),
            erratum(
                "section-5-static",
                "(5.3): static part of the tension, passed over",
                "the part at twice the frequency alone",
                f"own-span stiffening {own:.3f} of its cubic term, not 0.75; {cross:.3f} couples the spans",
                "",
                f"the static part detunes. {place('erratum-5-3-static-tension')}",
            ),
            unknown(
                "section-5-frames",
                "Sections 5.2.2, 5.3: 400 frames per second",
                400.0,
                "1/s",
                "a setting of the experiment; Section 4.1 names 480 as the largest. "
                f"{place('erratum-4-1-camera')}",
            ),
        ]
    )
