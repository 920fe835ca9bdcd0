"""What a machine with routes is at rest, span by span and pulley by pulley, and what must be known of it."""

from collections.abc import Iterator
from math import asin, degrees, hypot, log, sqrt
from typing import Any

import numpy as np

from cabledrive.answers.keys import Keys
from cabledrive.mechanics.network.motion import Motion
from cabledrive.mechanics.network.rest_forces import sag_parameter
from cabledrive.mechanics.network.statics import Statics, statics_of, unheld_words
from cabledrive.parameters import Machine

_ASKEW_FROM, _ASKEW_TO = 1e-3, 15.0
"""Angles [deg] between which a span was probably meant to be parallel to a slide."""

_LITTLE_SAFETY = 3.0
ELASTIC_RULE = 0.02  # strain, where the file states no limit


END = "the span ends at an anchor or a drum"
SPAN_ROW = Keys(
    "text: name route number: length unstretched_length tension tension_start tension_end wrap "
    "string_frequency_hz irvine_parameter equivalent_rigidity safety_factor count: ropes note: pulley "
    "numbers: along",
    {"safety_factor": "no strength [N] in the file", "wrap": END, "pulley": END},
)
PULLEY_ROW = Keys(
    "text: name route number: wrap tension_in tension_out needed_friction capstan_friction bend_ratio",
    {
        "needed_friction": "a tension is gone",
        "capstan_friction": "no capstan_friction in the file",
        "bend_ratio": "no least bending radius of the rope in the file",
    },
)


def span_rows(drive: Machine, statics: Statics) -> list[dict[str, Any]]:
    """One row for each free span, in SI."""
    rows = []
    for number, span in enumerate(drive.free_spans):
        rope, route = drive.ropes[span.route], drive.route[span.route]
        tension = float(statics.mean[number])
        largest = float(max(statics.start[number], statics.end[number]))
        rigidity = rope.axial_rigidity
        irvine = sag_parameter(statics.stretches[number])
        rows.append(
            {
                "name": span.name,
                "route": route.name,
                "length": span.length,
                "unstretched_length": sum(piece.length for piece in statics.stretches[number]),
                "tension": tension,
                "tension_start": float(statics.start[number]),
                "tension_end": float(statics.end[number]),
                "ropes": route.ropes,
                "wrap": span.wrap,
                "pulley": span.end.name if span.end.sense else None,
                "along": list(span.along),
                "string_frequency_hz": (rope.wave_speed(tension) ** 2 - route.speed**2)
                / rope.wave_speed(tension)
                / (2.0 * span.length),
                "irvine_parameter": irvine,
                # Ernst: the chord of a sagging rope is softer than the rope.
                "equivalent_rigidity": rigidity / (1.0 + irvine / 12.0),
                "safety_factor": None if rope.strength is None else rope.strength / largest,
            }
        )
    return rows


def pulley_rows(drive: Machine, statics: Statics) -> list[dict[str, Any]]:
    """One row for each pulley that a rope passes: wrap, tensions, the friction that holds them."""
    rows = []
    for number, span in enumerate(drive.free_spans):
        if span.wrap is None or span.end.pulley is None:
            continue
        after = next_span(drive, number)
        rope, route = drive.ropes[span.route], drive.route[span.route]
        left = hypot(*statics.stretches[number][-1].end_force), hypot(*statics.stretches[after][0].force)
        first, last = float(statics.end[number]), float(statics.start[after])
        pulley = drive.pulley[span.end.pulley]
        # what keeps the rope from slipping, |ln(T1/T2)| / wrap; None: no friction does
        needed: float | None = None
        if min(first, last) > 0.0 and min(left) > 0.0:
            unequal = abs(log(left[0] / left[1]))
            needed = 0.0 if unequal < 1e-12 else unequal / span.wrap if span.wrap > 0.0 else None
        # a rope of bending stiffness EI that passes a small angle a under a tension T is bent to no less than
        # 2 sqrt(EI/T) / a, however small the pulley is
        bent, mean = pulley.radius, 0.5 * (first + last)
        if rope.bending_stiffness is not None and mean > 0.0 and span.wrap > 0.0:
            bent = max(bent, 2.0 * sqrt(rope.bending_stiffness / mean) / span.wrap)
        rows.append(
            {
                "name": pulley.name,
                "route": route.name,
                "wrap": span.wrap,
                "tension_in": first,
                "tension_out": last,
                "needed_friction": needed,
                "capstan_friction": pulley.capstan_friction,
                "bend_ratio": None if rope.least_radius is None else bent / rope.least_radius,
            }
        )
    return rows


def next_span(drive: Machine, number: int) -> int:
    """Number of the span after one on its route; of the last one the first."""
    route = drive.free_spans[number].route
    own = [i for i, span in enumerate(drive.free_spans) if span.route == route]
    return own[(own.index(number) + 1) % len(own)]


def route_warnings(drive: Machine) -> tuple[str, ...]:
    """What looks odd about a machine with routes, one line each."""
    statics = statics_of(drive)
    return (
        *unheld_words(Motion(drive), statics),
        *_askew(drive),
        *slipping(drive, statics),
        *worn(drive, statics),
        *strained(drive, statics),
        *_pretension(drive, statics),
    )


def worn(drive: Machine, statics: Statics) -> Iterator[str]:
    """Ropes near their strength at rest, and pulleys that bend them too much."""
    for row in span_rows(drive, statics):
        if row["safety_factor"] is not None and row["safety_factor"] < _LITTLE_SAFETY:
            yield f"span {row['name']} has a safety factor of {row['safety_factor']:.3g} at rest"
    for row in pulley_rows(drive, statics):
        if row["bend_ratio"] is not None and row["bend_ratio"] < 1.0:
            yield f"pulley {row['name']} bends the rope to {row['bend_ratio']:.2g} of its smallest radius"


def _askew(drive: Machine) -> Iterator[str]:
    """Spans not quite parallel to the slide, if it is one and no plane, that one of their ends rides on."""
    motion = Motion(drive)
    both_ways = {body.name for body in drive.body if set(body.moves) == {"x", "y"}}
    for span in drive.free_spans:
        near, far = (
            motion.dense(*motion.point(at.centre, motion.body_of(at))) for at in (span.start, span.end)
        )
        for step, name in zip((far - near).T, motion.names, strict=True):
            body, _, move = name.rpartition(".")
            if move not in ("x", "y") or body in both_ways or not step.any():
                continue
            cross = span.along[0] * float(step[1]) - span.along[1] * float(step[0])
            angle = degrees(asin(min(1.0, abs(cross) / hypot(float(step[0]), float(step[1])))))
            if _ASKEW_FROM < angle < _ASKEW_TO:
                yield (
                    f"span {span.name} runs askew to {name} by {angle:.3g} deg: its tension pulls across the "
                    "slide and turns a rigid-body mode into a slow one"
                )


def slipping(drive: Machine, statics: Statics) -> Iterator[str]:
    """Pulleys whose friction does not hold the rope at rest."""
    for row in pulley_rows(drive, statics):
        have, need = row["capstan_friction"], row["needed_friction"]
        if have is not None and (need is None or need > have):
            shown = "more than any" if need is None else f"{need:.3g}"
            yield f"the rope slips on {row['name']}: friction {have:.3g}, needed {shown}"


def strained(drive: Machine, statics: Statics | None = None) -> Iterator[str]:
    """Spans strained out of their elastic range, where the computed tension means nothing."""
    statics = statics or statics_of(drive)
    for number, span in enumerate(drive.free_spans):
        rope = drive.ropes[span.route]
        limit = ELASTIC_RULE if rope.strain_limit is None else rope.strain_limit
        strain = max(statics.start[number], statics.end[number]) / rope.axial_rigidity
        if strain > limit:
            rule = "a rule of thumb: give strain_limit" if rope.strain_limit is None else "strain_limit"
            yield (
                f"span {span.name} is strained by {strain:.3g} at rest, beyond {limit:.3g}, its elastic "
                f"range ({rule}): change geometry, loads or rope"
            )


def _pretension(drive: Machine, statics: Statics) -> Iterator[str]:
    """A pretension that the balance of the bodies overrules."""
    for number, rope in enumerate(drive.ropes):
        if rope.pretension is None:
            continue
        own = [i for i, span in enumerate(drive.free_spans) if span.route == number]
        found = np.concatenate((statics.start[own], statics.end[own]))
        worst = float(found[np.argmax(np.abs(found - rope.pretension))])
        if abs(worst - rope.pretension) > 0.01 * rope.pretension:
            lengths = np.array([drive.free_spans[i].length for i in own])
            longer = float((statics.mean[own] - rope.pretension) @ lengths) / rope.axial_rigidity
            change = f"is {1e3 * abs(longer):.3g} mm {'longer' if longer > 0.0 else 'shorter'} for it"
            if abs(longer) < 1e-9 * lengths.sum():
                change = "keeps its length"
            yield (
                f"route {drive.route[number].name}: bodies and weights make its tension {worst:.4g} N in one "
                f"place, its pretension is {rope.pretension:.4g} N: it {change}, and bodies are kept where "
                "the file has them"
            )
