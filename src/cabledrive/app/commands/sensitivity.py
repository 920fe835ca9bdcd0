"""`cabledrive sensitivity`: which keys a result of a sweep depends on."""

from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from cabledrive.app.options import Subcommand, answering, option
from cabledrive.app.results import Answer, provenance

if TYPE_CHECKING:
    from cabledrive.campaign.results import Screening, Sensitivity

SOBOL = "Saltelli (first) and Jansen (total) estimators, percentile bootstrap over groups"
MORRIS = "elementary effects of Morris' paths, percentile bootstrap over paths"


@click.command(
    cls=Subcommand,
    example="cabledrive sensitivity campaign.zarr --output 'longitudinal_hz[0]'",
    short_help="Sobol indices of a result of a sweep, or Morris' effects, with intervals.",
)
@answering
@click.argument("store", metavar="STORE.zarr", type=click.Path())
@option("--output", "NAME", 'Such as "longitudinal_hz[0]".', required=True)
@option("--seed", "count", "Of the bootstrap.", 0)
def command(store: str, output: str, seed: int) -> Answer:
    """Sobol indices of an output of STORE.zarr, first and total; of a design of kind morris, effects."""
    import numpy as np

    from cabledrive.campaign.results import is_screening, screening, sensitivity

    generator = np.random.default_rng(seed)
    if is_screening(store):
        effects = screening(store, output, generator=generator)
        data, text, method = asdict(effects), _effects_text(effects), MORRIS
    else:
        indices = sensitivity(store, output, generator=generator)
        data, text, method = asdict(indices), _indices_text(indices), SOBOL
    return Answer(
        data=data | {"confidence": 0.95}, text=text, provenance=provenance(method=method, seed=seed)
    )


def _indices_text(found: "Sensitivity") -> str:
    lines = [
        f"{found.output}: mean {found.mean:.6g}, standard deviation {found.standard_deviation:.4g}",
        f"{found.groups} groups of {found.rows // found.groups} rows"
        + (f", {found.groups_left_out} left out" if found.groups_left_out else ""),
        "",
        f"{'key':<34} {'first':>7} {'95 % interval':>18} {'total':>8} {'95 % interval':>18}",
    ]
    for key, first in found.first.items():
        total = found.total[key]
        lines.append(
            f"{key:<34} {first.value:7.3f} {f'{first.low:.3f} to {first.high:.3f}':>18} "
            f"{total.value:8.3f} {f'{total.low:.3f} to {total.high:.3f}':>18}"
        )
    return "\n".join(lines)


def _effects_text(found: "Screening") -> str:
    lines = [
        f"{found.output}: change per whole interval of each key, over {found.groups} paths"
        + (f", {found.groups_left_out} left out" if found.groups_left_out else ""),
        "",
        f"{'key':<34} {'mean size':>10} {'95 % interval':>22} {'mean':>11} {'deviation':>10}",
    ]
    for key, effect in found.effects.items():
        size = effect.mean_size
        lines.append(
            f"{key:<34} {size.value:10.4g} {f'{size.low:.4g} to {size.high:.4g}':>22} "
            f"{effect.mean:11.4g} {effect.deviation:10.4g}"
        )
    return "\n".join(lines)
