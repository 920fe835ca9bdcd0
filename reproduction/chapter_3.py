"""Chapter 3: the rig and its frequencies, determinants, shapes, the measured spectrum, the transporter."""

from dataclasses import replace
from math import sqrt

import numpy as np
from scipy.optimize import brentq

from cabledrive.modal import longitudinal_modes, modes, natural_frequencies
from cabledrive.modal.rigid_supports import rigid_support_longitudinal
from cabledrive.parameters import Carriage, Drive, Layout, load_drive
from cabledrive.parameters.arrays import Array
from cabledrive.simulation import Pluck, Scheme, Start, simulate
from cabledrive.simulation.run import whole
from reproduction.items import Found, Outcome
from reproduction.panel import Panel, panel
from reproduction.printed_matrices import modal_matrix

SHEET = """
## table-3-1 table_3_1: Table 3.1
table-3-1-1-j1  | Table 3.1, configuration 1: J1  | 7.316e-6 | kg m^2 | input
table-3-1-1-j2  | Table 3.1, configuration 1: J2  | 7.316e-6 | kg m^2 | input
table-3-1-1-r1  | Table 3.1, configuration 1: r1  | 3        | cm     | input
table-3-1-1-r2  | Table 3.1, configuration 1: r2  | 3        | cm     | input
table-3-1-1-e   | Table 3.1, configuration 1: E   | 2.6      | GPa    | input
table-3-1-1-a   | Table 3.1, configuration 1: A   | 4.26e-7  | m^2    | input
table-3-1-1-rho | Table 3.1, configuration 1: rho | 4.9e-4   | kg/m   | input
table-3-1-1-l   | Table 3.1, configuration 1: L   | 1        | m      | input
table-3-1-1-t0  | Table 3.1, configuration 1: T0  | 5        | N      | input
table-3-1-2-j1  | Table 3.1, configuration 2: J1, motor and pulley | 0.0011 | kg m^2 | arithmetic
  agrees: 0.0011 is the motor's own J11; the pulley adds 0.7 %. #erratum-table-3-1-drive-inertia
  erratum: 0.0011 is the motor's own J11; the pulley adds 0.7 %. #erratum-table-3-1-drive-inertia
table-3-1-2-j2  | Table 3.1, configuration 2: J2  | 7.316e-6 | kg m^2 | input
table-3-1-2-r1  | Table 3.1, configuration 2: r1  | 3        | cm     | input
table-3-1-2-r2  | Table 3.1, configuration 2: r2  | 3        | cm     | input
table-3-1-2-e   | Table 3.1, configuration 2: E   | 2.6      | GPa    | input
table-3-1-2-a   | Table 3.1, configuration 2: A   | 4.26e-7  | m^2    | input
table-3-1-2-rho | Table 3.1, configuration 2: rho | 4.9e-4   | kg/m   | input
table-3-1-2-l   | Table 3.1, configuration 2: L   | 1        | m      | input
table-3-1-2-t0  | Table 3.1, configuration 2: T0  | 5        | N      | input
## table-3-2 table_3_2: Table 3.2
table-3-2-1-fundamental | Table 3.2, configuration 1: {FUNDAMENTAL} | 116 | Hz
table-3-2-1-second | Table 3.2, configuration 1: {SECOND} | 766 | Hz
  erratum: {MIXED}; {THIRD}; so computed: {mixed_1_second:.2f} Hz. #erratum-table-3-2-in-phase
table-3-2-1-transverse | Table 3.2, configuration 1: {TRANSVERSE} | 50.5 | Hz
  erratum: {UNSTRETCHED}; so computed: {mixed_1_transverse:.2f} Hz. #erratum-3-14-length
table-3-2-1-rigid | Table 3.2, configuration 1: {RIGID} | 751.8 | Hz
  erratum: {NYLON}; so computed: {mixed_1_rigid:.2f} Hz. #erratum-table-3-2-rigid-supports
table-3-2-2-fundamental | Table 3.2, configuration 2: {FUNDAMENTAL} | 81.6 | Hz
  erratum: {MIXED}; so computed: {mixed_2_fundamental:.2f} Hz. #erratum-table-3-2-mixture
table-3-2-2-second | Table 3.2, configuration 2: {SECOND} | 757.5 | Hz
  erratum: {MIXED}; {THIRD}; so computed: {mixed_2_second:.2f} Hz. #erratum-table-3-2-in-phase
table-3-2-2-transverse | Table 3.2, configuration 2: {TRANSVERSE} | 50.5 | Hz
  erratum: {UNSTRETCHED}; so computed: {mixed_2_transverse:.2f} Hz. #erratum-3-14-length
table-3-2-2-rigid | Table 3.2, configuration 2: {RIGID} | 751.8 | Hz
  erratum: {NYLON}; so computed: {mixed_2_rigid:.2f} Hz. #erratum-table-3-2-rigid-supports
section-3-2-gap | Section 3.2: gap between the first two frequencies
  printed: large gap between the first two natural longitudinal frequencies
  computed: second over first in configuration 1: {gap:.2f}; the second printed is the third
  agrees: the in-phase mode is the second, the gap is there. #erratum-table-3-2-in-phase
  erratum: no large gap
## figure-3-1 determinant(1): Fig. 3.1
figure-3-1 | Fig. 3.1: zeros of the determinant of configuration 1
  printed: the zero-crossings indicate the natural frequencies
  computed: a crossing within {worst:.2g} Hz of each of {modes} certified modes below 3 kHz (grid {grid:.2g} Hz)
  agrees: two of the zeros near 750 Hz lie close together: the lower one is the in-phase mode that the print
    passes over. #erratum-table-3-2-in-phase
## figure-3-2 determinant(2): Fig. 3.2
figure-3-2 | Fig. 3.2: zeros of the determinant of configuration 2
  printed: the zero-crossings indicate the natural frequencies
  computed: a crossing within {worst:.2g} Hz of each of {modes} certified modes below 3 kHz (grid {grid:.2g} Hz)
  agrees: two of the zeros near 750 Hz lie close together: the lower one is the in-phase mode that the print
    passes over. #erratum-table-3-2-in-phase
## figures-3-3-to-3-5 shapes: Fig. 3.3, Fig. 3.4, Fig. 3.5
figure-3-3 | Fig. 3.3: fundamental shapes of configuration 1
  printed: consistent with a spring-like behaviour of the two spans
  computed: largest distance from a straight line {bend_1:.2g} % of the stroke
figure-3-5-a | Fig. 3.5(a): out-of-phase mode
  printed: require rotation of the pulleys
  computed: rims move {rim_0:.2g} of the largest displacement, at {hertz_0:.2f} Hz
figure-3-5-b | Fig. 3.5(b): in-phase mode
  printed: do not require it
  computed: rims move {rim_1:.2g} of the largest displacement, at {hertz_1:.2f} Hz
  agrees: it is the second mode, not in Table 3.2. #erratum-table-3-2-in-phase
figure-3-4 | Fig. 3.4: fundamental shapes of configuration 2
  printed: consistent with a spring-like behaviour of the two spans
  computed: largest distance from a straight line {bend_2:.2g} % of the stroke
## figure-3-6 figure_3_6: Fig. 3.6, Section 3.2.2
figure-3-6-peak | Fig. 3.6, Section 3.2.2: peak of the free load pulley's spectrum | 81.6 | Hz
  erratum: the print's theory, 81.55 Hz, mixes two conventions; the measured digits are those of the theory.
    #erratum-table-3-2-mixture
## figures-3-8-to-3-10 transporter: Fig. 3.8, Fig. 3.9, Fig. 3.10
figure-3-8-constant | Fig. 3.8: no mass
  printed: constant, as in Table 3.2
  computed: {least:.4f} to {most:.4f} Hz
figure-3-8-heavier | Fig. 3.8: heavier mass
  printed: the fundamental falls as the mass grows, at any place
  computed: largest change from one mass to the next at any place {rise:.2g} Hz
  agrees: the masses of the print are lost; 0, 1, 5, 10 and 50 times the cable's are chosen
figure-3-8-midspan | Fig. 3.8: mass at the midpoint
  printed: equivalent to no mass
  computed: {heavy:.2f} Hz with 50 times the cable's mass, {bare:.2f} Hz without
  erratum: true below {crossing:.4g} times the cable's mass; above, the mode that carries the mass is lower.
    #erratum-fig-3-8-midpoint
figure-3-9 | Fig. 3.9: fundamental shape with the mass at the midpoint
  printed: a vibration node at the mass
  computed: the mass moves {node:.2g} of the largest displacement
  agrees: a mass of 5 times the cable's is chosen
figure-3-10 | Fig. 3.10: spans of the transporter
  printed: their motion is coupled with pulley rotation
  computed: rims move {rim:.2g} of the largest displacement
"""
FUNDAMENTAL = "fundamental longitudinal frequency"
SECOND = "second longitudinal frequency of the print, the third mode"
TRANSVERSE, RIGID = "fundamental transverse frequency", f"{FUNDAMENTAL} with rigid end-supports"
MIXED = (
    "the print takes c_u = sqrt(EA/rho) of (2.31), without the factor 1 + eps0 under the root, "
    "and divides by the stretched length Le = L (1 + eps0)"
)
THIRD = "it is the third mode, the in-phase one lies below it"
UNSTRETCHED = "the print takes the unstretched length L and leaves the density unstretched"
NYLON = (
    "the printed parameters give 751.73 Hz; 751.8 Hz follows from nylon's density before rounding, "
    "c_u = sqrt(E / 1150 kg/m^3)"
)
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
    found = {}
    pulley = load_drive("dissertation-1").drive_pulley.inertia
    for number, added in ((1, 0.0), (2, pulley)):
        drive = load_drive(f"dissertation-{number}")
        values = {"j1": drive.drive_pulley.inertia + added, "j2": drive.load_pulley.inertia}
        values |= printed_data(drive)
        found |= {f"table_3_1_{number}_{key}": value for key, value in values.items()}
    return found, []


def table_3_2(quick: bool) -> Outcome:
    """Certified modes, and those of the print's mixed conventions.

    Mixed are the wave speed of the unstretched cable and the stretched length; L where the print has c/(2 L).
    """
    found: Found = {}
    for number in (1, 2):
        drive = load_drive(f"dissertation-{number}")
        cable, twice = drive.cable, 2.0 * drive.span_length
        stretched = replace(drive, layout=Layout(span_length=drive.pulley_distance))
        right = *natural_frequencies(drive, count=3), modes(drive, count=1).transverse[0].frequency
        mixed = *natural_frequencies(stretched, count=3), sqrt(cable.pretension / cable.mass_per_length) / twice
        rigid = rigid_support_longitudinal(drive), sqrt(cable.axial_rigidity / cable.mass_per_length) / twice
        names = ("fundamental", "in_phase", "second", "transverse", "rigid")
        found |= dict(zip((f"table_3_2_{number}_{name}" for name in names), (*right, rigid[0]), strict=True))
        found |= dict(zip((f"mixed_{number}_{name}" for name in names), (*mixed, rigid[1]), strict=True))
    gap = found["table_3_2_1_in_phase"] / found["table_3_2_1_fundamental"]
    return found | {"gap": gap, "section_3_2_gap": gap > 2.0}, []


def determinant(number: str, quick: bool) -> Outcome:
    """Determinant of (3.13): its zero-crossings are the natural frequencies, those and no other."""
    drive = load_drive(f"dissertation-{number}")
    certified = natural_frequencies(drive, below=RANGES["whole"][1])
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
    for mode in longitudinal_modes(drive, count=count)[:count]:
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
        both = mode_shapes(load_drive(f"dissertation-{number}"), 2)
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
    drive = load_drive("dissertation-2")
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
    """A drive with a guided mass on its upper span, in units of the cable's mass 2 Le rho; at a rim it turns."""
    mass = ratio * len(drive.spans) * drive.span_length * drive.cable.mass_per_length
    if position in (0.0, drive.span_length):
        end = int(position > 0.0)
        pulleys = list(drive.pulley)
        loaded = pulleys[end].inertia + mass * pulleys[end].radius ** 2
        pulleys[end] = replace(pulleys[end], inertia=loaded)
        return replace(drive, pulley=(pulleys[0], pulleys[1]))
    return replace(drive, carriage=(Carriage(mass=mass, position=position),)) if mass else drive


def midspan_crossing(drive: Drive) -> float:
    """Mass at midspan of a symmetric loop, over the cable's, above which its mode is the fundamental.

    In a symmetric loop the out-of-phase modes have a node at midspan, and a mass there does not change them.
    The in-phase mode carries the mass and falls with it. The crossing is found numerically; it lies at
    m = 2 J/r^2, which is 16.59 times the cable's mass for configuration 1.
    """
    fundamental = natural_frequencies(drive, count=1)[0]

    def above(ratio: float) -> float:
        """How far the mode that carries the mass is above the other, which is the fundamental itself."""
        pair = natural_frequencies(with_carriage(drive, ratio, drive.span_length / 2), count=2)
        return float(pair[:2].sum() - 2.0 * fundamental)

    return float(brentq(above, 0.0, 64.0, xtol=1e-12, rtol=1e-12))


def transporter(quick: bool) -> Outcome:
    """Figs. 3.8 to 3.10: the fundamental over the place of a mass, and its shape with the mass at midspan."""
    drive = load_drive("dissertation-1")
    places = np.linspace(0.0, drive.span_length, 21 if quick else 81)
    hertz = np.array(
        [[natural_frequencies(with_carriage(drive, m, x), count=1)[0] for x in places] for m in MASS_RATIOS]
    )
    packaged = load_drive("dissertation-transporter")
    middle = replace(packaged.carriage[0], position=packaged.span_length / 2)
    shape = mode_shapes(replace(packaged, carriage=(middle,)))[0]
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
    curves = [(f"chi_m = {m:g}", places / drive.span_length, row) for m, row in zip(MASS_RATIOS, hertz, strict=True)]
    title = "Fundamental over the place of the mass; masses chosen"
    drawn = panel("Fig. 3.8", title, "place over span length | frequency [Hz]", *curves)
    return found | judged, [drawn, *(_shape_panel(f"Fig. 3.{n}", *shape) for n in (9, 10))]
