"""Is this drive near its internal resonance: ratio, tuned pretension, threshold, verdict, with reasons."""

from dataclasses import dataclass, field, replace
from math import pi

import numpy as np

from cabledrive.mechanics.warnings import largest_pretension
from cabledrive.modal.tuning import Pair, pulley_mode, resonant_pairs, span_frequency, tuned_pretension
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import LARGEST, figure
from cabledrive.parameters.route.drive import require_two_pulleys
from cabledrive.reduction.autoparametric import AutoparametricModel, autoparametric_model
from cabledrive.reduction.decay import guessed_damping
from cabledrive.reduction.threshold import (
    coulomb_onset_torque,
    growth_torque,
    threshold_torque,
)
from cabledrive.studies.pair_thresholds import CoupledPair, coupled_pairs
from cabledrive.studies.resonance_detuning import (
    BUILD_UP,
    NEAR,
    NO_EXCITATION,
    RESONANT,
    SAFE,
    SHOWN,
    STATE_ONE,
    InstabilityMargin,
    far_from_tuning,
    instability_margin,
    split_tunings,
    tuned_threshold,
)

__all__ = [
    "NEAR",
    "RESONANT",
    "SAFE",
    "InstabilityMargin",
    "ResonanceSummary",
    "default_torque",
    "instability_margin",
    "resonance",
]

SLACK_SHARE = 0.01
"""Torque for the verdict where no limit is known, as a share of the slack torque."""

GROWTH_FACTOR, GROWTH_TIME = 10.0, 1.0


SLACK = "the spans go slack before any torque does this"


@dataclass(frozen=True, slots=True, kw_only=True)
class ResonanceSummary:
    """What there is to say about the internal resonance of a drive; None: see ``missing``."""

    frequency_ratio: float | None = figure(
        "1", "Frequency ratio, first transverse of an empty span over pulley mode", SHOWN, default=None
    )
    detuning: float | None = figure("1", "Detuning, ratio - 1/2", SHOWN, default=None)
    tuned_pretension: float | None = figure("N", "Tuned pretension, ratio 1/2", SHOWN, default=None)
    threshold_torque: float | None = figure("N m", "Threshold torque, tuned", SHOWN, default=None)
    verdict: str  # {"resonant", "close", "safe", "no excitation given"}
    pulley_frequency: float | None = figure(
        "Hz", "Pulley mode", SHOWN, key="pulley_frequency_hz", default=None
    )
    # of the verdict; where no excitation is given, of the other figures
    torque: float = figure("N m", "Torque of these figures", SHOWN)
    threshold_here: float | None = figure(
        "N m",
        "Threshold torque, as given",
        SHOWN,
        SLACK,
        key="threshold_torque_at_own_pretension",
        default=None,
    )
    growth_torque: float | None = figure(
        "N m", "Tenfold growth in 1 s, tuned", SHOWN, SLACK, key="tenfold_growth_torque", default=None
    )
    # below which friction keeps the pulley mode from growing
    coulomb_onset: float | None = figure(
        "N m", "No growth below, by Coulomb friction", SHOWN, SLACK, key="coulomb_onset_torque", default=None
    )
    instability: InstabilityMargin | None = None
    pairs: tuple[Pair, ...] = ()  # of the pulley mode, with their tuned pretensions
    coupled: tuple[CoupledPair, ...] = ()  # of it and of others near resonance, with their thresholds
    reasons: tuple[str, ...]  # of the verdict
    missing: dict[str, str]  # why a number does not exist, by its name
    split: dict[str, float | None] = field(default_factory=dict)  # tuned under a steady load, by span [N]


def default_torque(drive: Drive) -> float:
    """Torque where nobody states one: the motor's limit, else a hundredth of the slack torque [N m]."""
    limit = drive.motor.torque_limit if drive.motor is not None else None
    if limit is not None:
        return limit
    return SLACK_SHARE * 2.0 * drive.drive_pulley.radius * drive.cable.pretension


def resonance(
    drive: Drive, *, torque: float | None = None, load_torque: float = 0.0, details: bool = True
) -> ResonanceSummary:
    """Ratio, tuned pretension, threshold and verdict of a loop or line under a ``torque`` [N m].

    Ratio, tuned pretension and its threshold are those without ``load_torque`` [N m], which splits the tuning
    of the spans; ``details``: list the pairs and find the torque of tenfold growth, most of the time's work.
    """
    require_two_pulleys(drive, "`resonance`")
    stated = drive.excitation.torque_ripple if drive.excitation is not None else None
    if torque is None and stated is not None:
        torque = stated * drive.motor.torque_limit  # type: ignore[union-attr, operator]  # checked with the file
    tau = default_torque(drive) if torque is None else torque
    if not tau >= 0.0:
        raise InputRefused(f"torque = {tau:.6g} N m must not be negative: give its amplitude")
    if tau > LARGEST:
        raise InputRefused(f"torque = {tau:.6g} N m is above {LARGEST:g} N m, that of no machine: lower it")
    try:
        pulley = pulley_mode(drive).omega / (2 * pi)
    except InputRefused as refusal:
        names = ("frequency_ratio", "detuning", "tuned_pretension", "threshold_torque", "pulley_frequency")
        missing = dict.fromkeys((*names, "threshold_here", "growth_torque", "coulomb_onset"), str(refusal))
        why = (f"no 1:2 pair in range: {refusal}",)
        return ResonanceSummary(verdict=SAFE, torque=tau, reasons=why, missing=missing)
    model = autoparametric_model(drive, load_torque=load_torque, at_rest=True)
    instability = instability_margin(model, tau)
    divided = ", where carriages divide the spans and no section is near 1:2," if drive.carriage else ""
    missing = {
        "threshold_torque": f"at the tuned pretension of an empty span{divided} no torque makes a mode grow",
        "threshold_here": "no section is near enough to 1:2 for any torque at the pulley mode's frequency",
    }
    tuned = at_tuning = at_threshold = growth = None
    try:
        tuned = tuned_pretension(drive)
    except InputRefused as refusal:
        missing |= dict.fromkeys(("tuned_pretension", "threshold_torque", "growth_torque"), str(refusal))
    if tuned:
        at_tuning = autoparametric_model(replace(drive, cable=replace(drive.cable, pretension=tuned)))
        at_threshold = float(tuned_threshold(at_tuning))
        growth = growth_torque(at_tuning, GROWTH_FACTOR, GROWTH_TIME) if details else None
    if not details:
        missing["growth_torque"] = "not asked for"
    ratio = span_frequency(drive) / pulley
    return ResonanceSummary(
        frequency_ratio=ratio,
        detuning=ratio - 0.5,
        tuned_pretension=tuned,
        threshold_torque=_finite(at_threshold),
        verdict=NO_EXCITATION if torque is None else instability.verdict,
        pulley_frequency=pulley,
        torque=tau,
        threshold_here=_finite(float(threshold_torque(model))),
        growth_torque=_finite(growth),
        coulomb_onset=coulomb_onset_torque(model),
        instability=instability,
        pairs=resonant_pairs(drive) if details else (),
        coupled=coupled_pairs(drive, model.natural) if details else (),
        reasons=(
            *((f"{STATE_ONE}; the figures are those at {tau:.4g} N m",) if torque is None else ()),
            *_reasons(drive, model, at_tuning, instability, tau, tuned),
        ),
        missing=missing,
        split=split_tunings(model) if load_torque else {},
    )


def _guessed_threshold(model: AutoparametricModel) -> float:
    """Threshold with an estimate for every damping that is zero."""
    across = float(np.max(model.transverse)) / (2 * pi)
    guessed = replace(
        model,
        modal_damping=model.modal_damping or guessed_damping(model.natural / (2 * pi)),
        transverse_damping=model.transverse_damping or guessed_damping(across),
    )
    return float(threshold_torque(guessed))


def _finite(value: float | None) -> float | None:
    return value if value is not None and np.isfinite(value) else None


def _reasons(
    drive: Drive,
    model: AutoparametricModel,
    at_tuning: AutoparametricModel | None,
    instability: InstabilityMargin,
    torque: float,
    tuned: float | None,
) -> tuple[str, ...]:
    """The verdict in words, and every rule that bears on it."""
    mode = model.modes[instability.mode]
    ends = f"{mode.section[0]:.4g} m to {mode.section[1]:.4g} m"
    detuned, width = instability.distance / (2 * pi), instability.half_width / (2 * pi)
    near = f"is detuned from 1:2 by {detuned:.4g} Hz; its instability region extends +-{width:.4g} Hz"
    found = [
        f"at {torque:.4g} N m and {model.natural / (2 * pi):.4g} Hz (pulley mode): transverse mode "
        f"{mode.number} of the {mode.span} span, {ends}, {far_from_tuning(model, instability) or near}"
    ]
    if model.modal_damping == 0.0:
        found.append(
            "the pulley mode is undamped: the threshold at its own frequency is zero, and the instability "
            f"region is that after {BUILD_UP:.3g} s of growth"
        )
    if model.transverse_damping == 0.0:
        found.append(
            "the cable has no transverse damping: at exact tuning any motion of the pulley mode excites it"
        )
    undamped = at_tuning is not None and 0.0 in (at_tuning.modal_damping, at_tuning.transverse_damping)
    if at_tuning is not None and undamped and np.isfinite(_guessed_threshold(at_tuning)):
        found.append(
            "the drive file lacks a damping: with an assumed one per cent of critical damping the "
            f"threshold at tuning would be {_guessed_threshold(at_tuning):.4g} N m"
        )
    if instability.slack:
        found.append(
            f"a span goes slack at q = {instability.amplitude:.4g} m before the pulley mode is built up"
        )
    onset = coulomb_onset_torque(model)
    if onset > 0.0:
        found.append(
            f"below {onset:.4g} N m, Coulomb friction prevents growth of the pulley mode (unless the mean "
            "speed exceeds the vibration speed)"
        )
    limit, rigidity = largest_pretension(drive), drive.cable.axial_rigidity
    if tuned is not None and tuned > limit:
        found.append(
            f"the tuned pretension strains the cable by {tuned / rigidity:.3g}, above its elastic range "
            f"{limit / rigidity:.3g}: no pretension within it, up to {limit:.4g} N, tunes an empty span"
        )
    if at_tuning is not None and max(abs(2 * at_tuning.transverse / at_tuning.natural - 1)) > 1e-6:
        found.append(
            "carriages divide the spans: at the tuned pretension of an empty span their own modes are "
            "elsewhere; see the pairs"
        )
    return tuple(found)
