"""Figs. 4.7 to 4.16: regressors before and after the filter, and the modelling error; the entries of 4.2."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import causal_filter, difference, ideal_low_pass
from cabledrive.rig.bench.virtual_rig import BENCH_TESTS
from reproduction.bench_logs import EXPERIMENTS, Experiment, bench_log
from reproduction.chapter_4_tables import table_4_1, table_4_2
from reproduction.item import AGREES, DIFFERS, Entry, Item, Outcome, outcome, place, rms
from reproduction.judge import claimed, unknown
from reproduction.panel import Panel, curve

Array = NDArray[np.float64]
CORNER, IDEAL, SMOOTHING = 20.0, 50.0, 0.5
SHOWN = 2.0
SAME = 0.05
"""Of viscous and Coulomb friction: how near an estimate is to what the virtual rig has."""


def experiment(one: Experiment, quick: bool) -> Outcome:
    """Regressors before and after the filter, and the modelling error, of one experiment.

    ``quick``: changes nothing here.
    """
    log = bench_log(one.rig, one.frequencies, one.amplitudes)
    angle, torque, h = log.channel("angle"), log.channel("torque"), log.interval
    raw, filtered = _regressors(angle, h)
    kept = slice(round(0.5 / h), None)
    unit = causal_filter(torque, h, CORNER)[0]
    estimate = np.linalg.lstsq(filtered[kept], unit[kept], rcond=None)[0]
    smooth = _smooth_regressors(angle, h)
    error = smooth @ estimate - torque
    inside = slice(round(1.0 / h), -round(1.0 / h))
    share = rms(ideal_low_pass(error, h, IDEAL)[inside]) / rms(torque[inside])
    words = ", ".join(f"{value:.3g}" for value in estimate)
    noise = [rms(raw[kept, k] - filtered[kept, k]) / rms(filtered[kept, k]) for k in (0, 1)]
    items = [
        Item(
            id=f"figure-{one.regressors.replace('.', '-')}",
            source=f"Fig. {one.regressors}: regressors before and after the filter",
            printed="a filter with zeta = 1 and 20 Hz reduces the noise of the encoder",
            computed=(
                f"rms of what the filter takes: acceleration {noise[0]:.2g}, speed {noise[1]:.2g} of "
                "the filtered one"
            ),
            unit="",
            deviation=None,
            verdict=AGREES if noise[0] > noise[1] else DIFFERS,
            note="second differences of 2,600 counts are mostly noise; from a virtual log",
        ),
        claimed(
            f"figure-{one.error.replace('.', '-')}",
            f"Fig. {one.error}: modelling error",
            "quite small compared to the applied torque",
            f"rms {100 * share:.2g} % of the torque's, with J, b, c, d = {words}",
            share < 0.25,
            otherwise=(DIFFERS, "friction that sticks has no tanh(0.5 w); see the regressor's erratum"),
            note=f"what is left is friction that sticks beside tanh(0.5 w). {place('erratum-4-8-smoothing')}",
        ),
    ]
    time = log.time
    first = time < SHOWN
    names = ("acceleration [rad/s^2]", "speed [rad/s]")
    panels = [
        Panel(
            figure=f"Fig. {one.regressors}",
            title=f"{name}, unfiltered and filtered",
            x="time [s]",
            y=name,
            curves=(
                curve("unfiltered", time[first], raw[first, k]),
                curve("filtered", time[first], filtered[first, k]),
            ),
        )
        for k, name in enumerate(names)
    ]
    middle = (time > 10.0) & (time < 10.0 + SHOWN)
    panels.append(
        Panel(
            figure=f"Fig. {one.error}",
            title="Modelling error beside the torque",
            x="time [s]",
            y="torque [N m]",
            curves=(
                curve("torque", time[middle], torque[middle]),
                curve("error", time[middle], ideal_low_pass(error, h, IDEAL)[middle]),
            ),
        )
    )
    return outcome(items, panels)


def _regressors(angle: Array, h: float) -> tuple[Array, Array]:
    """Columns of (4.9), by plain differences and through the filter of (4.1)."""
    speed, acceleration = np.gradient(angle, h), np.gradient(np.gradient(angle, h), h)
    friction = np.tanh(SMOOTHING * speed)
    ones = -np.ones_like(angle)
    raw = np.column_stack([acceleration, speed, friction, ones])
    through = causal_filter(angle - angle[0], h, CORNER)
    columns = [through[2], through[1]]
    columns += [causal_filter(column, h, CORNER)[0] for column in (friction, ones)]
    return raw, np.column_stack(columns)


def _smooth_regressors(angle: Array, h: float) -> Array:
    """Columns of (4.9) through the ideal filter of 50 Hz."""
    speed = ideal_low_pass(difference(angle, h), h, IDEAL)
    acceleration = ideal_low_pass(difference(speed, h), h, IDEAL)
    return np.column_stack([acceleration, speed, np.tanh(SMOOTHING * speed), -np.ones_like(angle)])


def section_4_2(quick: bool) -> Outcome:
    """The settings of the estimation.

    ``quick``: changes nothing here.
    """
    test = BENCH_TESTS[1]
    exact = bench_log(test, (3.0, 4.0), (0.1, 0.1))
    angle, h = exact.channel("angle"), exact.interval
    _, filtered = _regressors(angle, h)
    kept = slice(round(0.5 / h), None)
    unit = causal_filter(exact.channel("torque"), h, CORNER)[0]
    _, viscous, coulomb, _ = np.linalg.lstsq(filtered[kept], unit[kept], rcond=None)[0]
    settings = "1 kHz, 20 Hz, zeta = 1, 50 Hz, 70 s, 55 s, amplitudes of 0.05 and 0.1 V"
    return outcome(
        [
            unknown(
                "section-4-2-settings",
                "Section 4.2: sampling, filters, duration, amplitudes",
                settings,
                "",
                "settings of the experiments: they are used as they are",
            ),
            claimed(
                "section-4-2-tanh",
                "(4.8): tanh(0.5 w) as regressor of Coulomb friction",
                "a smooth approximation of the signum function, K = 0.5",
                f"of b = {test.viscous} and c = {test.coulomb} that stick, 3 + 4 Hz: b = {viscous:.4f} N m "
                f"s, c = {coulomb:.3f} N m",
                abs(viscous / test.viscous - 1.0) < SAME and abs(coulomb / test.coulomb - 1.0) < SAME,
                otherwise=(
                    "erratum",
                    "a wide smoothing: b and c have a meaning only beside it. "
                    f"{place('erratum-4-8-smoothing')}",
                ),
            ),
        ]
    )


def _of(one: Experiment) -> Callable[[bool], Outcome]:
    return partial(experiment, one)


ENTRIES = (
    Entry(name="section-4-2", chapter="4", covers=("Section 4.2",), compute=section_4_2),
    *(
        Entry(
            name=f"figures-{one.regressors.replace('.', '-')}-{one.error.replace('.', '-')}",
            chapter="4",
            covers=(f"Fig. {one.regressors}", f"Fig. {one.error}"),
            compute=_of(one),
        )
        for one in EXPERIMENTS
    ),
    Entry(name="table-4-1", chapter="4", covers=("Table 4.1",), compute=table_4_1),
    Entry(name="table-4-2", chapter="4", covers=("Table 4.2",), compute=table_4_2),
)
