"""Is a machine near its internal resonance: ratio, threshold, verdict with reasons; what brings it out."""

from collections.abc import Callable
from dataclasses import replace
from math import inf, isfinite, pi
from typing import Any

import numpy as np

from cabledrive.mechanics.datasheet import elastic_range, largest_pretension, sags, warnings_of_rest
from cabledrive.mechanics.holding import motor_condition
from cabledrive.mechanics.network.span_table import strained
from cabledrive.mechanics.rest import rest_state
from cabledrive.modal.tuning import (
    at_pretensions,
    pulley_mode,
    resonant_pairs,
    span_frequency,
    tuned_pretension,
)
from cabledrive.parameters import Drive, InputRefused, Machine, NotComputed
from cabledrive.parameters.fields import LARGEST
from cabledrive.parameters.route.two_pulleys import two_pulleys_of
from cabledrive.reduction.autoparametric import AutoparametricModel, autoparametric_model, split_tunings
from cabledrive.reduction.averaging import averaged_coefficients
from cabledrive.reduction.decay import guessed_damping
from cabledrive.reduction.threshold import (
    BUILD_UP,
    CLOSE,
    NEAR,
    RESONANT,
    SAFE,
    InstabilityMargin,
    coulomb_onset_torque,
    growth_torque,
    instability_margin,
    threshold_torque,
)
from cabledrive.studies import resonance_detuning as regions
from cabledrive.studies.machine_pairs import SLACKENS, MachinePairs, machine_pairs, resonance_of_pairs
from cabledrive.studies.pair_thresholds import HIGHEST, SUM, NearPair, alike
from cabledrive.studies.resonance_detuning import (
    CLOSE_SHARE,
    FAILED,
    REACH,
    TRIALS,
    Remedy,
    ResonanceSummary,
    first_safe,
)

SLACK_SHARE = 0.01
"""Torque for the verdict where no limit is known, as a share of the slack torque."""

GROWTH_FACTOR, GROWTH_TIME = 10.0, 1.0


PARTED = "maps and branches take one tension in a section, of which hanging carriages part two here"
UNEVEN = 1e-3
"""Difference of tensions in a section, relative, up to which it is one string."""


def uneven(drive: Drive) -> bool:
    """Whether a hanging carriage parts two tensions, by more than a share: its section is no even string."""
    means = [[own.mean_tension for own in section.stretches] for section in rest_state(drive).sections]
    return any(max(own) > (1.0 + UNEVEN) * min(own) for own in means)


def default_torque(drive: Drive) -> float:
    """Torque where nobody states one: the motor's limit, else a hundredth of the slack torque [N m]."""
    limit = drive.motor.torque_limit if drive.motor is not None else None
    if limit is not None:
        return limit
    return SLACK_SHARE * 2.0 * drive.drive_pulley.radius * drive.cable.pretension


def resonance(
    machine: Machine | Drive, *, torque: float | None = None, load_torque: float = 0.0, details: bool = True
) -> ResonanceSummary:
    """Frequency ratio, threshold torque, pairs near resonance and verdict of a machine.

    Parameters
    ----------
    machine : Machine or Drive
    torque : float, optional
        Amplitude of the verdict [N m]; default: that of the file's [excitation]. Where there is neither, the
        verdict is "no excitation given", and the figures of a loop or a line are those at its torque limit
        or, without one, 1 % of the slack torque.
    load_torque : float, default 0.0
        Steady torque on the load pulley [N m], which splits the tuning of the spans; on loops and lines.
        Ratio, tuned pretension and its threshold are those without it.
    details : bool, default True
        Whether to list the pairs of a loop or a line, and to find its torque of tenfold growth, which take
        most of the time.

    Returns
    -------
    ResonanceSummary
        Of a machine with routes with its pairs near 1:2 and of sum type, Eq. (N.11), and without the figures
        that need a pretension to choose.

    Raises
    ------
    InputRefused
        If the torque is negative, the steady one takes a span's tension away, or a cable runs.
    NotComputed
        If a span hangs slack at rest.
    """
    machine = machine.machine
    own, stated = machine.two_pulleys, machine.excitation
    parted = own is not None and uneven(own)
    beyond = parted or (own is not None and sags(own))
    if load_torque and beyond:
        raise InputRefused(
            "load_torque is for a straight cable of one tension a section, and a span sags, or a hanging "
            "carriage parts two tensions: see `check`; leave it out"
        )
    if not load_torque and (own is None or beyond or (stated and stated.orders)):
        found = resonance_of_pairs(machine, torque, details=details)
        more = (*warnings_of_rest(machine), *([PARTED] * parted))
        return replace(found, left_out=(*found.left_out, *more))
    drive = two_pulleys_of(machine, "`resonance` under a load torque")
    most = drive.load_pulley.radius * largest_pretension(drive.cable)
    if not abs(load_torque) <= most:
        said = f"load torque = {load_torque:.4g} N m strains the cable beyond its elastic range"
        raise InputRefused(f"{said}, up to {most:.4g} N m: lower it")
    motor = motor_condition(drive)
    if torque is None and stated and stated.torque_ripple is not None:
        torque = stated.torque_ripple * (drive.motors[0].torque_limit or 0.0)  # checked with the file
    tau = default_torque(drive) if torque is None else torque
    if not tau >= 0.0:
        raise InputRefused(f"torque = {tau:.6g} N m must not be negative: give its amplitude")
    if tau > LARGEST:
        raise InputRefused(f"torque = {tau:.6g} N m is above {LARGEST:g} N m, that of no machine: lower it")
    try:
        pulley = pulley_mode(drive).omega / (2 * pi)
        if drive.drive_pulley.fixed:
            raise InputRefused("no torque acts on a drive pulley that is fixed")
    except InputRefused as refusal:
        names = ("frequency_ratio", "detuning", "tuned_pretension", "threshold_torque", "pulley_frequency")
        missing = dict.fromkeys((*names, "threshold_here", "growth_torque", "coulomb_onset"), str(refusal))
        why = (f"no 1:2 pair in range: {refusal}",)
        cautions = warnings_of_rest(machine)
        return ResonanceSummary(
            verdict=SAFE, torque=tau, reasons=why, missing=missing, motor=motor, left_out=cautions
        )
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
        # Zero where either mode is undamped, whatever round-off leaves of the tuning.
        at_threshold = float(threshold_torque(at_tuning)) if at_tuning.damped else 0.0
        growth = growth_torque(at_tuning, GROWTH_FACTOR, GROWTH_TIME) if details else None
    if not details:
        missing["growth_torque"] = "not asked for"
    ratio, here = span_frequency(drive) / pulley, float(threshold_torque(model))
    pairs = machine_pairs(drive.machine, resonant_pairs(drive)) if details else None
    verdict, beside = _of_others(instability.verdict, pairs, tau, model)
    return ResonanceSummary(
        frequency_ratio=ratio,
        detuning=ratio - 0.5,
        tuned_pretension=tuned,
        threshold_torque=at_threshold if at_threshold is not None and isfinite(at_threshold) else None,
        verdict=regions.NO_EXCITATION if torque is None else verdict,
        pulley_frequency=pulley,
        torque=tau,
        threshold_here=here if isfinite(here) else None,
        growth_torque=growth if growth is not None and isfinite(growth) else None,
        coulomb_onset=coulomb_onset_torque(model),
        instability=instability,
        pairs=() if pairs is None else pairs.pairs,
        certified=None if pairs is None else pairs.modes.certified,
        reasons=(
            *((f"{regions.STATE_ONE}; the figures are those at {tau:.4g} N m",) if torque is None else ()),
            *_reasons(drive, model, at_tuning, instability, tau, tuned),
            beside + (", without the load torque" if load_torque else ""),
            *(() if pairs is None else pairs.doubt),
            *(f"{own} span: {name}" for own, name in zip(drive.spans, drive.called, strict=False)),
        ),
        missing=missing,
        motor=motor,
        split=split_tunings(model) if load_torque else {},
    )


def _of_others(
    verdict: str, found: MachinePairs | None, torque: float, model: AutoparametricModel
) -> tuple[str, str]:
    """The verdict, by the pairs that the model of the pulley mode does not hold as well, and their words.

    ``found``: None where they were not looked for; ``torque``: [N m].
    """
    if found is None:
        return verdict, "other pairs than the 1:2 of the pulley mode were not looked at"

    def held(pair: NearPair) -> bool:
        own = [mode for mode in model.modes if (mode.span, mode.number) == (pair.span, pair.numbers[0])]
        return any(np.allclose(mode.section, pair.section) for mode in own)

    others = (
        (pair.longitudinal_hz, pair.least)
        for pair in found.pairs
        if pair.kind == SUM or not alike(pair.longitudinal_hz, found.pulley.frequency) or not held(pair)
    )
    at, lowest = min((*found.together, *others), key=lambda own: own[1], default=(0.0, inf))
    words = f"from {lowest:.4g} N m of steady torque at {at:.4g} Hz on, another pair grows"
    own = RESONANT if torque >= lowest else NEAR if torque >= CLOSE_SHARE * lowest else SAFE
    if lowest == inf:
        words = f"no pair of another longitudinal mode up to {HIGHEST:g} times the pulley mode grows"
    elif lowest == 0.0:
        words = f"the longitudinal mode at {at:.4g} Hz, of another pair, is undamped: it grows in time"
        own = NEAR
    at, slack = min(found.slack, key=lambda own: own[1], default=(0.0, inf))
    if torque >= slack:
        words += f"; {SLACKENS.format(slack, at)}"
    return max(verdict, own, NEAR if torque >= slack else SAFE, key=(SAFE, NEAR, RESONANT).index), words


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
    place = f"is detuned from 1:2 by {detuned:.4g} Hz; its instability region extends +-{width:.4g} Hz"
    ratio = float(model.transverse[instability.mode] / model.natural)
    if instability.verdict == SAFE and abs(2.0 * ratio - 1.0) > regions.FAR:
        place = f"has {ratio:.4g} times its frequency, far from 1:2"
    found = [
        f"at {torque:.4g} N m and {model.natural / (2 * pi):.4g} Hz (pulley mode): transverse mode "
        f"{mode.number} of the {mode.span} span, {ends}, {place}"
    ]
    if model.modal_damping == 0.0:
        said = "the pulley mode is undamped: the threshold at its own frequency is zero"
        found.append(f"{said}, and the instability region is that after {BUILD_UP:.3g} s of growth")
    if model.transverse_damping == 0.0:
        found.append(
            "the cable has no transverse damping: at exact tuning any motion of the pulley mode excites it"
        )
    if at_tuning is not None and not at_tuning.damped:
        across = float(np.max(at_tuning.transverse))
        assumed = replace(
            at_tuning,
            modal_damping=at_tuning.modal_damping or guessed_damping(at_tuning.natural / (2 * pi)),
            transverse_damping=at_tuning.transverse_damping or guessed_damping(across / (2 * pi)),
        )
        guessed = float(threshold_torque(assumed))
        if np.isfinite(guessed):
            found.append(
                "the drive file lacks a damping: with an assumed one per cent of critical damping the "
                f"threshold at tuning would be {guessed:.4g} N m"
            )
    if instability.slack:
        found.append(
            f"a span goes slack at q = {instability.amplitude:.4g} m before the pulley mode is built up"
        )
    onset = coulomb_onset_torque(model)
    if onset > 0.0:
        said = f"below {onset:.4g} N m, Coulomb friction prevents growth of the pulley mode"
        found.append(f"{said} (unless the mean speed exceeds the vibration speed)")
    limit, rigidity = largest_pretension(drive.cable), drive.cable.axial_rigidity
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


def pair_remedies(machine: Machine, found: ResonanceSummary) -> tuple[Remedy, ...]:
    """Changes, each by itself, that make a machine safe that by one of its pairs is not."""

    def safe(trial: Machine) -> bool:
        try:
            return resonance_of_pairs(trial, found.torque, details=False).verdict == SAFE
        except (InputRefused, NotComputed):
            return False

    if found.instability is not None:  # of a loop, whose threshold is that of its pulley mode alone
        found = resonance_of_pairs(machine, found.torque, details=False)
    if found.threshold_here is None:  # a rope goes slack first
        return ()
    least = CLOSE_SHARE * found.threshold_here
    text = f"keep the torque at the frequencies of the pairs below {least:.3g} N m"
    limit = Remedy(change="limit torque", value=least, text=text)
    return (*(_pretension(machine, safe, raised, _FEW) for raised in (True, False)), limit)


_FEW = 12
"""Pretensions tried of a machine whose pairs take long."""


def remedies(machine: Machine, torque: float, load_torque: float = 0.0) -> tuple[Remedy, ...]:
    """Changes, each by itself, that make a drive that is not safe so under a torque [N m]."""
    drive = two_pulleys_of(machine, "a remedy")
    model = autoparametric_model(drive, load_torque=load_torque, at_rest=True)

    def safe(trial: Machine | Drive) -> bool:
        try:
            found = autoparametric_model(trial, load_torque=load_torque, at_rest=True)
            return instability_margin(found, torque).verdict == SAFE
        except (InputRefused, NotComputed):  # weights or the steady load take a span's tension away
            return False

    pretensions = (_pretension(machine, safe, raised) for raised in (True, False))
    loads = (_at_load(drive, model, safe, key) for key in ("inertia", "viscous_friction"))
    return (*pretensions, *loads, _torque(model))


def _pretension(
    machine: Machine, safe: Callable[[Machine], bool], raised: bool, trials: int = TRIALS
) -> Remedy:
    """All pretensions higher or lower, in proportion, within the elastic range of the ropes."""
    words, sign = ("raise", 1) if raised else ("lower", -1)
    given = next((rope.pretension for rope in machine.ropes if rope.pretension), 0.0)

    def trial(share: float) -> Machine:
        return at_pretensions(machine, (1.0 + share) ** sign)

    def fits(one: Machine) -> bool:
        try:
            return not any(strained(one)) and safe(one)
        except InputRefused:  # weights take a span's tension away
            return False

    share = first_safe(trial, fits, trials) if given else None
    if share is None:
        if not given:
            return Remedy(change=f"{words} pretension", value=None, text="no pretension is given to change")
        beyond = raised and given * (1.0 + REACH) > largest_pretension(machine.ropes[0])
        reach = elastic_range(machine.ropes[0]).rstrip(",") if beyond else f"to x{(1 + REACH) ** sign:.3g}"
        text = f"{FAILED}: {'higher' if raised else 'lower'} pretension {reach}"
        return Remedy(change=f"{words} pretension", value=None, text=text)
    new = given * (1.0 + share) ** sign
    text = f"{words} the pretension by {abs(100 * (new / given - 1.0)):.3g} % to {new:.4g} N"
    return Remedy(change=f"{words} pretension", value=new, text=text)


def _at_load(drive: Drive, model: AutoparametricModel, safe: Callable[[Drive], bool], key: str) -> Remedy:
    """More inertia at the load pulley, up to its own, or friction, up to critical damping of the mode."""
    load, heavier = drive.load_pulley, key == "inertia"
    change = "add inertia" if heavier else "add damping"
    damping = (model.rims[1] / load.radius) ** 2 / model.modal_mass  # c_q per friction of it [1/s / (N m s)]
    most = REACH * load.inertia if heavier else 2.0 * model.natural / damping

    def trial(share: float) -> Drive:
        more: dict[str, Any] = {key: getattr(load, key) + share * most}
        return replace(drive, pulley=(drive.drive_pulley, replace(load, **more)))

    share = None if load.fixed else first_safe(trial, safe)
    if share is None:
        text = f"{FAILED}: inertia added to the load pulley, up to x{REACH:.3g} of its own"
        if not heavier:
            text = f"{FAILED}: friction at the load pulley, up to critical damping of the pulley mode"
        return Remedy(change=change, value=None, text=text)
    text = f"add {share * most:.4g} kg m^2 to the load pulley (+{100 * share:.3g} %)"
    if not heavier:
        text = f"damp the load pulley by {share * most:.3g} N m s/rad more"
    return Remedy(change=change, value=share * most, text=text)


def _torque(model: AutoparametricModel) -> Remedy:
    c = averaged_coefficients(model, torque=1.0, drift=False)
    resistance = float(np.abs(-0.5 * c.damping + 1j * c.detuning))
    outside = np.hypot(c.transverse_detuning / CLOSE, 0.5 * c.transverse_damping)  # just
    limit = float(np.min(outside * resistance / (np.abs(c.force) * np.abs(c.pump))))
    text = f"keep the torque at the pulley mode's frequency below {limit:.3g} N m"
    if limit == 0.0:
        text = f"{FAILED}: a smaller torque (the threshold at the pulley mode's frequency is zero)"
    return Remedy(change="limit torque", value=limit, text=text)
