"""Is this drive near its internal resonance: ratio, tuned pretension, threshold, verdict, with reasons."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from cabledrive.modes.tuning import Pair, pulley_mode, resonant_pairs, span_frequency, tuned_pretension
from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.autoparametric import AutoparametricModel, autoparametric_model
from cabledrive.reduction.averaging import averaged_coefficients
from cabledrive.reduction.threshold import (
    coulomb_onset_torque,
    growth_rates,
    growth_torque,
    pulley_amplitude,
    threshold_torque,
    tongue_half_width,
)

BUILD_UP = 10.0
"""How long the torque has acted when the verdict is given [s]."""

SLACK_SHARE = 0.01
"""Torque for the verdict where no limit is known, as a share of the slack torque."""

CLOSE = 2.0
"""Within so many half-widths of the tongue a drive is close to resonance."""

GROWTH_FACTOR, GROWTH_TIME = 10.0, 1.0

RESONANT, NEAR, SAFE = "resonant", "close", "safe"


@dataclass(frozen=True, slots=True, kw_only=True)
class Standing:
    """Where a drive stands against the tongue of a torque.

    Attributes
    ----------
    verdict : {"resonant", "close", "safe"}
    mode : int
        The transverse mode, of those of the model, that decides.
    distance, half_width : float
        Detuning from the middle of the tongue and its half-width [rad/s].
    growth : float
        Growth rate of a vanishing motion [1/s].
    amplitude : float
        Pulley mode's amplitude q under the torque [m].
    slack : bool
        Whether that amplitude is where a span goes slack.
    """

    verdict: str
    mode: int
    distance: float
    half_width: float
    growth: float
    amplitude: float
    slack: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class ResonanceSummary:
    """What there is to say about the internal resonance of a drive.

    Attributes
    ----------
    frequency_ratio, detuning : float or None
        Lowest transverse frequency of an empty span over the pulley mode's, and that minus one half.
    tuned_pretension : float or None
        [N].
    threshold_torque : float or None
        At the tuned pretension [N m].
    verdict : {"resonant", "close", "safe"}
    pulley_frequency : float or None
        [Hz].
    torque : float
        Torque of the verdict [N m].
    threshold_here : float or None
        Threshold at the drive's own pretension [N m].
    growth_torque : float or None
        Torque for tenfold growth in one second at the tuned pretension [N m].
    coulomb_onset : float or None
        Torque below which Coulomb friction keeps the pulley mode from growing [N m].
    standing : Standing or None
    pairs : tuple of Pair
    reasons : tuple of str
        Of the verdict, and of whatever is missing.
    missing : dict of str to str
        Why a number does not exist, by its name.
    """

    frequency_ratio: float | None
    detuning: float | None
    tuned_pretension: float | None
    threshold_torque: float | None
    verdict: str
    pulley_frequency: float | None
    torque: float
    threshold_here: float | None
    growth_torque: float | None
    coulomb_onset: float | None
    standing: Standing | None
    pairs: tuple[Pair, ...]
    reasons: tuple[str, ...]
    missing: dict[str, str]


def default_torque(drive: Drive) -> float:
    """Torque of the verdict: the motor's limit, else one hundredth of the slack torque.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    float
        [N m].
    """
    limit = drive.motor.torque_limit if drive.motor is not None else None
    if limit is not None:
        return limit
    return SLACK_SHARE * 2.0 * drive.drive_pulley.radius * drive.cable.pretension


def resonance_summary(drive: Drive, *, torque: float | None = None) -> ResonanceSummary:
    """Frequency ratio, tuned pretension, threshold torque and verdict of a drive.

    Parameters
    ----------
    drive : Drive
    torque : float, optional
        Amplitude of the torque at the pulley mode's frequency [N m]; see `default_torque`.

    Returns
    -------
    ResonanceSummary

    Raises
    ------
    InputRefused
        If the torque is negative.
    """
    tau = default_torque(drive) if torque is None else torque
    if not tau >= 0.0:
        raise InputRefused(f"torque = {tau:.6g} N m must not be negative: give its amplitude")
    try:
        pulley = pulley_mode(drive).omega / (2 * pi)
    except InputRefused as refusal:
        return _without_pulley_mode(tau, str(refusal))
    model = autoparametric_model(drive)
    standing = standing_of(model, tau)
    tuned, missing = _tuned(drive)
    at_tuning = (
        autoparametric_model(replace(drive, cable=replace(drive.cable, pretension=tuned))) if tuned else None
    )
    ratio = span_frequency(drive) / pulley
    return ResonanceSummary(
        frequency_ratio=ratio,
        detuning=ratio - 0.5,
        tuned_pretension=tuned,
        threshold_torque=_tuned_threshold(at_tuning),
        verdict=standing.verdict,
        pulley_frequency=pulley,
        torque=tau,
        threshold_here=_finite(float(threshold_torque(model))),
        growth_torque=_finite(growth_torque(at_tuning, GROWTH_FACTOR, GROWTH_TIME)) if at_tuning else None,
        coulomb_onset=coulomb_onset_torque(model),
        standing=standing,
        pairs=resonant_pairs(drive),
        reasons=_reasons(drive, model, at_tuning, standing, tau, tuned),
        missing=missing,
    )


def standing_of(model: AutoparametricModel, torque: float) -> Standing:
    """Where a drive stands against the tongue of a torque that has acted for `BUILD_UP`.

    Parameters
    ----------
    model : AutoparametricModel
    torque : float
        [N m].

    Returns
    -------
    Standing
        Of the transverse mode that is relatively nearest to its tongue.
    """
    c = averaged_coefficients(model, torque=torque, drift=False)
    reached = float(pulley_amplitude(c, BUILD_UP))
    amplitude = min(reached, float(model.slack_amplitude))
    width = tongue_half_width(c, amplitude)
    pumping = np.abs(c.pump) * amplitude
    distance = np.abs(c.transverse_detuning + pumping**2 / (2.0 * c.forcing))
    mode = int(np.argmin(distance - CLOSE * width))
    near, half = float(distance[mode]), float(width[mode])
    verdict = RESONANT if near < half else NEAR if near < CLOSE * half else SAFE
    return Standing(
        verdict=verdict,
        mode=mode,
        distance=near,
        half_width=half,
        growth=float(growth_rates(c, amplitude)[mode]),
        amplitude=amplitude,
        slack=reached > model.slack_amplitude,
    )


def _tuned(drive: Drive) -> tuple[float | None, dict[str, str]]:
    try:
        return tuned_pretension(drive), {}
    except InputRefused as refusal:
        why = str(refusal)
        return None, dict.fromkeys(("tuned_pretension", "threshold_torque", "growth_torque"), why)


def _tuned_threshold(model: AutoparametricModel | None) -> float | None:
    """Zero where either mode is undamped, whatever round-off leaves of the tuning."""
    if model is None:
        return None
    if model.modal_damping == 0.0 or model.transverse_damping == 0.0:
        return 0.0
    return float(threshold_torque(model))


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _without_pulley_mode(torque: float, why: str) -> ResonanceSummary:
    names = ("frequency_ratio", "detuning", "tuned_pretension", "threshold_torque", "pulley_frequency")
    return ResonanceSummary(
        frequency_ratio=None,
        detuning=None,
        tuned_pretension=None,
        threshold_torque=None,
        verdict=SAFE,
        pulley_frequency=None,
        torque=torque,
        threshold_here=None,
        growth_torque=None,
        coulomb_onset=None,
        standing=None,
        pairs=(),
        reasons=(f"no 1:2 pair in range: {why}",),
        missing=dict.fromkeys((*names, "threshold_here", "growth_torque", "coulomb_onset"), why),
    )


def _reasons(
    drive: Drive,
    model: AutoparametricModel,
    at_tuning: AutoparametricModel | None,
    standing: Standing,
    torque: float,
    tuned: float | None,
) -> tuple[str, ...]:
    """The verdict in words, and every rule that bears on it."""
    mode = model.modes[standing.mode]
    where = f"transverse mode {mode.number} of the {mode.span} span"
    found = [
        f"{where} lies {standing.distance:.4g} rad/s from the middle of the tongue, whose half-width under "
        f"{torque:.4g} N m is {standing.half_width:.4g} rad/s"
    ]
    if model.modal_damping == 0.0:
        found.append(
            "the pulley mode is undamped: the threshold at its own frequency is zero, and the tongue is that "
            f"of {BUILD_UP:.3g} s of growth"
        )
    if model.transverse_damping == 0.0:
        found.append(
            "the cable is undamped across: at exact tuning any motion of the pulley mode makes it grow"
        )
    if standing.slack:
        found.append(
            f"a span goes slack at q = {standing.amplitude:.4g} m before the pulley mode is built up"
        )
    onset = coulomb_onset_torque(model)
    if onset > 0.0:
        found.append(
            f"Coulomb friction keeps the pulley mode from growing below {onset:.4g} N m, unless the drive "
            "turns one way faster than it vibrates"
        )
    limit = drive.cable.strain_limit
    if tuned is not None and limit is not None and tuned / drive.cable.axial_rigidity > limit:
        strain = tuned / drive.cable.axial_rigidity
        found.append(
            f"the tuned pretension strains the cable by {strain:.3g}, above its elastic range {limit:.3g}"
        )
    if at_tuning is not None and max(abs(2 * at_tuning.transverse / at_tuning.natural - 1)) > 1e-6:
        found.append(
            "carriages divide the spans: at the tuned pretension of an empty span their own modes are "
            "elsewhere; see the pairs"
        )
    return tuple(found)
