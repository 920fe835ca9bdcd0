"""Chapter 5: when the drive is in internal resonance, and its forced, swept and free motion there."""

from dataclasses import replace

import numpy as np

from cabledrive.modal.tuning import span_frequency, tuned_pretension
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.averaging import averaged_coefficients
from cabledrive.reduction.threshold import pulley_amplitude
from reproduction.drives import packaged
from reproduction.forced_motion import ForcedCase, SeenMotion, envelope, exact_motion
from reproduction.frequency_ratio import frequency_ratio, mass_ratios, resonant_load_ratio
from reproduction.items import Found, Outcome
from reproduction.panel import Panel, panel
from reproduction.tension_sweep import Sweep, onset, onset_by_growth_integral, swept_amplitude

TENSIONS = (2.0, 3.2838, 5.0, 10.0)  # N
DRIVE_RATIOS = (1.0, 10.0, 1000.0)
GAMMA, PULLEY_DAMPING, TORQUE = 1.0, 4.0, 0.02  # 1/s, 1/s, N m: estimates, none is printed
CHOSEN = "chosen, the print's are lost: dampings 1 1/s across, 4 1/s of the pulley mode, 20 mN m, plucks"


def surfaces(quick: bool) -> Outcome:
    """Fig. 5.2: frequency ratio over the mass ratios, for some tensions."""
    rigidity = packaged("dissertation-2").cable.axial_rigidity
    chi2 = np.geomspace(0.1, 100.0, 120)
    panels, rising, cut = [], True, True
    for tension in TENSIONS:
        rows = np.array([frequency_ratio(chi1, chi2, tension / rigidity) for chi1 in DRIVE_RATIOS])
        rising = rising and bool(np.all(np.diff(rows, axis=1) > 0) and np.all(np.diff(rows, axis=0) > 0))
        cut = cut and bool(rows.min() < 0.5 < rows.max())
        title = f"Frequency ratio at T0 = {tension:g} N; tensions and ranges chosen"
        curves = ((f"chi1 = {c:g}", chi2, row) for c, row in zip(DRIVE_RATIOS, rows, strict=True))
        panels.append(panel("Fig. 5.2", title, "chi2 | gamma", *curves, log="x"))
    found = {"rising": "yes" if rising else "no", "cut": "yes" if cut else "no"}
    return found | {"figure_5_2": rising and cut}, panels


def contours(quick: bool) -> Outcome:
    """Fig. 5.3: contours of resonance, and configuration 2 on its own."""
    drive = packaged("dissertation-2")
    chi1 = np.geomspace(1.0, 3000.0, 400)
    curves, worst = [], 0.0
    for tension in TENSIONS:
        strain = tension / drive.cable.axial_rigidity
        chi2 = resonant_load_ratio(chi1, strain)
        shown = np.isfinite(chi2) & (chi2 < 100.0)
        back = frequency_ratio(chi1[shown], chi2[shown], strain)
        worst = max(worst, float(np.max(np.abs(back - 0.5))))
        curves.append((f"T0 = {tension:g} N", chi1[shown], chi2[shown]))
    tuned, own = tuned_pretension(drive), mass_ratios(drive)
    on = float(resonant_load_ratio(own[0], tuned / drive.cable.axial_rigidity))
    found = {"worst": worst, "tuned": tuned, "on": on, "own": own[1], "figure_5_3": worst < 1e-9}
    found["figure_5_3_configuration_2"] = abs(on / own[1] - 1) < 1e-6
    drawn = panel("Fig. 5.3", "Pulleys in resonance; tensions chosen", "chi1 | chi2", *curves, log="xy")
    return found, [drawn]


def tuned_drive() -> Drive:
    """Configuration 2 at its tuned pretension, without weight, with the dampings of the figures."""
    drive = packaged("dissertation-2")
    cable = replace(drive.cable, pretension=tuned_pretension(drive), transverse_damping=GAMMA)
    still = replace(drive, cable=cable, layout=replace(drive.layout, gravity=0.0))
    model = autoparametric_model(still)
    load = drive.load_pulley
    friction = PULLEY_DAMPING * model.modal_mass * (load.radius / model.rims[1]) ** 2
    return replace(still, pulley=(drive.drive_pulley, replace(load, viscous_friction=friction)))


def section_5(quick: bool) -> Outcome:
    """Numbers of the prose of chapter 5."""
    drive = tuned_drive()
    model = autoparametric_model(drive)
    pulley, c = model.natural / (2 * np.pi), averaged_coefficients(model)
    ratio = span_frequency(drive) / pulley
    found = {"section_5_ratio": (1.0 / ratio, 1e-9), "section_5_gamma": (ratio, 1e-9)}
    own = 0.75 - float(c.static[0, 0] / c.cubic[0, 0])
    cross = float((0.5 * c.cubic[0, 1] - c.static[0, 1]) / c.cubic[0, 0])
    return found | {"section_5_frequency": pulley, "own": own, "cross": cross}, []


def _motion(drive: Drive, torque: float, plucks: tuple[float, float], **more: object) -> SeenMotion:
    case = ForcedCase(drive=drive, torque=torque, plucks=plucks, **more)  # type: ignore[arg-type]
    return exact_motion(case, segments=100, rate=3000.0)


def _panels(figure: str, run: SeenMotion, load: tuple[str, Array], middle: str) -> tuple[Panel, Panel]:
    return (
        panel(figure, load[0], "time [s] | load angle [deg]", ("load pulley", run.time, np.degrees(load[1]))),
        panel(figure, middle, "time [s] | w [mm]", ("midpoint", run.time, 1e3 * run.midpoint)),
    )


def forced(quick: bool) -> Outcome:
    """Figs. 5.4 and 5.6: torque at the pulley mode's frequency and plucks, by the exact loop."""
    drive = tuned_drive()
    window = 4 * np.pi / autoparametric_model(drive).natural
    strong = _motion(drive, TORQUE, (2e-3, 1e-3), duration=2.0, shape="triangle")
    small = _motion(drive, TORQUE, (3e-4, 1e-4), duration=4.0)
    load, across = (envelope(strong.time, one, window) for one in (strong.load_angle, strong.midpoint))
    peak = int(np.argmax(load))
    left = float(np.min(load[peak:]) / load[peak])
    grown = [envelope(small.time, signal, window) for signal in (small.load_angle, small.midpoint)]
    later = [float(one.max() / one[1]) for one in grown]
    found: Found = {"left": 100 * left, "low": across.min() * 1e3, "high": across.max() * 1e3}
    found |= {"load": later[0], "middle": later[1], "figure_5_4": left < 0.5, "figure_5_6": min(later) > 2.0}
    panels: list[Panel] = []
    for figure, run in (("Fig. 5.4", strong), ("Fig. 5.6", small)):
        level = run.load_angle - np.polyval(np.polyfit(run.time, run.load_angle, 1), run.time)
        named = f"load pulley, trend removed; {CHOSEN}", level
        panels += _panels(figure, run, named, f"midpoint of the upper span; {CHOSEN}")
    return found, panels


def swept(quick: bool) -> Outcome:
    """Fig. 5.5: midpoint while the tension rises slowly through the tuning and the torque goes on."""
    c = averaged_coefficients(autoparametric_model(tuned_drive()), torque=TORQUE, drift=False)
    pumping, nu = float(abs(c.pump[0]) * pulley_amplitude(c)), 0.5 * float(c.forcing)
    sweep = Sweep(pumping=pumping, damping=GAMMA, rate=1.0, floor=1e-5, level=1e-3, half_forcing=nu)
    detuning, amplitude = swept_amplitude(sweep)
    begins = (sweep.entry, onset_by_growth_integral(sweep), onset(detuning, amplitude, sweep.level))
    edge, predicted, there = (float(_ratio(delta, nu)) for delta in begins)
    title = "Amplitude over the frequency ratio, Hill's equation"
    curve = ("midpoint", _ratio(detuning, nu), 1e3 * amplitude)
    found = {"edge": edge, "predicted": predicted, "there": there, "figure_5_5": abs(there - 0.5) < 0.02}
    return found, [panel("Fig. 5.5", title, "gamma | amplitude [mm]", curve, log="y")]


def _ratio(detuning: float | Array, nu: float) -> Array:
    """Frequency ratio gamma at a detuning [rad/s]."""
    return np.asarray(np.sqrt(nu**2 + 2 * nu * np.asarray(detuning)) / (2 * nu))


def free(quick: bool) -> Outcome:
    """Fig. 5.7: the free response, one span plucked, both unequally, both equally."""
    drive = tuned_drive()
    load = replace(drive.load_pulley, viscous_friction=0.25 * drive.load_pulley.viscous_friction)
    light = replace(drive, pulley=(drive.drive_pulley, load))
    one = _motion(light, 0.0, (3e-3, 1e-5), duration=1.5)
    both = _motion(drive, 0.0, (3e-3, 1e-3), duration=1.5, shape="triangle")
    equal = _motion(drive, 0.0, (3e-3, 3e-3), duration=0.2)
    window = 4 * np.pi / autoparametric_model(drive).natural
    words, correlation = zip(*(_first_second(run, window) for run in (one, both)), strict=True)
    peaks = envelope(both.time, both.load_angle, window)
    share = float(np.max(np.abs(equal.load_angle)) / np.max(np.abs(both.load_angle)))
    found: Found = {"one_sided": words[0], "two_sided": words[1], "end": both.time[-1], "equal": share}
    found |= {"left": 100 * peaks[-1] / peaks.max(), "figure_5_7": correlation[0] < 0.0}
    found |= {"figure_5_7_dies_out": found["left"] < 100 / 3, "figure_5_7_equal_plucks": share < 1e-6}
    return found, _panels("Fig. 5.7", one, ("load pulley", one.load_angle), "upper midpoint")


def _first_second(run: SeenMotion, window: float) -> tuple[str, float]:
    """When the pulley is largest and the midpoint least, and the correlation of their envelopes."""
    first = slice(1, int(1.0 / window))
    load, across = (envelope(run.time, one, window)[first] for one in (run.load_angle, run.midpoint))
    peak, least = (float(window * (k + 1.5)) for k in (np.argmax(load), np.argmin(across)))
    correlation = float(np.corrcoef(load, across)[0, 1])
    words = f"pulley largest at {peak:.2f} s, upper midpoint least at {least:.2f} s"
    return f"{words}, correlation {correlation:.2f}", correlation
