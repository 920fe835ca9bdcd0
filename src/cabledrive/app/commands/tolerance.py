"""`cabledrive tolerance`: the yield of a campaign against goals, and which key must be tighter."""

import click

from cabledrive.app.options import argument, opt, saves_answer, subcommand
from cabledrive.app.results import Answer, provenance

METHOD = "share of the rows; conditional yield in twenty parts along each key; Clopper-Pearson, 95 %"


@subcommand(
    "cabledrive tolerance campaign.zarr --goal 'longitudinal_hz[0] > 5.5 Hz' --target 0.95", (saves_answer,)
)
def command(
    store: str = argument("STORE.zarr", type=click.Path()),
    goals: tuple[str, ...] = opt("GOAL", 'Such as "peak_error_deg < 0.05 deg"; repeatable.', multiple=True),
    target: float = opt(float, "Yield that is wanted.", 0.99, metavar="SHARE"),
) -> Answer:
    """Yield of the rows of STORE.zarr against every --goal, and the intervals of keys that would raise it."""
    from cabledrive.campaign.results import YIELD, tolerance, yield_interval

    found = tolerance(store, list(goals), target=target)
    words = " and ".join(goal.text for goal in found["goals"])
    lines = [
        f"{100 * found['yield']:.2f} % of {found['rows']} rows hold {words} ({yield_interval(found)})",
        *(f"  {count} rows miss {text}" for text, count in found["missed"].items() if count),
    ]
    if found["refused"] or found["failed"]:
        lost = f"{found['refused']} rows were refused, {found['failed']} not completed"
        lines.append(f"  {lost}: counted as misses")
    lines += ["", f"for a yield of {100 * target:.4g} %, one key alone:"]
    for key, one in found["keys"].items():
        unit, tight = "" if one["unit"] == "1" else f" {one['unit']}", one["tightened"]
        now = f"{one['low']:.5g} to {one['high']:.5g}{unit}"
        then = tight and (
            f"{tight['low']:.5g} to {tight['high']:.5g}{unit} "
            f"({100 * tight['share']:.4g} % of {tight['rows']} rows)"
        )
        lines.append(f"  {key:<32} {now}: {then or 'not by this key alone'}")
    listed = [{"goal": goal.text, "output": goal.output, "limit": goal.limit} for goal in found["goals"]]
    data = YIELD(found | {"goals": listed})
    return Answer(data=data, text="\n".join(lines), provenance=provenance(method=METHOD))
