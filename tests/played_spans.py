"""Recordings of both spans, made by the exact loop, and what is true of them.

The load pulley is held, a standing torque on the drive pulley parts the tensions, both spans are plucked, and
a microphone hears the speed of a point of each.
"""

from dataclasses import dataclass, replace

import numpy as np

from cabledrive.identification.logs.log import log_of
from cabledrive.parameters import load_drive
from cabledrive.simulation import Pluck, Recording, Scheme, Start, simulate

SPANS = ("upper", "lower")
BRAKED = ["pulley.1.fixed=true", "layout.gravity=0"]
NO_FRICTION = ["motor.coulomb_friction=0", "motor.offset_torque=0"]


@dataclass(frozen=True)
class Played:
    """A recording, the drive as its user knows it, and what is true."""

    log: object
    drive: object
    upper: float
    lower: float


def drawn(seed, **given):
    """Figures of a recording at random: tensions 2 to 16 N, damping 1 to 4 1/s, plucks of 0.5 to 2 mm."""
    rng = np.random.default_rng(seed)
    figures = {
        "pretension": rng.uniform(3.0, 12.0),
        "share": rng.uniform(0.03, 0.3) * rng.choice([-1.0, 1.0]),
        "damping": rng.uniform(1.0, 4.0),
        "heights": rng.uniform(0.5e-3, 2e-3, 2),
        "places": rng.uniform(0.15, 0.5, 2),
        "loudness": rng.uniform(0.4, 1.0, 2),
    }
    return figures | given, rng


def played(seed, *, drive=None, duration=2.0, rate=2000.0, segments=80, noise=0.05, probe=0.29, **given):
    """Play both spans of a loop; noise is relative to the largest value."""
    figures, rng = drawn(seed, **given)
    known = drive or load_drive("dissertation-3", overrides=[*BRAKED, *NO_FRICTION]).listed
    cable = replace(known.cable, pretension=figures["pretension"], transverse_damping=figures["damping"])
    true, radius = replace(known, cable=cable), known.drive_pulley.radius
    half = figures["share"] * cable.pretension
    turned = half * known.span_length / cable.axial_rigidity / radius
    plucks = tuple(
        Pluck(height=height, place=place, span=span)
        for height, place, span in zip(figures["heights"], figures["places"], SPANS, strict=True)
        if height > 0.0
    )
    run = simulate(
        true,
        duration,
        torque=2.0 * radius * half,
        start=Start(plucks=plucks, drive_angle=turned),
        scheme=Scheme(segments=segments),
        recording=Recording(rate=rate, probes=tuple((span, probe) for span in SPANS)),
    )
    heard = sum(
        loud * np.gradient(run.probe(2 + k)[:, 2], run.time) for k, loud in enumerate(figures["loudness"])
    )
    heard = heard + noise * np.abs(heard).max() * rng.normal(size=heard.size)
    log = log_of(run.time, {"sound": heard}, {})
    return Played(log=log, drive=known, upper=cable.pretension - half, lower=cable.pretension + half)


def carrying():
    """The cable of configuration 3 in the transporter, a carriage hanging at 0.3 m of the upper span."""
    settings = {"mass": 6e-5, "position": 0.3, "guided": "false"}
    overrides = [*(f"carriage.0.{key}={value}" for key, value in settings.items()), *BRAKED]
    base = load_drive("dissertation-transporter", overrides=overrides).listed
    return replace(base, cable=load_drive("dissertation-3").listed.cable)


def exact(one):
    """Tensions by every name that a span may get."""
    looser, tauter = sorted((one.upper, one.lower))
    return {"upper": one.upper, "lower": one.lower, "looser": looser, "tauter": tauter}


def errors(found, one):
    """Relative errors of both tensions, labelled or not."""
    return {name: found[name] / exact(one)[name] - 1.0 for name in found.spans}


def held(found, one):
    """How many intervals hold the truth."""
    return sum(f.tension.low <= exact(one)[name] <= f.tension.high for name, f in found.spans.items())
