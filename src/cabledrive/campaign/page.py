"""The page of a campaign: yield, drivers of failure, scatter and parallel coordinates, worst machines."""

import json
from base64 import b64encode
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from cabledrive.campaign.results import FEWEST_ROWS, Results, open_results, tolerance, yield_interval
from cabledrive.campaign.rows import WORDS
from cabledrive.campaign.spec import DRIVE, settings_of
from cabledrive.parameters import InputRefused, drive_text
from cabledrive.parameters.drive_file import drive_from_text
from cabledrive.parameters.keys import varied_together
from cabledrive.report.blocks import Block, Chapter, Figure, Paragraph, Table, table
from cabledrive.report.page import page_of

MOST_POINTS = 4000
"""Drawn; of more rows a sample at random, those that are not done first."""
MOST_COLUMNS = 8
"""Numbers of one output that are drawn."""
WORST = 10
MOST_REASONS = 8
QUANTILES = (0.0, 0.01, 0.5, 0.99, 1.0)


Judged = dict[str, Any] | None
"""What `tolerance` gives; None without goals."""
METHOD = "rows by their number alone; yield by Clopper and Pearson; a key with the others as they are"
CHOICE = Markup(
    '<div class="choice"><label>across <select id="x"></select></label> '
    '<label>up <select id="y"></select></label></div>'
    '<p class="readout" id="readout" aria-live="polite">Point at a row to read it.</p>'
)
INTERVALS = Markup(
    '<p class="readout" id="line" aria-live="polite">Drag along an axis to choose an interval; point at a '
    'line to read it.</p><p class="choice"><span id="chosen" aria-live="polite"></span> '
    '<button type="button" id="all">all rows</button></p>'
)


def campaign_page(store: str | Path, goals: Sequence[str] = ()) -> str:
    """Set the page of a campaign against goals such as "peak_error_deg < 0.05 deg" as one HTML file.

    Refused if the store is none, or a goal is not understood.
    """
    results = open_results(store)
    judged = tolerance(store, list(goals), target=0.99) if goals else None
    columns, counts = _columns(results), results.counts
    identity = results.attributes["campaign"]
    hashes = [(k.removeprefix("drive."), str(v)) for k, v in identity.items() if k.startswith("drive.")]
    about = [(k, str(v)) for k, v in identity.items() if not k.startswith("drive.")]
    shown = [(k, f"{text[:77]}..." if len(text) > 80 else text) for k, text in about]
    chapters = (
        Chapter(title="Yield", anchor="yield", blocks=(*_yield(judged, counts), *_reasons(results))),
        Chapter(title="Rows", anchor="rows", blocks=_charts(results, columns, judged)),
        Chapter(title="Outputs", anchor="outputs", blocks=(_quantiles(results, columns),)),
        Chapter(title="Worst machines", anchor="worst", blocks=(_machines(results, columns, judged),)),
        Chapter(
            title="The campaign",
            anchor="campaign",
            blocks=(table("What was varied and computed.", "key | value", shown),),
            methods=(METHOD,),
        ),
    )
    done = f"{counts['done']} of {counts['rows']} rows computed: {counts['refused']} refused"
    return page_of(
        f"Campaign {Path(store).name}", f"{done}, {counts['failed']} not completed.", chapters, hashes
    )


def _yield(judged: Judged, counts: Mapping[str, int]) -> Iterator[Block]:
    """The share of the rows that hold the goals, and what each key does to it."""
    if judged is None:
        few = f" A yield needs at least {FEWEST_ROWS} rows." if counts["done"] < FEWEST_ROWS else ""
        yield Paragraph(
            text=Markup(
                "No goal is given: add <code>--goal &quot;peak_error_deg &lt; 0.05 deg&quot;</code>, with an "
                "output of this store."
            )
            + few
        )
        return
    goals = Markup(" and ").join(Markup("<code>{}</code>").format(goal.text) for goal in judged["goals"])
    yield Paragraph(
        text=Markup(
            "{:.2f} % of {} rows hold {} ({}). Rows that were refused or not completed count as misses."
        ).format(100 * judged["yield"], judged["rows"], goals, yield_interval(judged))
    )
    rows = [
        (
            _headed(key, one["unit"]),
            "none"
            if one["tightened"] is None
            else f"{_short(one['tightened']['low'])} to {_short(one['tightened']['high'])}",
            _short(one["low"]),
            _short(one["high"]),
            f"{100 * one['share_at_low']:.1f} %",
            f"{100 * one['share_at_high']:.1f} %",
        )
        for key, one in judged["keys"].items()
    ]
    yield table(
        "What limits the rest: yield of the twentieth of the rows at each end of a key, and the widest "
        f"interval of that key alone in which {100 * judged['target']:.4g} % hold.",
        "key | interval that is enough | from [] | to [] | yield at the low end [] | at the high end []",
        rows,
    )


def _charts(results: Results, columns: dict[str, NDArray[np.float64]], judged: Judged) -> tuple[Block, ...]:
    """Points of two columns, lines across all, and the script that draws them."""
    folder = resources.files("cabledrive.campaign") / "templates"
    text = {
        name: (folder / name).read_text(encoding="utf-8")
        for name in ("charts.css", "charts.js", "parallel.js")
    }
    hold = " and hold every goal" if judged else ""
    data = _data(results, columns, judged).replace("<", "\\u003c")
    return (
        Figure(
            name="scatter",
            alt="Rows of the campaign as points over two columns that are chosen above.",
            caption=f"Blue: rows that are done{hold}; red: the others. At most {MOST_POINTS} rows are drawn, "
            "a sample of more.",
            switch=Markup("<style>{}</style>").format(Markup(text["charts.css"])) + CHOICE,
            drawing=Markup('<div class="chart" id="chart"></div>'),
        ),
        Figure(
            name="lines",
            alt="Each row as a line across its keys and outputs.",
            caption="Colours as above, columns with one value left out; rows outside a chosen interval are "
            "grey. A click on an axis lets its interval go.",
            switch=INTERVALS,
            drawing=Markup('<div class="parallel" id="parallel"></div>'),
        ),
        Paragraph(
            text=Markup('<script type="application/json" id="data">{}</script><script>{}{}</script>').format(
                Markup(data), Markup(text["charts.js"]), Markup(text["parallel.js"])
            )
        ),
    )


def _columns(results: Results) -> dict[str, NDArray[np.float64]]:
    """Keys and the first numbers of each output, shape (rows,) each, by name."""
    found = {key: np.asarray(results.group[key][:]) for key in results.keys}
    for name, shape in results.outputs.items():
        if len(shape) > 1:
            continue
        places = [f"[{i}]" for i in range(min(shape[0], MOST_COLUMNS))] if shape else [""]
        found |= {name + place: results.output(name + place) for place in places}
    return found


def _reasons(results: Results) -> Iterator[Table]:
    """What ended rows, most frequent first: status, rows, an example of the line."""
    bad = np.flatnonzero(results.code > 0)
    if not bad.size:
        return
    lines = results.group["reason"][:]
    kinds: Counter[tuple[int, str]] = Counter()
    examples: dict[tuple[int, str], str] = {}
    for row in bad:
        line = str(lines[row])
        kind = (int(results.code[row]), "".join(c for c in line if not (c.isdigit() or c in ".e-+")))
        kinds[kind] += 1
        examples.setdefault(kind, line)
    rows = [(WORDS[kind[0]], examples[kind], str(count)) for kind, count in kinds.most_common(MOST_REASONS)]
    yield table("Why rows have no result, with an example of each kind.", "status | example | rows []", rows)


def _quantiles(results: Results, columns: dict[str, NDArray[np.float64]]) -> Table:
    """Quantiles of each output over the rows that have it."""
    rows = []
    for name, values in columns.items():
        kept = values[np.isfinite(values) & (results.code == 0)]
        if name not in results.keys and kept.size:
            rows.append(
                (_headed(name, results.unit(name)), *(_short(v) for v in np.quantile(kept, QUANTILES)))
            )
    heads = "output | smallest [] | 1 % [] | median [] | 99 % [] | largest []"
    return table("Over the rows that are done.", heads, rows)


def _headed(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit not in ("1", "") else name


def _machines(results: Results, columns: dict[str, NDArray[np.float64]], judged: Judged) -> Table:
    """Rows that miss a goal by most; without a goal those farthest from the median of the first output."""
    outputs = [name for name in columns if name not in results.keys]
    distance = np.full(results.code.size, np.nan)
    if judged is not None:
        distance = np.max([_excess(results, goal) for goal in judged["goals"]], axis=0)
    elif outputs and np.isfinite(columns[outputs[0]]).any():
        distance = np.abs(columns[outputs[0]] - np.nanmedian(columns[outputs[0]]))
    known = np.flatnonzero(np.isfinite(distance) & (results.code == 0))
    worst = known[np.argsort(-distance[known], kind="stable")][:WORST]
    names = [*results.keys, *outputs]
    rows = [
        (str(row), _link(results, int(row)), *(_short(columns[name][row]) for name in names)) for row in worst
    ]
    far = "Farthest beyond a goal" if judged else "Farthest from the median of the first output"
    heads = " | ".join(("row", "file", *(f"{name} []" for name in names)))
    return table(f"{far}; each with its drive file.", heads, rows)


def _excess(results: Results, goal: Any) -> NDArray[np.float64]:
    """How far each row lies beyond a limit, over the spread of the output."""
    values = results.output(goal.output)
    spread = float(np.nanstd(values)) or 1.0
    return np.asarray((values - goal.limit if goal.below else goal.limit - values) / spread)


def _link(results: Results, row: int) -> Markup:
    """The drive file of a row as a link that holds it; empty where its values make none."""
    files = results.attributes["drives"]
    values: dict[str, Any] = {}
    for key in results.attributes["varied"]:
        array = results.group[key]
        values[key] = {"f": float, "i": bool}.get(array.dtype.kind, str)(array[row])
    name = values.get(DRIVE, next(iter(files)))
    try:
        drive = varied_together(drive_from_text(files[name]), settings_of(values, ""))
    except InputRefused:
        return Markup("")
    file = "data:application/toml;base64," + b64encode(drive_text(drive).encode()).decode()
    return Markup('<a download="row-{0}.toml" href="{1}">row-{0}.toml</a>').format(row, file)


def _data(results: Results, columns: dict[str, NDArray[np.float64]], judged: Judged) -> str:
    """Points and lines of the figures: a sample of the rows, and whether each holds the goals."""
    rows = np.flatnonzero(results.code >= 0)
    if rows.size > MOST_POINTS:
        bad = rows[results.code[rows] > 0][: MOST_POINTS // 4]
        rest = np.setdiff1d(rows, bad)
        drawn = np.random.default_rng(0).choice(rest, MOST_POINTS - bad.size, replace=False)
        rows = np.sort(np.concatenate((bad, drawn)))
    good = results.code[rows] == 0
    if judged is not None:
        good &= np.all([goal.holds(results)[rows] for goal in judged["goals"]], axis=0)
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
