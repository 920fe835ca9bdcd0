"""What a run of the rig was, in numbers, words and a quick picture."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.answers.figures import shown
from cabledrive.answers.result import Result
from cabledrive.answers.runs import TRACKING, WINCHES
from cabledrive.control.numbers import ESTIMATES, HIGH, LOW
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import described, meaning
from cabledrive.rig import run_facts as facts
from cabledrive.rig.bounds import check_theorem
from cabledrive.rig.closed_loop.cable_plant import cable_words
from cabledrive.rig.closed_loop.loop import Loop, Run
from cabledrive.rig.laws.controllers import Controller
from cabledrive.rig.laws.registry import NO_FILTER, pole_words
from cabledrive.rig.setting import DEGREE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


OBSERVERS = {
    0: "none, ideal states",
    1: "filtered difference",
    2: "Kalman filter",
    3: "Kalman filter by load",
}


@described
@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Tracking(Result):
    """A run of the rig: of a load, or of a body between two winches; an array that one has not is empty."""

    _table = "time: reference load_angle place error torque tensions"
    _heading = "{0.summary[controller]} on {0.summary[plant]}"
    summary: dict[str, Any] = meaning("what `cabledrive track --json` prints")
    time: Array = meaning("(samples,) [s]")
    unit: str = meaning('of reference and error: "rad" of a load, "m" of a body')
    reference: Array = meaning("(samples,): wanted angle of a load; (samples, m): wanted place of a body")
    load_angle: Array = meaning("(samples,): true angle of the load [rad]")
    place: Array = meaning("(samples, m): true place of the body from where it rests [m]")
    error: Array = meaning("as the reference: what is true less what is wanted at the same instant")
    torque: Array = meaning("(samples,): limited command [N m]; of winches (samples, 2), positive winding in")
    sigma: Array = meaning("(samples,): sliding variable of a law of the chain, first error of backstepping")
    estimates: Array = meaning("(samples, p): of the law")
    estimate_bounds: Array = meaning("(2, p): least and largest value of each")
    angles: Array = meaning("(samples, n): true ones of every inertia, at the first shaft [rad]")
    speeds: Array = meaning("(samples, n): likewise [rad/s]")
    readings: Array = meaning("(samples, m): of the encoders, at the first shaft [rad]")
    encoder_angles: Array = meaning("(samples, m): the same at each encoder's own shaft [rad]")
    stuck: Array = meaning("(samples,): whether the motor stood still by friction")
    tensions: Array | None = meaning(
        "(samples, spans): mean tension of upper and lower span, of an axis of routes of each piece of rope, "
        "without damping, or tension of both lines [N]; None without a flexible cable"
    )
    bound: Array | None = meaning("(samples,): the tube of the theorem for the error [rad]")
    incomplete: str | None = meaning("why the run ended early, of a body also what was not kept")
    interpreted: str | None = meaning(
        'what ran as plain Python, sample by sample, and slower for it: "controller", "plant", '
        '"controller, plant", or "loop" around compiled parts of your own; None: everything was '
        "compiled",
        None,
    )

    @property
    def figures(self) -> list[tuple[str, str]]:
        """Words and value of each main figure."""
        return shown(WINCHES if self.unit == "m" else TRACKING, self.summary)

    def to_dataframe(self) -> Any:
        """The run over time [s], and the angle of each encoder at its own shaft [rad]."""
        angles = zip(self.summary.get("encoders", ()), self.encoder_angles.T, strict=True)
        return super(Tracking, self).to_dataframe().assign(**{f"{name}_encoder": v for name, v in angles})

    def plot(self) -> "Figure":
        """Draw reference and load angle, error, and torque over time."""
        from matplotlib import pyplot

        if self.unit == "m":
            return super(Tracking, self).plot()
        said, (figure, axes) = self.summary, pyplot.subplots(3, 1, sharex=True, layout="constrained")
        above, middle, below = axes
        above.plot(self.time, np.degrees(self.reference), "--", label="reference")
        above.plot(self.time, np.degrees(self.load_angle), label="load")
        above.set(ylabel="angle [deg]", title=f"{said['controller']} on {said['plant']}")
        above.legend()
        middle.plot(self.time, np.degrees(self.error))
        if self.bound is not None and said["within_bound"] is not None:
            for sign in (-1.0, 1.0):
                middle.plot(self.time, sign * np.degrees(self.bound), ":", color="gray")
        middle.set_ylabel("error [deg]")
        below.plot(self.time, self.torque)
        below.set(ylabel="torque [N m]", xlabel="time [s]")
        return figure


def summarize(loop: Loop, done: Run, seed: int = 0) -> Tracking:
    """Put a run into words and arrays."""
    n, m, ended = loop.chain.size, len(loop.rig.encoders), done.ended
    log, made, column = done.log[:ended], loop.controller, 2 * n + 1 + m
    kept = log[:, column + 3 :]  # estimates, regressor, states of the law
    estimates, regressor = (kept[:, k : k + made.law.learning.shape[1]] for k in (0, ESTIMATES))
    error = (log[:, n - 1] - loop.target[:ended]) / loop.gear
    departed = facts.departures(loop, done)
    check = check_theorem(loop, log)
    if check is not None:
        departed |= dict.fromkeys(check.beyond, facts.DEFINITE)
    shares = (None, 1.0) if check is None else (check.used, check.unmatched_part)
    broken = facts.broken_assumptions(departed, *shares)
    incomplete = facts.why_ended(loop, done)
    summary = summary_of(loop, done, error, seed)
    summary |= facts.bound_words(check, error, broken, loop.gear)
    summary["departures"] = list(departed)
    summary |= pole_words(loop) | {"circumstances": facts.disturbance_facts(loop)}
    if loop.spec.options.check_conditions:
        summary |= facts.condition_words(loop, log[:, 2 * n], log[:, column], log[:, column + 2], regressor)
        summary |= facts.margin_words(loop, estimates, kept[:, 2 * ESTIMATES :])
    summary["estimates_within_bounds"] = within(estimates, made)
    summary |= facts.motor_words(loop.spec.actual, stepper=made.field is not None)
    summary |= facts.rest_words(loop, error) | facts.pair_words(loop, done)
    if incomplete:
        summary["ended_at"] = ended * loop.rig.interval
    return Tracking(
        summary=summary,
        time=np.asarray(loop.rig.interval * np.arange(ended), dtype=np.float64),
        unit=loop.spec.motion.unit,
        reference=loop.target[:ended] / loop.gear,
        load_angle=log[:, n - 1] / loop.gear,
        place=np.zeros((0, 0)),
        error=error,
        torque=log[:, column],
        sigma=log[:, column + 2],
        estimates=estimates,
        estimate_bounds=made.law.learning[[LOW, HIGH]],
        angles=log[:, :n],
        speeds=log[:, n : 2 * n],
        readings=log[:, 2 * n + 1 : column],
        encoder_angles=log[:, 2 * n + 1 : column] / np.array([1.0] * (m - 1) + [loop.gear]),
        stuck=log[:, column + 1] == 0.0,
        tensions=done.tensions[:ended] if done.tensions is not None else facts.span_tensions(loop, log),
        bound=None if check is None else check.bound.tube / loop.gear,
        incomplete=incomplete,
        interpreted=done.interpreted,
    )


def summary_of(loop: Loop, done: Run, error: Array, seed: int) -> dict[str, Any]:
    """Peaks of a run and what was run; ``error``, shape (samples,): of the load [rad]."""
    motion = loop.spec.motion
    score = done.score
    samples = max(len(error), 1)
    several = motion.pulses > 1 and len(error) > loop.rig.first_end

    def degrees(value: float) -> float:
        return value / loop.gear / DEGREE

    return {
        "controller": loop.controller.name,
        "gains": loop.controller.gains,
        **facts.plant_words(loop),
        "interpreted": done.interpreted,
        "slack_samples": int(score["slack"]),
        "free_play_samples": int(score["loose"]),
        "observer": OBSERVERS[loop.observer.kind] if loop.controller.field is None else NO_FILTER,
        "feedback": list(loop.controller.shafts),
        "encoders": list(loop.encoder_shafts),
        "peak_error_deg": degrees(score["peak"]),
        "first_pulse_error_deg": degrees(score["first_peak"]),
        "later_pulses_error_deg": degrees(score["later_peak"]) if several else None,
        "rms_error_deg": degrees(float(np.sqrt(score["square"] / samples))),
        "encoder_error_deg": degrees(score["own_peak"]),
        "peak_torque": score["peak_torque"],
        "saturated_fraction": score["saturated"] / samples,
        "invalid_samples": int(score["invalid"]),
        "slack_share": float(score["twist"] / loop.slack) if np.isfinite(loop.slack) else None,
        "encoder_phases": [float(v) for v in loop.rig.phases],
        "motion": {"angle_deg": motion.angle}
        | motion.words
        | ({"payload": [asdict(one) for one in motion.payload]} if motion.payload else {}),
        "delay": loop.rig.late_samples * loop.rig.interval + loop.rig.late_part,
        "sample_rate": 1.0 / loop.rig.interval,
        "internal_step": loop.driven.step if loop.cable is None else loop.cable.case.grid.step,
        "seed": seed,
    } | ({} if loop.cable is None else {"cable": cable_words(loop.cable, score, motion.angle * DEGREE)})


def within(estimates: Array, made: Controller) -> bool | None:
    """Whether every estimate, shape (samples, p), kept its bounds; None for laws without estimates."""
    if estimates.shape[1] == 0:
        return None
    low, high = made.law.learning[LOW], made.law.learning[HIGH]
    return bool(np.all((estimates >= low) & (estimates <= high)))
