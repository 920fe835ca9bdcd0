"""Chapter 3: the rig and its frequencies, determinants, shapes, the measured spectrum, the transporter."""

from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from cabledrive.modal.natural import longitudinal_modes, modes, natural_frequencies
from cabledrive.parameters import Carriage, Drive, Layout
from cabledrive.parameters.arrays import Array
from cabledrive.simulation import Pluck, Scheme, Start, simulate
from cabledrive.simulation.run import whole
from reproduction.drives import packaged
from reproduction.items import Found, Outcome
from reproduction.panel import Panel, panel
from reproduction.printed_matrices import modal_matrix

RANGES = {"whole": (0.0, 3000.0), "zoomed": (0.0, 200.0)}  # Hz; the ranges of the print are lost
DAMPING = 5.0  # Gamma of the spectrum [1/s]: a choice, none is printed
MASS_RATIOS = (0.0, 1.0, 5.0, 10.0, 50.0)


def printed_data(drive: Drive) -> dict[str, float]:
    """What Tables 3.1 and 6.1 print of a drive beside its inertias, in their units."""
    cable = drive.cable
    assert cable.youngs_modulus is not None
    assert cable.area is not None
    return {
        "r1": 100 * drive.drive_pulley.radius,
        "r2": 100 * drive.load_pulley.radius,
        "e": 1e-9 * cable.youngs_modulus,
        "a": cable.area,
        "rho": cable.mass_per_length,
        "l": drive.span_length,
        "t0": cable.pretension,
    }


def table_3_1(quick: bool) -> Outcome:
    """Every row of Table 3.1 beside the packaged drives."""
    found: Found = {}
    pulley = packaged("dissertation-1").drive_pulley.inertia
    for number, added in ((1, 0.0), (2, pulley)):
        drive = packaged(f"dissertation-{number}")
        values = {"j1": drive.drive_pulley.inertia + added, "j2": drive.load_pulley.inertia}
        values |= printed_data(drive)
        found |= {f"table_3_1_{number}_{key}": value for key, value in values.items()}
    return found, []


def rigid_supports(drive: Drive) -> tuple[float, float]:
    """Frequencies of a bare span between rigid supports, along and across [Hz], Eqs. (3.14a), (3.14b)."""
    twice = 2.0 * drive.pulley_distance
    return drive.cable.axial_wave_speed / twice, drive.cable.transverse_wave_speed / twice


def table_3_2(quick: bool) -> Outcome:
    """Certified modes, and those of the print's mixed conventions.

    Mixed are the wave speed of the unstretched cable and the stretched length; L where the print has c/(2 L).
    """
    found: Found = {}
    for number in (1, 2):
        drive = packaged(f"dissertation-{number}")
        cable, across = drive.cable, modes(drive, count=1).transverse[0].frequency
        stretched = replace(drive, layout=Layout(span_length=drive.pulley_distance))
        right = *natural_frequencies(drive, count=3, taut=True), across, rigid_supports(drive)[0]
        forces = np.array([cable.pretension, cable.axial_rigidity])
        fixed = np.sqrt(forces / cable.mass_per_length) / (2.0 * drive.span_length)
        for head, values in (
            ("table_3_2", right),
            ("mixed", (*natural_frequencies(stretched, count=3, taut=True), *fixed)),
        ):
            names = ("fundamental", "in_phase", "second", "transverse", "rigid")
            found |= {f"{head}_{number}_{name}": one for name, one in zip(names, values, strict=True)}
    gap = found["table_3_2_1_in_phase"] / found["table_3_2_1_fundamental"]
    return found | {"gap": gap, "section_3_2_gap": gap > 2.0}, []


def determinant(number: str, quick: bool) -> Outcome:
    """Determinant of (3.13): its zero-crossings are the natural frequencies, those and no other."""
    drive = packaged(f"dissertation-{number}")
    certified = natural_frequencies(drive, below=RANGES["whole"][1], taut=True)
    panels, worst, agree = [], 0.0, True
    for words, (low, high) in RANGES.items():
        x = np.linspace(low, high, 6001)
        y = np.array([np.linalg.det(modal_matrix(drive, 2 * np.pi * f)) for f in x])
        crossing = x[np.flatnonzero(y[:-1] * y[1:] < 0)]
        inside = certified[(certified > low) & (certified < high)]
        worst = max(worst, *(float(np.min(np.abs(crossing - f))) for f in inside))
        agree = agree and crossing.size == inside.size
        title = f"Determinant of the modal matrix, {words}; the print's range is lost; this one is chosen"
        curves = ("determinant", x, y), ("certified modes", inside, 0.0 * inside)
        panels.append(panel(f"Fig. 3.{number}", title, "frequency [Hz] | determinant", *curves))
    grid = RANGES["whole"][1] / 6000
    found = {"worst": worst, "modes": len(certified), "grid": grid}
    return found | {f"figure_3_{number}": worst <= grid and agree}, panels


def mode_shapes(drive: Drive, count: int = 1, points: int = 201) -> list[tuple[float, dict[str, Array]]]:
    """Frequency [Hz] of the lowest simple modes and displacement along each span.

    The largest displacement, the first if there are several, is 1. Displacements count along each span's own
    direction (upper: drive to load, lower: load to drive).
    """
    places, found = np.linspace(0.0, drive.span_length, points), []
    for mode in longitudinal_modes(drive, count=count, taut=True)[:count]:
        spans = {span: mode.shape(span, places)[0] for span in drive.spans}
        every = np.concatenate([*spans.values()])
        size = np.abs(every)
        scale = size.max() * np.sign(every[np.argmax(size >= (1 - 1e-9) * size.max())])
        found.append((float(mode.frequency), {span: shape / scale for span, shape in spans.items()}))
    return found


def shapes(quick: bool) -> Outcome:
    """Figs. 3.3 to 3.5: fundamental shapes are spring-like, and which of the modes turn the pulleys."""
    found: Found = {}
    panels: list[Panel] = []
    for number, figure in ((1, "3.3"), (2, "3.4")):
        both = mode_shapes(packaged(f"dissertation-{number}"), 2)
        line = np.linspace(0.0, 1.0, 201)
        bend = max(
            float(np.max(np.abs(shape - shape[0] - (shape[-1] - shape[0]) * line)) / np.ptp(shape))
            for shape in both[0][1].values()
        )
        found |= {f"bend_{number}": 100 * bend, f"figure_{figure.replace('.', '_')}": bend < 0.05}
        panels.append(_shape_panel(f"Fig. {figure}", *both[0]))
        for mode, (hertz, spans) in enumerate(both if number == 1 else ()):
            rim = float(max(abs(spans["upper"][[0, -1]])) / np.max(np.abs(spans["upper"])))
            found |= {f"rim_{mode}": rim, f"hertz_{mode}": hertz}
            found[f"figure_3_5_{'ab'[mode]}"] = (rim > 1e-6) == (mode == 0)
            panels.append(_shape_panel("Fig. 3.5", hertz, spans))
    return found, panels


def _shape_panel(figure: str, hertz: float, spans: dict[str, Array]) -> Panel:
    curves = [(name, np.linspace(0, 1, shape.size), shape) for name, shape in spans.items()]
    title = f"Normalised shape at {hertz:.2f} Hz"
    return panel(figure, title, "position over span length | displacement", *curves)


def figure_3_6(quick: bool) -> Outcome:
    """Fig. 3.6: spectrum of the load pulley after plucks of both spans, by the exact loop."""
    drive = packaged("dissertation-2")
    cable = replace(drive.cable, transverse_damping=DAMPING)
    drive = replace(drive, cable=cable, layout=replace(drive.layout, gravity=0.0))
    start = Start(plucks=(Pluck(height=2e-3), Pluck(height=1e-3, span="lower")))
    segments, duration = (40, 2.0) if quick else (100, 3.0)
    result = whole(simulate(drive, duration, start=start, scheme=Scheme(segments=segments)))
    angle = result.load_angle - np.polyval(np.polyfit(result.time, result.load_angle, 1), result.time)
    size = 8 * angle.size
    frequency = np.fft.rfftfreq(size, result.time[1])
    shown = frequency < 200.0
    frequency, spectrum = frequency[shown], np.abs(np.fft.rfft(angle * np.hanning(angle.size), size))[shown]
    title = "Spectrum of the load angle; plucks of 2 and 1 mm and Gamma = 5 1/s are chosen"
    curve = ("load pulley", frequency, spectrum / spectrum.max())
    drawn = panel("Fig. 3.6", title, "frequency [Hz] | amplitude, relative", curve)
    return {"figure_3_6_peak": float(frequency[np.argmax(spectrum)])}, [drawn]


def with_carriage(drive: Drive, ratio: float, position: float) -> Drive:
    """A guided mass on the upper span, in units of the cable's mass 2 Le rho; at a rim it turns it."""
    mass = ratio * len(drive.spans) * drive.span_length * drive.cable.mass_per_length
    if position in (0.0, drive.span_length):
        end = int(position > 0.0)
        pulleys, added = list(drive.pulley), mass * drive.pulley[end].radius ** 2
        pulleys[end] = replace(pulleys[end], inertia=pulleys[end].inertia + added)
        return replace(drive, pulley=(pulleys[0], pulleys[1]))
    return replace(drive, carriage=(Carriage(mass=mass, position=position),)) if mass else drive


def midspan_crossing(drive: Drive) -> float:
    """Mass at midspan of a symmetric loop, over the cable's, above which its mode is the fundamental.

    In a symmetric loop the out-of-phase modes have a node at midspan, and a mass there does not change them.
    The in-phase mode carries the mass and falls with it. The crossing is found numerically; it lies at
    m = 2 J/r^2, which is 16.59 times the cable's mass for configuration 1.
    """
    fundamental = natural_frequencies(drive, count=1, taut=True)[0]

    def above(ratio: float) -> float:  # how far the mode that carries the mass is above the other
        pair = natural_frequencies(with_carriage(drive, ratio, drive.span_length / 2), count=2, taut=True)
        return float(pair[:2].sum() - 2.0 * fundamental)

    return float(brentq(above, 0.0, 64.0, xtol=1e-12, rtol=1e-12))


def transporter(quick: bool) -> Outcome:
    """Figs. 3.8 to 3.10: the fundamental over the place of a mass, and its shape with the mass at midspan."""
    drive = packaged("dissertation-1")
    places = np.linspace(0.0, drive.span_length, 21 if quick else 81)
    hertz = np.array(
        [
            [natural_frequencies(with_carriage(drive, m, x), count=1, taut=True)[0] for x in places]
            for m in MASS_RATIOS
        ]
    )
    own = packaged("dissertation-transporter")
    middle = replace(own.carriage[0], position=own.span_length / 2)
    shape = mode_shapes(replace(own, carriage=(middle,)))[0]
    upper, rise = shape[1]["upper"], np.max(np.diff(hertz, axis=0))
    heavy, bare = hertz[-1, places.size // 2], hertz[0, places.size // 2]
    found = {"least": hertz[0].min(), "most": hertz[0].max(), "rise": rise, "heavy": heavy, "bare": bare}
    found |= {"crossing": midspan_crossing(drive), "node": abs(upper[upper.size // 2]), "rim": abs(upper[0])}
    judged = {
        "figure_3_8_constant": np.ptp(hertz[0]) < 1e-6,
        "figure_3_8_heavier": rise < 1e-6,
        "figure_3_8_midspan": abs(heavy / bare - 1) < 1e-6,
        "figure_3_9": found["node"] < 1e-6,
        "figure_3_10": found["rim"] > 0.5,
    }
    curves = [
        (f"chi_m = {m:g}", places / drive.span_length, row) for m, row in zip(MASS_RATIOS, hertz, strict=True)
    ]
    title = "Fundamental over the place of the mass; masses chosen"
    drawn = panel("Fig. 3.8", title, "place over span length | frequency [Hz]", *curves)
    return found | judged, [drawn, *(_shape_panel(f"Fig. 3.{n}", *shape) for n in (9, 10))]
