"""Stage 2: what is identified from the logs; of the rest, the datasheet's values with stated uncertainty."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from cabledrive.identification.axis.answer import IdentifyOptions
from cabledrive.identification.logs.log import Log
from cabledrive.identification.one_log import identify
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.rig.setting import control_delay, current_rate
from cabledrive.studies.study.chain_regression import explained, identify_chain, whole_drive
from cabledrive.studies.study.log_replay import LogFinding, Replay, coarser_encoders, encoder_findings, replay
from cabledrive.studies.study.machine import (
    FRICTIONS,
    GOAL,
    LOAD_FRICTIONS,
    LOG,
    UNITS,
    WORDS,
    Quantity,
    by_datasheet,
    drive_with,
)
from cabledrive.studies.study.sampled_plants import (
    MOTOR_SIDE,
    TWO_SIDED_95,
    Correlation,
    among,
    of_an_axis,
    sampled_plant,
)

UNLISTED = (*LOAD_FRICTIONS, "backlash")
"""What data sheets leave out: where the log bounds it less closely than assumed, nothing is said."""
LIKELY = 8
"""Machines drawn from the intervals, to see how much of a log numbers within them explain."""
PEAK = 2.0**0.5
"""Of a sine over its root mean square."""
SEEN = 0.2
"""Share of the largest eccentricity that the replay of a log may overlook."""
ESSENTIAL = ("near_inertia", "load_inertia", "viscous_friction", "coulomb_friction", "cable_stiffness")
"""Parameters that a log of the whole drive should identify; the study reports those it does not."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Knowledge:
    """What is known of a drive."""

    quantities: dict[str, Quantity]  # by name
    undetermined: tuple[str, ...] = ()  # what is not identifiable from the logs, in words
    open_names: tuple[str, ...] = ()  # the essential quantities among them
    findings: tuple[LogFinding, ...] = ()  # what contradicts the drive file
    residual: float | None = None  # of the torque, relative; None without logs
    method: str = "no log: data-sheet values with stated uncertainty"
    correlations: tuple[Correlation, ...] = ()  # of the identified numbers; of the others none is known
    # the identified model over each log; empty where no log shows the whole drive
    replays: tuple[Replay, ...] = ()
    # counts per revolution of the encoders that a log shows coarser than the file, by their keys
    encoders: dict[str, int] = field(default_factory=dict)
    # by how much the angles of the logs are later than sampling and the file's own lags explain [s]
    late: float = 0.0

    @property
    def values(self) -> dict[str, float]:
        """The best value of each quantity."""
        return {name: quantity.value for name, quantity in self.quantities.items()}


def know(
    drive: Drive,
    logs: Sequence[Log],
    spreads: Mapping[str, float],
    load_inertia: tuple[float, float] | None = None,
    *,
    backlash: float | None = None,
) -> Knowledge:
    """What logs tell of a drive; ``load_inertia`` [kg m^2]; ``backlash``: where none is said [rad]."""
    known = by_datasheet(drive, spreads, backlash)
    if not logs:
        found = Knowledge(quantities=known)
    elif any(whole_drive(log) for log in logs):
        found = _by_regression(drive, [log for log in logs if whole_drive(log)], known)
    else:
        found = _as_one_axis(drive, logs, known)
    coarser = coarser_encoders(drive, logs)
    found = replace(found, encoders=coarser, findings=encoder_findings(drive, coarser) + found.findings)
    return found if load_inertia is None else with_load(found, load_inertia)


def usable_log(log: Log) -> Log:
    """A log with torque and angle; a "motor_angle" is taken as the angle."""
    if "angle" not in log.channels and "motor_angle" in log.channels:
        tables: list[dict[str, Any]] = [
            {"angle" if name == "motor_angle" else name: value for name, value in table.items()}
            for table in (log.channels, log.units, log.saturated, log.report.quantum)
        ]
        report = replace(log.report, quantum=tables[3])
        log = replace(log, channels=tables[0], units=tables[1], saturated=tables[2], report=report)
    if not {"torque", "angle"} <= set(log.channels):
        said = f'{log.source}: needs "torque [N m]" and "angle [rad]", has {", ".join(log.channels)}'
        raise InputRefused(f"{said}: name its columns in [log] of study.toml")
    return log


def known_drive(drive: Drive, knowledge: Knowledge) -> Drive:
    """The drive with the best value of every quantity, the encoders and the delay that its logs show."""
    known = drive_with(drive, knowledge.values)
    if known.sensors is None:
        return known
    seen: dict[str, Any] = {**knowledge.encoders, "delay": known.sensors.delay + knowledge.late}
    return replace(known, sensors=replace(known.sensors, **seen))


def _by_regression(drive: Drive, logs: Sequence[Log], known: dict[str, Quantity]) -> Knowledge:
    try:
        result = identify_chain(logs, drive)
    except InputRefused as refusal:
        return _without_result(known, str(refusal))
    fresh, words = dict(known), result.undetermined
    for name, (value, low, high) in result.intervals.items():
        sheet = known[name]
        apart = low > sheet.high or high < sheet.low
        if high - low > sheet.high - sheet.low and not apart:
            if name not in UNLISTED:
                less = "the log is less accurate than the data sheet; the data-sheet value is kept"
                words += (f"{WORDS[name]}: {less}",)
        else:
            fresh[name] = replace(known[name], value=value, low=low, high=high, source=LOG)
    # What the log leaves bounds the ripple, what a replay would see the eccentricity.
    limits = {
        "ripple_torque": PEAK * result.residual_torque,
        "eccentricity": SEEN * fresh["eccentricity"].high,
    }
    fresh |= {name: replace(fresh[name], high=min(most, fresh[name].high)) for name, most in limits.items()}
    repeats, slips = "", tuple[LogFinding, ...]()
    if (cogging := result.cogging) is not None:  # the other ripple that the log leaves is its uncertainty
        half = TWO_SIDED_95 * cogging.error + fresh["ripple_torque"].high
        one = replace(fresh["ripple_torque"], value=cogging.size, source=LOG)
        fresh["ripple_torque"] = replace(one, low=max(cogging.size - half, 0.0), high=cogging.size + half)
        order = float(cogging.periods)
        fresh["ripple_order"] = replace(
            one, name="ripple_order", unit=UNITS["ripple_order"], value=order, low=order, high=order
        )
        repeats = f"; {cogging.words}"
    if (slip := result.slip) is not None:
        inertia = fresh["load_inertia"].value * (drive.drive_pulley.radius / drive.load_pulley.radius) ** 2
        name, value = ("creep", slip.creep / inertia) if slip.creep else ("slip_torque", slip.limit * inertia)
        half = TWO_SIDED_95 * slip.error * value / (slip.creep or slip.limit)
        ends = {"low": max(value - half, 0.0), "high": value + half}
        fresh[name] = Quantity(name=name, value=value, unit=UNITS[name], source=LOG, **ends)
        then = "runs in which it would slide end early, and the model is not replayed over the log"
        then = "what it moves the load is added to every error" if slip.creep else then
        slips = (LogFinding(id="slip", words=f"{slip.words(inertia)}: {then}", decides=False),)
    machine = drive_with(drive, {name: quantity.value for name, quantity in fresh.items()})
    correlations = among(result.correlations, fresh)
    likely = [drive_with(drive, sampled_plant(fresh, 0, 0, draw, correlations)[0]) for draw in range(LIKELY)]
    replays: tuple[Replay, ...] = ()
    if result.slip is None or result.slip.creep > 0.0:  # what slides is no part of the model
        parts = (explained(log, result, drive, number) for number, log in enumerate(logs))
        replays = tuple(replay(one, machine, likely=likely) for one in parts)
    against = []
    for name, sheet in known.items():
        one = fresh[name]
        if one.source == LOG and (one.low > sheet.high or one.high < sheet.low):
            guess = name in (*FRICTIONS, "ripple_torque")
            said = (
                f"{WORDS[name]}: {one.value:.4g} {one.unit} from the log, outside the data-sheet interval "
                f"{sheet.low:.4g} to {sheet.high:.4g} {one.unit}"
            ) + ("; it replaces the data-sheet value" if guess else "")
            limit = sheet.high if one.low > sheet.high else sheet.low
            finding = LogFinding(id=name, value=one.value, limit=limit, unit=one.unit, words=said)
            against.append(replace(finding, decides=not guess))
    late, beyond = _late(result.lag, drive, max(log.interval for log in logs))
    findings = (*slips, *against, *late)
    return Knowledge(
        quantities=fresh,
        undetermined=words,
        open_names=tuple(name for name in ESSENTIAL if name in result.negative),
        findings=findings
        + tuple(
            LogFinding(id="replay", value=one.ratio, limit=one.limit, words=one.words)
            for one in replays
            if one.contradicts
        ),
        replays=replays,
        residual=result.residual,
        method="sum of torques, equation of the load and twist of the joint; "
        f"{100 * result.kept:.0f} % of the samples could be used{repeats}",
        correlations=correlations,
        late=beyond,
    )


def _late(lag: float, drive: Drive, interval: float) -> tuple[tuple[LogFinding, ...], float]:
    """A lag that neither sampling nor the drive file's own lags explain, and by how much it is beyond [s]."""
    rate = current_rate(drive)
    known = control_delay(drive) + (1.0 / rate if rate > 0.0 else 0.0)
    if -interval <= lag <= 1.5 * interval + known:
        return (), 0.0
    allowed = 1e3 * (1.5 * interval + known)
    words = f"the angles lag the torque by {1e3 * lag:.3g} ms; "
    words += f"sampling and the lags of the drive file allow {-1e3 * interval:.3g} to {allowed:.3g} ms"
    if lag > 0.0:
        words += "; the controller is designed for the rest as a delay"
    limit = 1e-3 * allowed if lag > 0.0 else -interval
    found = LogFinding(id="delay", value=lag, limit=limit, unit="s", words=words)
    return (found,), max(lag - 0.5 * interval - known, 0.0)


def _as_one_axis(drive: Drive, logs: Sequence[Log], known: dict[str, Quantity]) -> Knowledge:
    """Only torque and one angle: what a rigid axis would give, if the drive moved as one."""
    try:
        found = identify(list(logs), IdentifyOptions(), method="inverse-dynamics")
    except (InputRefused, NotComputed) as failure:
        return _without_result(known, str(failure))
    wrong = list(found.findings) if found.refused else []
    fresh, result = dict(known), found.identifiable and not wrong
    together: tuple[Correlation, ...] = ()
    if result and "inertia" in found.parameters:
        # Either inertia over that of the whole axis at the motor, as the data sheet has it.
        gear = drive.load_pulley.radius / drive.drive_pulley.radius
        whole = known["near_inertia"].value + known["load_inertia"].value / gear**2
        parts = {name: known[name].value / whole for name in ("near_inertia", "load_inertia")}
        axis = found.parameters["inertia"]
        for name, part in parts.items():  # split as the data sheet has it
            sheet = known[name]
            value, half = part * axis.value, part * 0.5 * (axis.high - axis.low)
            half += sheet.half_width / sheet.value * abs(value)
            fresh[name] = replace(sheet, value=value, low=value - half, high=value + half, source=LOG)
        for name in MOTOR_SIDE:
            e = found.parameters[name]
            fresh[name] = replace(known[name], value=e.value, low=e.low, high=e.high, source=LOG)
        together = of_an_axis(found, parts, fresh)
    words = found.unidentifiable + tuple(wrong)
    words += ("the log has no load angle: stiffness, damping and load are from the data sheet",)
    return Knowledge(
        quantities=fresh,
        undetermined=words,
        open_names=tuple(
            name for name in ESSENTIAL[:4] if name != "load_inertia" and fresh[name].source != LOG
        ),
        findings=tuple(LogFinding(id="identification", words=f) for f in found.findings if f not in wrong),
        residual=float(found.residual["relative"]),
        method="one rigid axis, inverse dynamics; the split between motor and load is from the data sheet",
        correlations=among(together, fresh),
    )


def _without_result(known: dict[str, Quantity], why: str) -> Knowledge:
    return Knowledge(
        quantities=known,
        undetermined=(why,),
        open_names=ESSENTIAL,
        method="data-sheet values with stated uncertainty, since the logs could not be used",
    )


def with_load(found: Knowledge, load: tuple[float, float]) -> Knowledge:
    """The same with the load that the goals ask for; ``load``: smallest and largest inertia [kg m^2]."""
    low, high = load
    own = found.quantities["load_inertia"]
    value = 0.5 * (low + high)
    fresh = replace(own, value=value, low=low, high=high, source=GOAL)
    quantities = found.quantities | {"load_inertia": fresh}
    return replace(found, quantities=quantities, correlations=among(found.correlations, quantities))
