"""The page of a campaign: yield, drivers of failure, scatter and parallel coordinates, worst machines."""

import json
from base64 import b64encode
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from cabledrive.campaign.keys import DRIVE, drive_with, settings_of, si_tables
from cabledrive.campaign.results import Results, open_results
from cabledrive.campaign.tolerance import FEWEST_ROWS, Tolerance, tolerance
from cabledrive.parameters import InputRefused, drive_text
from cabledrive.parameters.tables import drive_from_tables
from cabledrive.parameters.toml_values import toml_of
from cabledrive.report.picture import theme_css
from cabledrive.report.typesetting import typeset

MOST_POINTS = 4000
"""Drawn; of more rows a sample at random, those that are not done first."""
MOST_COLUMNS = 8
"""Numbers of one output that are drawn."""
WORST = 10
MOST_REASONS = 8
QUANTILES = (0.0, 0.01, 0.5, 0.99, 1.0)
STATUS_WORDS = {0: "done", 1: "defect", 2: "refused", 3: "not completed"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Machine:
    """One of the worst rows."""

    row: int
    words: tuple[str, ...]  # values of the keys, then of the outputs
    link: str  # its drive file, as a link that holds it; empty where its values make none


def campaign_page(store: str | Path, goals: Sequence[str] = ()) -> str:
    """Set the page of a campaign against goals such as "peak_error_deg < 0.05 deg" as one HTML file.

    Refused if the store is none, or a goal is not understood.
    """
    from cabledrive.parameters.version import __version__

    results = open_results(store)
    judged = tolerance(store, list(goals), target=0.99) if goals else None
    columns = _columns(results)
    counts = results.counts
    folder = resources.files("cabledrive.campaign") / "templates"
    css = (resources.files("cabledrive.report") / "templates" / "report.css").read_text(encoding="utf-8")
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["short"] = _short
    html = environment.from_string((folder / "campaign.html").read_text(encoding="utf-8")).render(
        name=Path(store).name,
        counts=counts,
        identity=results.attributes["campaign"],
        judged=judged,
        reasons=_reasons(results),
        quantiles=_quantiles(results, columns),
        machines=_machines(results, columns, judged),
        headings=[*results.keys, *(name for name in columns if name not in results.keys)],
        units={name: results.unit(name) for name in columns},
        css=Markup(theme_css() + css),
        data=Markup(_data(results, columns, judged).replace("<", "\\u003c")),
        parallel=Markup((folder / "parallel.js").read_text(encoding="utf-8")),
        version=__version__,
        few=counts["done"] < FEWEST_ROWS,
    )
    return typeset(html)


def _columns(results: Results) -> dict[str, NDArray[np.float64]]:
    """Keys and the first numbers of each output, shape (rows,) each, by name."""
    found = {key: results.key(key) for key in results.keys}
    for name, shape in results.outputs.items():
        if len(shape) > 1:
            continue
        places = [f"[{i}]" for i in range(min(shape[0], MOST_COLUMNS))] if shape else [""]
        found |= {name + place: results.output(name + place) for place in places}
    return found


def _reasons(results: Results) -> list[tuple[str, int, str]]:
    """What ended rows, most frequent first: status, rows, an example of the line."""
    bad = np.flatnonzero(results.code > 0)
    if not bad.size:
        return []
    lines = results.group["reason"][:]
    kinds: Counter[tuple[int, str]] = Counter()
    examples: dict[tuple[int, str], str] = {}
    for row in bad:
        line = str(lines[row])
        kind = (int(results.code[row]), "".join(c for c in line if not (c.isdigit() or c in ".e-+")))
        kinds[kind] += 1
        examples.setdefault(kind, line)
    common = kinds.most_common(MOST_REASONS)
    return [(STATUS_WORDS[kind[0]], count, examples[kind]) for kind, count in common]


def _quantiles(results: Results, columns: dict[str, NDArray[np.float64]]) -> list[tuple[str, str, list[str]]]:
    """Name, unit and quantiles of each output over the rows that have it."""
    rows = []
    for name, values in columns.items():
        kept = values[np.isfinite(values) & (results.code == 0)]
        if name not in results.keys and kept.size:
            rows.append((name, results.unit(name), [_short(v) for v in np.quantile(kept, QUANTILES)]))
    return rows


def _machines(
    results: Results, columns: dict[str, NDArray[np.float64]], judged: Tolerance | None
) -> list[Machine]:
    """Rows that miss a goal by most; without a goal those farthest from the median of the first output."""
    outputs = [name for name in columns if name not in results.keys]
    if judged is not None:
        distance = np.max([_excess(results, goal) for goal in judged.goals], axis=0)
    elif outputs:
        values = columns[outputs[0]]
        distance = np.abs(values - np.nanmedian(values)) if np.isfinite(values).any() else values
    else:
        return []
    known = np.flatnonzero(np.isfinite(distance) & (results.code == 0))
    worst = known[np.argsort(-distance[known], kind="stable")][:WORST]
    return [
        Machine(
            row=int(row),
            words=tuple(_short(columns[name][row]) for name in [*results.keys, *outputs]),
            link=_file_of(results, int(row)),
        )
        for row in worst
    ]


def _excess(results: Results, goal: Any) -> NDArray[np.float64]:
    """How far each row lies beyond a limit, over the spread of the output."""
    values = results.output(goal.output)
    spread = float(np.nanstd(values)) or 1.0
    return np.asarray((values - goal.limit if goal.below else goal.limit - values) / spread)


def _file_of(results: Results, row: int) -> str:
    """The drive file of a row as a link."""
    files = results.attributes["drives"]
    values: dict[str, Any] = {}
    for key in results.attributes["varied"]:
        value = results.group[key][row]
        kind = results.group[key].dtype.kind
        values[key] = float(value) if kind == "f" else bool(value) if kind == "i" else str(value)
    name = values.get(DRIVE, next(iter(files)))
    try:
        base = drive_from_tables(toml_of(files[name].encode()))
        drive = drive_with(base, si_tables(base), settings_of(values, ""))
    except InputRefused:
        return ""
    return "data:application/toml;base64," + b64encode(drive_text(drive).encode()).decode()


def _data(results: Results, columns: dict[str, NDArray[np.float64]], judged: Tolerance | None) -> str:
    """Points and lines of the figures: a sample of the rows, and whether each holds the goals."""
    rows = np.flatnonzero(results.code >= 0)
    if rows.size > MOST_POINTS:
        bad = rows[results.code[rows] > 0][: MOST_POINTS // 4]
        rest = np.setdiff1d(rows, bad)
        drawn = np.random.default_rng(0).choice(rest, MOST_POINTS - bad.size, replace=False)
        rows = np.sort(np.concatenate((bad, drawn)))
    good = results.code[rows] == 0
    if judged is not None:
        good &= np.all([goal.holds(results)[rows] for goal in judged.goals], axis=0)
    return json.dumps(
        {
            "rows": rows.tolist(),
            "good": good.astype(int).tolist(),
            "keys": list(results.keys),
            "units": {name: results.unit(name) for name in columns},
            "columns": {
                name: [float(f"{v:.6g}") if np.isfinite(v) else None for v in values[rows]]
                for name, values in columns.items()
            },
        },
        allow_nan=False,
    )


def _short(value: float) -> str:
    return f"{value:.5g}" if np.isfinite(value) else "-"
