"""The conclusions of chapter 7: each statement that a computation can judge."""

from dataclasses import replace
from itertools import takewhile
from math import pi

import numpy as np

from cabledrive.modal import modes, natural_frequencies
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.lumped_chain import lumped_model, natural_frequencies_of
from cabledrive.reduction.quality import distributed
from cabledrive.reduction.threshold import threshold_torque
from reproduction.chapter_3 import rigid_supports
from reproduction.chapter_5 import tuned_drive
from reproduction.drives import packaged
from reproduction.items import Found, Outcome
from reproduction.rig import MOTION, dwell_spectrum, held_frequency, peak_of, run

BANDWIDTHS = (23.0, 30.0, 40.0, 60.0, 80.0)  # tried one after the other [Hz]


def conclusions(quick: bool) -> Outcome:
    """Statements of Section 7.1."""
    drives = [packaged(f"dissertation-{n}") for n in (1, 2)]
    lower = [rigid_supports(own)[0] / modes(own, count=1).longitudinal[0].frequency for own in drives]
    tuned = tuned_drive()
    own = replace(tuned, cable=replace(tuned.cable, pretension=packaged("dissertation-2").cable.pretension))
    at, away = (1e3 * float(threshold_torque(autoparametric_model(drive))) for drive in (tuned, own))
    measured = distributed(packaged("dissertation-3"))
    lumped = natural_frequencies_of(lumped_model(packaged("dissertation-3"), 4)) / (2 * pi)
    off = float(np.max(np.abs(lumped / natural_frequencies(measured, count=lumped.size, taut=True) - 1.0)))
    first, second = modes(measured, count=2).longitudinal[:2]
    flexible, rigid = (highest(law) for law in ("darc-4", "darc-3"))
    hertz, size = peak_of(dwell_spectrum(run("darc-1", 5.0, "drive"), -1))
    found: Found = {"lower": lower, "at": at, "away": away, "tuned": tuned.cable.pretension, "off": 100 * off}
    found |= {"first": first, "second": second, "flexible": flexible, "rigid": rigid}
    found |= {"hertz": hertz, "size": size, "held": held_frequency(), "MOTION": MOTION}
    judged = {
        "reduction": min(lower) > 3.0,
        "avoided": away > 2.0 * at,
        "springs": off < 0.05,
        "dominant": first.family == "pulleys out of phase" and second.family == "motor joint",
        "bandwidth": flexible > rigid,
        "ignored": abs(hertz / held_frequency() - 1.0) < 0.05,
    }
    found |= {f"section_7_1_{key}": value for key, value in judged.items()}
    return found, []


def highest(law: str) -> float:
    """Highest bandwidth up to which all runs of a law end as planned [Hz]; 0 where the first does not."""
    return max(takewhile(lambda hertz: run(law, hertz).incomplete is None, BANDWIDTHS), default=0.0)
