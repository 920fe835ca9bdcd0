"""Time histories that answer to the pointer: runs of the rig, logs with their modelling error, the cable."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.regressor_curves import RegressorCurves
from cabledrive.report.blocks import Text
from cabledrive.report.plot import Panel, Plot, Series
from cabledrive.rig import Tracking
from cabledrive.simulation import SimulationResult

Array = NDArray[np.float64]
BINS = 250
COLOURS = ("blue", "orange", "green", "purple", "ochre", "red", "ink")
SPANS = {"upper": "blue", "lower": "orange"}


def time_plot(name: str, time: Array, panels: Sequence[Panel], *, alt: str, caption: Text) -> Plot:
    """A plot over time of as few instants as keep every peak of every curve.

    ``time``, shape (p,) [s].
    """
    curves = [series.values for panel in panels for series in panel.series]
    kept = instants(curves, time.size)
    thin = [
        Panel(
            title=panel.title,
            unit=panel.unit,
            series=tuple(
                Series(name=s.name, values=s.values[kept], colour=s.colour, dashed=s.dashed)
                for s in panel.series
            ),
        )
        for panel in panels
    ]
    return Plot(
        name=name, alt=alt, caption=caption, points=time[kept], along="time", unit="s", panels=tuple(thin)
    )


def instants(curves: Sequence[Array], count: int, bins: int = BINS) -> NDArray[np.intp]:
    """Which of ``count`` instants to show: both ends, and in each bin the extremes of each curve."""
    if count <= 2 * bins:
        return np.arange(count)
    kept = {0, count - 1}
    for first, last in pairwise(np.linspace(0, count, bins + 1).astype(int)):
        for curve in curves:
            part = curve[first:last]
            kept |= {first + int(np.argmin(part)), first + int(np.argmax(part))}
    return np.array(sorted(kept))


def errors_plot(name: str, runs: Sequence[Tracking], *, alt: str, caption: Text) -> Plot:
    """Error of the load over time, a panel for each run, with the bound where there is one."""
    panels = [
        Panel(
            title=f"{run.summary['controller']}, at most {run.summary['peak_error_deg']:.3f} deg",
            unit="deg",
            series=_error(run, colour),
        )
        for run, colour in zip(runs, COLOURS, strict=False)
    ]
    return time_plot(name, runs[0].time, panels, alt=alt, caption=caption)


def _error(run: Tracking, colour: str, largest_bound: float = 0.3) -> tuple[Series, ...]:
    """The error and, where it does not dwarf the error, the bound [deg]."""
    series = [Series(name="error", values=np.degrees(run.error), colour=colour)]
    if run.bound is not None and np.degrees(run.bound.max()) < largest_bound:
        bound = np.degrees(run.bound)
        series += [
            Series(name=words, values=sign * bound, colour="quiet", dashed=True)
            for words, sign in (("bound", 1.0), ("its negative", -1.0))
        ]
    return tuple(series)


def record_plot(name: str, run: Tracking, surface: str, *, alt: str, caption: Text) -> Plot:
    """Reference and output, error, surface, torque and estimates of one run."""
    low, high = run.estimate_bounds
    first = 1 if len(low) == 7 else 2
    shares = (run.estimates - low) / np.where(high > low, high - low, 1.0)
    panels = [
        Panel(
            title="Angle",
            unit="deg",
            series=(
                Series(name="reference", values=np.degrees(run.reference), colour="quiet", dashed=True),
                Series(name="load", values=np.degrees(run.load_angle)),
            ),
        ),
        Panel(title="Error", unit="deg", series=_error(run, "blue", np.inf)),
        Panel(
            title=f"{surface} over its largest value",
            unit="1",
            series=(Series(name="surface", values=run.sigma / np.abs(run.sigma).max()),),
        ),
        Panel(title="Torque", unit="N m", series=(Series(name="torque", values=run.torque),)),
        Panel(
            title="Estimates within their bounds, 0 to 1",
            unit="1",
            series=tuple(
                Series(name=f"p{first + i}", values=share, colour=COLOURS[i % len(COLOURS)])
                for i, share in enumerate(shares.T)
            ),
        ),
    ]
    return time_plot(name, run.time, panels, alt=alt, caption=caption)


def vibrations_plot(name: str, runs: Sequence[tuple[str, Tracking]], *, alt: str, caption: Text) -> Plot:
    """Deviation of drive pulley and load from the reference over time, a panel for each run."""
    panels = [
        Panel(
            title=words,
            unit="deg",
            series=tuple(
                Series(name=part, values=np.degrees(run.angles[:, inertia] - run.reference), colour=colour)
                for part, inertia, colour in (("drive pulley", -2, "orange"), ("load", -1, "blue"))
            ),
        )
        for words, run in runs
    ]
    return time_plot(name, runs[0][1].time, panels, alt=alt, caption=caption)


def regressors_plot(
    name: str, curves: RegressorCurves, *, linear: bool = False, alt: str, caption: Text
) -> Plot:
    """Acceleration, speed and friction regressor, filtered and not; torque and modelling error."""
    length = "m" if linear else "rad"
    rows = (("Acceleration", f"{length}/s^2"), ("Speed", f"{length}/s"), ("Friction regressor", "1"))
    panels = [
        Panel(
            title=title,
            unit=unit,
            series=(
                Series(name="unfiltered", values=curves.unfiltered[k], colour="quiet"),
                Series(name="filtered", values=curves.filtered[k]),
            ),
        )
        for k, (title, unit) in enumerate(rows)
    ]
    pushed = (
        Series(name="measured", values=curves.torque, colour="quiet"),
        Series(name="modelling error", values=curves.error, colour="orange"),
    )
    panels.append(Panel(title="Force" if linear else "Torque", unit="N" if linear else "N m", series=pushed))
    return time_plot(name, curves.time, panels, alt=alt, caption=caption)


def histories_plot(name: str, result: SimulationResult, *, alt: str, caption: Text) -> Plot:
    """Load angle, and the midpoints of the spans in both planes."""
    load = Series(name="load pulley", values=np.degrees(result.load_angle), colour="ink")
    panels = [Panel(title="Load angle", unit="deg", series=(load,))]
    for span in result.spans:
        moved = 1e3 * result.midpoint(span)
        series = [Series(name="w", values=moved[:, 2], colour=SPANS[span])]
        if np.any(moved[:, 1]):
            series.append(Series(name="v", values=moved[:, 1], colour="quiet"))
        panels.append(Panel(title=f"Midpoint of the {span} span", unit="mm", series=tuple(series)))
    return time_plot(name, result.time, panels, alt=alt, caption=caption)
