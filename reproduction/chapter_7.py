"""The conclusions of chapter 7: each statement that a computation can judge."""

from dataclasses import replace

import numpy as np

from cabledrive.modal import against_rigid_supports, modes, natural_frequencies
from cabledrive.parameters import load_drive
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.lumped_chain import lumped_model, natural_frequencies_of
from cabledrive.reduction.quality import with_measured_stiffness
from cabledrive.reduction.threshold import threshold_torque
from reproduction.item import DIFFERS, UNEXPLAINED, Entry, Item, Outcome, outcome
from reproduction.judge import claimed, unknown
from reproduction.motions_of_chapter_5 import tuned_drive
from reproduction.rig_runs import MOTION, dwell_spectrum, held_frequency, peak_of, run
from reproduction.table_6_3 import drive_3

DRASTIC = 3.0
"""Factor from which a frequency counts as drastically reduced."""

BANDWIDTHS = (23.0, 30.0, 40.0, 60.0, 80.0)
"""Tried one after the other [Hz]."""

OTHERWISE = (DIFFERS, UNEXPLAINED)


def conclusions(quick: bool) -> Outcome:
    """Statements of Section 7.1.

    ``quick``: changes nothing here.
    """
    items = [_reduction(), _avoided(), _spring_damper(), _dominant(), _bandwidth(), _ignored()]
    items.append(
        unknown(
            "section-7-1-accuracy",
            "Section 7.1: accuracy under parametric uncertainty and neglected modes",
            "good tracking accuracy",
            "",
            "neither number nor motion is printed; the accuracies of Sections 6.5 to 6.7 are other items",
        )
    )
    return outcome(items)


def _reduction() -> Item:
    factors = [against_rigid_supports(load_drive(f"dissertation-{n}"))[0] for n in (1, 2)]
    found = [one.simple / one.exact for one in factors]
    return claimed(
        "section-7-1-reduction",
        "Section 7.1: cable and pulleys of high inertia",
        "a drastic reduction in the fundamental longitudinal frequency",
        f"{found[0]:.1f} and {found[1]:.1f} times below rigid supports (configurations 1 and 2)",
        min(found) > DRASTIC,
        otherwise=OTHERWISE,
        note=f"drastic is taken as a factor above {DRASTIC:g}",
    )


def _avoided() -> Item:
    tuned = tuned_drive(load_drive("dissertation-2"))
    own = replace(tuned, cable=replace(tuned.cable, pretension=load_drive("dissertation-2").cable.pretension))
    at, away = (float(threshold_torque(autoparametric_model(drive))) for drive in (tuned, own))
    return claimed(
        "section-7-1-avoided",
        "Section 7.1: choice of mass ratios and tension",
        "can help avoid 1:2 internal resonance",
        f"configuration 2: threshold torque {1e3 * at:.3g} mN m tuned, at {tuned.cable.pretension:.3f} N, "
        f"{1e3 * away:.3g} mN m at {own.cable.pretension:g} N",
        away > 2.0 * at,
        otherwise=OTHERWISE,
        note="dampings as chosen for Figs. 5.4 to 5.7",
    )


def _spring_damper() -> Item:
    drive = drive_3()
    lumped = natural_frequencies_of(lumped_model(drive, 4)) / (2 * np.pi)
    exact = natural_frequencies(with_measured_stiffness(drive), count=lumped.size)
    worst = float(np.max(np.abs(lumped / exact - 1.0)))
    return claimed(
        "section-7-1-springs",
        "Section 7.1: frequency response of the system",
        "the cables behave like axial spring-dampers",
        f"frequencies of Model 4 within {100 * worst:.2g} % of the distributed cable's",
        worst < 0.05,
        otherwise=OTHERWISE,
        note="configuration 3, both with the measured stiffness",
    )


def _dominant() -> Item:
    first, second = modes(with_measured_stiffness(drive_3()), count=2).longitudinal[:2]
    words = f"{first.frequency:.2f} Hz {first.family}; {second.frequency:.1f} Hz {second.family}"
    return claimed(
        "section-7-1-dominant",
        "Section 7.1: origin of the modes of configuration 3",
        "the dominant mode is the cable's, a higher-order mode that of the motor joint",
        words,
        first.family == "pulleys out of phase" and second.family == "motor joint",
        otherwise=OTHERWISE,
    )


def _bandwidth() -> Item:
    flexible, rigid = (_highest(law) for law in ("darc-4", "darc-3"))
    return claimed(
        "section-7-1-bandwidth",
        "Section 7.1: motor joint in the model of the law",
        "a higher closed-loop bandwidth is achieved when the joint's flexibility is modeled",
        f"of {', '.join(f'{hertz:g}' for hertz in BANDWIDTHS)} Hz the law of Model 4 completes the run up to "
        f"{flexible:g} Hz, that of Model 3 up to {rigid:g} Hz",
        flexible > rigid,
        otherwise=OTHERWISE,
        note=f"the printed 23 and 11 Hz are not these limits; {MOTION}",
    )


def _highest(law: str) -> float:
    """Highest bandwidth up to which all runs of a law end as planned [Hz]; 0 where the first does not."""
    reached = 0.0
    for hertz in BANDWIDTHS:
        if run(law, hertz).incomplete is not None:
            break
        reached = hertz
    return reached


def _ignored() -> Item:
    found = run("darc-1", 5.0, "drive")
    hertz, size = peak_of(dwell_spectrum(found, -1))
    return claimed(
        "section-7-1-ignored",
        "Section 7.1: cable left out of the law",
        "vibrations are seen in the load pulley at the dominant frequency",
        f"{size:.2g} deg at {hertz:.2f} Hz in the dwell; cable's mode with the drive pulley held: "
        f"{held_frequency():.2f} Hz",
        abs(hertz / held_frequency() - 1.0) < 0.05,
        otherwise=OTHERWISE,
        note=MOTION,
    )


ENTRIES = (Entry(name="section-7-1", chapter="7", covers=("Section 7.1",), compute=conclusions),)
