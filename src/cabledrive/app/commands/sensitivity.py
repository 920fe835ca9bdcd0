"""`cabledrive sensitivity`: which keys a result of a sweep depends on."""

from collections.abc import Iterator
from typing import Any

import click

from cabledrive.app.options import argument, opt, subcommand
from cabledrive.app.results import Answer, provenance

SOBOL = "Saltelli (first) and Jansen (total) estimators, percentile bootstrap over groups"
MORRIS = "elementary effects of Morris' paths, percentile bootstrap over paths"


@subcommand("cabledrive sensitivity campaign.zarr --output 'longitudinal_hz[0]'")
def command(
    store: str = argument("STORE.zarr", type=click.Path()),
    output: str = opt("NAME", 'Such as "longitudinal_hz[0]".', required=True),
    seed: int = opt("count", "Of the bootstrap.", 0),
) -> Answer:
    """Sobol indices of an output of STORE.zarr, first and total; of a design of kind morris, effects."""
    import numpy as np

    from cabledrive.campaign.results import influence

    found = influence(store, output, generator=np.random.default_rng(seed))
    screened = "effects" in found
    lines = [
        f"{output}: change per whole interval of each key, over {found['groups']} paths"
        if screened
        else f"{output}: mean {found['mean']:.6g}, standard deviation {found['standard_deviation']:.4g}; "
        f"{found['groups']} groups of {found['rows'] // found['groups']} rows"
    ]
    lines[0] += f", {found['groups_left_out']} left out" if found["groups_left_out"] else ""
    lines += ["", *(_effects(found["effects"]) if screened else _indices(found["first"], found["total"]))]
    return Answer(
        data=found | {"confidence": 0.95},
        text="\n".join(lines),
        provenance=provenance(method=MORRIS if screened else SOBOL, seed=seed),
    )


def _indices(first: dict[str, Any], total: dict[str, Any]) -> Iterator[str]:
    yield f"{'key':<34} {'first':>7} {'95 % interval':>18} {'total':>8} {'95 % interval':>18}"
    for key, one in first.items():
        parts = [f"{i['value']:8.3f} {i['low']:8.3f} to {i['high']:6.3f}" for i in (one, total[key])]
        yield f"{key:<33} {' '.join(parts)}"


def _effects(effects: dict[str, Any]) -> Iterator[str]:
    yield f"{'key':<34} {'mean size':>10} {'95 % interval':>22} {'mean':>11} {'deviation':>10}"
    for key, effect in effects.items():
        size, mean, deviation = effect["mean_size"], effect["mean"], effect["deviation"]
        between = f"{size['low']:.4g} to {size['high']:.4g}"
        yield f"{key:<34} {size['value']:10.4g} {between:>22} {mean:11.4g} {deviation:10.4g}"
