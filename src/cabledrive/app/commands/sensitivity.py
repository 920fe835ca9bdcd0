"""`cabledrive sensitivity`: which keys the variance of a result comes from."""

from dataclasses import asdict

import click

from cabledrive.app.options import Subcommand, answering
from cabledrive.app.results import Answer, provenance

METHOD = "Saltelli (first) and Jansen (total) estimators, percentile bootstrap over groups"


@click.command(
    cls=Subcommand,
    example="cabledrive sensitivity campaign.zarr --output 'longitudinal_hz[0]'",
    short_help="Sobol indices of a result of a sweep, with intervals.",
)
@answering
@click.argument("store", metavar="STORE.zarr", type=click.Path())
@click.option("--output", required=True, metavar="NAME", help='Such as "longitudinal_hz[0]".')
@click.option("--seed", type=int, default=0, show_default=True, metavar="N", help="Of the bootstrap.")
def command(store: str, output: str, seed: int) -> Answer:
    """Sobol indices of an output of STORE.zarr, whose design is of kind saltelli: first and total."""
    import numpy as np

    from cabledrive.campaign.sensitivity import sensitivity

    found = sensitivity(store, output, generator=np.random.default_rng(seed))
    data = asdict(found) | {"confidence": 0.95}
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
    return Answer(data=data, text="\n".join(lines), provenance=provenance(method=METHOD, seed=seed))
