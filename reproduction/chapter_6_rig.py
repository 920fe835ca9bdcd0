"""Figs. 6.11 to 6.29: the laws that follow; the entries of the rig."""

from collections.abc import Callable
from functools import partial

import numpy as np

from cabledrive.rig import Tracking
from reproduction.chapter_6_prose import prose
from reproduction.chapter_6_vibrating import model_1, model_2
from reproduction.item import DIFFERS, UNEXPLAINED, Entry, Item, Outcome, outcome, place
from reproduction.judge import claimed, not_comparable, unknown
from reproduction.panel import Panel, curve
from reproduction.rig_runs import ENCODER, LAWS, MOTION, Array, run, slower_rise

SEEDS, QUICK_SEEDS = 32, 4
FIGURES = {
    "darc-3": ("6.11", "6.12", "6.13", "6.14", ("6.15", "6.15", "6.16", "6.16")),
    "darc-4": ("6.17", "6.18", "6.19", "6.20", ("6.21", "6.21", "6.22", "6.22")),
    "backstepping": ("6.23", "6.24", "", "6.25", ("6.26", "6.26", "6.27", "6.27", "6.28", "6.28", "6.29")),
}

COUNTS_OF_ERROR = {
    "darc-3": ("about five times the encoder resolution", 4.5, 5.5),
    "darc-4": ("less than twice the encoder resolution", 0.0, 2.0),
}
"""What the print says of an accuracy in counts, and the counts that bear it out."""

BLAMED = ("darc-3", "backstepping")
"""Laws whose error the print puts down to the mode of the motor joint."""


def followed(law: str, quick: bool) -> Outcome:
    """The figures of one of the laws that follow: output, error, surface, torque, estimates.

    ``law``: a key of `LAWS`; ``quick``: fewer encoder phases.
    """
    _section, words, *_ = LAWS[law]
    runs = [run(law, seed=seed) for seed in range(QUICK_SEEDS if quick else SEEDS)]
    peaks = np.array([one.summary["peak_error_deg"] for one in runs])
    first = runs[0]
    items = _numbers(law, peaks, runs)
    output, error, surface, torques, estimates = FIGURES[law]
    head = f"Fig. {output}"
    degrees = np.degrees
    panels = [
        Panel(
            figure=head,
            title=f"reference and load; {MOTION}",
            x="time [s]",
            y="angle [deg]",
            curves=(
                curve("reference", first.time, degrees(first.reference)),
                curve("load", first.time, degrees(first.load_angle)),
            ),
        ),
        Panel(
            figure=f"Fig. {error}",
            title=f"error of the true load angle, {words}",
            x="time [s]",
            y="error [deg]",
            curves=(curve("error", first.time, degrees(first.error)),),
        ),
        Panel(
            figure=f"Fig. {torques}",
            title="torque",
            x="time [s]",
            y="torque [N m]",
            curves=(curve("torque", first.time, first.torque),),
        ),
    ]
    if surface:
        panels.append(
            Panel(
                figure=f"Fig. {surface}",
                title="sliding surface",
                x="time [s]",
                y="sigma",
                curves=(curve("sigma", first.time, first.sigma),),
            )
        )
        items.append(_surface(surface, first))
    start = 2 if surface else 1
    for number in range(first.estimates.shape[1]):
        figure = estimates[min(number, len(estimates) - 1)]
        panels.append(
            Panel(
                figure=f"Fig. {figure}",
                title=f"estimate of p{start + number}",
                x="time [s]",
                y=f"p{start + number}",
                curves=(curve("estimate", first.time, first.estimates[:, number]),),
            )
        )
    for figure in dict.fromkeys(estimates):
        items.append(_bounded(figure, runs))
    return outcome(items, panels)


def _numbers(law: str, peaks: Array, runs: list[Tracking]) -> list[Item]:
    section, words, printed, torque = LAWS[law]
    output, error, _, torques, _ = FIGURES[law]
    median, worst = float(np.median(peaks)), float(peaks.max())
    used = max(one.summary["peak_torque"] for one in runs)
    found = f"median of {len(peaks)} encoder phases, worst {worst:.3f} deg"
    anchor = place("erratum-maximum-torque")
    slack = place("erratum-slack-torque")
    return [
        claimed(
            f"figure-{output.replace('.', '-')}",
            f"Fig. {output}: desired trajectory and output, {words}",
            "the output follows the trajectory",
            f"largest error {100 * worst / 45:.2g} % of the angle",
            worst < 0.45,
            otherwise=(DIFFERS, "not explained"),
            note=MOTION,
        ),
        not_comparable(
            f"figure-{error.replace('.', '-')}-accuracy",
            f"Fig. {error}, Section {section}: tracking accuracy, {words}",
            printed,
            median,
            "deg",
            f"angle, rise and dwell of the print's pulse are lost; {found}; {MOTION}; a slower pulse: "
            f"{_slower(law)}",
        ),
        claimed(
            f"figure-{torques.replace('.', '-')}",
            f"Fig. {torques}, Section {section}: torque",
            f"below the maximum achievable value of {torque:g} N m",
            f"peak {used:.3f} N m",
            used < torque,
            otherwise=(DIFFERS, "not explained"),
            note=f"the value is the continuous rating, {anchor}; a span goes slack at 0.56 N m, {slack}",
        ),
        *([_resolution(law, median)] if law in COUNTS_OF_ERROR else []),
        *([_origin(law, runs)] if law in BLAMED else []),
    ]


def _resolution(law: str, median: float) -> Item:
    """What the print says of an accuracy in counts, against the accuracy that is computed."""
    words, low, high = COUNTS_OF_ERROR[law]
    section, _, printed, _ = LAWS[law]
    arithmetic = f"{printed:g} deg of the print are {printed / ENCODER:.1f} counts"
    return claimed(
        f"section-{section.replace('.', '-')}-resolution",
        f"Section {section}: accuracy over the resolution of the encoder",
        words,
        f"{median / ENCODER:.1f} counts of {ENCODER} deg",
        low < median / ENCODER < high,
        otherwise=(DIFFERS, f"another pulse than the print's, which is lost; {arithmetic}"),
        note=arithmetic,
    )


def _origin(law: str, runs: list[Tracking]) -> Item:
    """Whether the error comes from the mode left out: the same runs on a plant with a rigid motor joint."""
    section, words, *_ = LAWS[law]
    with_joint, without = (
        float(np.median([one.summary["rms_error_deg"] for one in some]))
        for some in (runs, [run(law, seed=seed, plant="model-3") for seed in range(len(runs))])
    )
    share = 1.0 - (without / with_joint) ** 2
    return claimed(
        f"section-{section.replace('.', '-')}-origin",
        f"Section {section}: origin of the tracking error, {words}",
        "most of the tracking error originates from the unmodeled higher-order mode of the motor joint",
        f"rms {with_joint:.4f} deg on Model 4, {without:.4f} deg on Model 3, whose joint is rigid: "
        f"{100 * share:.0f} % of the mean square go with the joint",
        share > 0.5,
        otherwise=(
            DIFFERS,
            "on the rig most of it is there with a rigid joint as well: friction, encoder counts and the "
            f"dampings that the law drops; {MOTION}",
        ),
        note=MOTION,
    )


def _slower(law: str) -> str:
    found = slower_rise(law, LAWS[law][2], QUICK_SEEDS)
    if found.startswith("not"):
        return f"{found}; {UNEXPLAINED}"
    dropped = place("erratum-6-39-damping")
    return f"{found}. The dampings that the law drops cost the rest: {dropped}"


def _surface(figure: str, found: Tracking) -> Item:
    size = float(np.max(np.abs(found.sigma)))
    why = f"the figure is lost and no value is printed; here its peak is {size:.3g}, computed as a curve"
    return unknown(f"figure-{figure.replace('.', '-')}", f"Fig. {figure}: sliding surface", None, "", why)


def _bounded(figure: str, runs: list[Tracking]) -> Item:
    inside = all(one.summary["estimates_within_bounds"] for one in runs)
    return claimed(
        f"figure-{figure.replace('.', '-')}",
        f"Fig. {figure}: online parameter estimates",
        "bounded by the projection; they need not converge",
        "within their bounds in every run" if inside else "outside their bounds",
        inside,
        otherwise=(DIFFERS, "not explained"),
        note="gains of the adaptation are not printed: those of this package are used. "
        f"{place('erratum-gains-6-3-to-6-6')}",
    )


def _of(law: str) -> Callable[[bool], Outcome]:
    return partial(followed, law)


def _covers(law: str) -> tuple[str, ...]:
    output, error, surface, torques, estimates = FIGURES[law]
    numbers = [output, error, surface, torques, *estimates]
    return tuple(dict.fromkeys(f"Fig. {number}" for number in numbers if number))


ENTRIES = (
    Entry(
        name="figures-6-5-to-6-8",
        chapter="6",
        covers=("Fig. 6.5", "Fig. 6.6", "Fig. 6.7", "Fig. 6.8"),
        compute=model_1,
    ),
    Entry(name="figures-6-9-6-10", chapter="6", covers=("Fig. 6.9", "Fig. 6.10"), compute=model_2),
    *(
        Entry(
            name=f"figures-{law}",
            chapter="6",
            covers=(*_covers(law), f"Section {LAWS[law][0]}"),
            compute=_of(law),
        )
        for law in LAWS
    ),
    Entry(name="sections-6-3-to-6-7", chapter="6", covers=("Section 6.3", "Section 6.4"), compute=prose),
)
