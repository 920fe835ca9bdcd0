"""The exact loop at random points of a map: how far the map is off."""

from dataclasses import dataclass, replace

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate
from cabledrive.studies.resonance_map import GrowthMap

POINTS = 3
GROWN = 2.0
"""Where a motion has grown so many times a check says something: such points come first."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SpotCheck:
    """One point of a map by the exact loop.

    Attributes
    ----------
    pretension, torque : float
        [N], [N m].
    growth : float
        Of the map [-].
    exact : float or None
        Of the exact loop [-]; None where a span went slack there.
    """

    pretension: float
    torque: float
    growth: float
    exact: float | None


def spot_checks(
    drive: Drive, growth: GrowthMap, rng: np.random.Generator, points: int = POINTS
) -> tuple[SpotCheck, ...]:
    """Run the exact loop at random taut points of a map, most of them inside the instability region.

    Without weight and Coulomb friction, which the map leaves out as well.

    Returns empty where the drive is not a plain loop whose spans vibrate in their first mode.
    """
    model = autoparametric_model(drive)
    plain = drive.kind == "loop" and not drive.carriage and all(mode.number == 1 for mode in model.modes)
    taut = np.argwhere(~growth.slack)
    if not plain or taut.size == 0:
        return ()
    shuffled = rng.permutation(taut)
    grown = growth.growth[tuple(shuffled.T)] > GROWN
    inside = shuffled[grown][: points - points // 3]
    chosen = np.concatenate((inside, shuffled[~grown]))[:points]
    return tuple(_checked(drive, growth, model.natural, int(t), int(p)) for t, p in chosen)


def _checked(drive: Drive, growth: GrowthMap, natural: float, row: int, column: int) -> SpotCheck:
    tension, torque = float(growth.pretension[column]), float(growth.torque[row])
    smooth = tuple(replace(pulley, coulomb_friction=0.0) for pulley in drive.pulley)
    motor = drive.motor and replace(drive.motor, coulomb_friction=0.0, offset_torque=0.0)
    bare = replace(
        drive,
        cable=replace(drive.cable, pretension=tension),
        layout=replace(drive.layout, gravity=0.0),
        pulley=smooth,
        motor=motor,
    )
    heights = {"upper": growth.pluck, "lower": 0.5 * growth.pluck}
    plucks = tuple(Pluck(height=height, span=span, shape="half-sine") for span, height in heights.items())
    result = simulate(
        bare,
        growth.duration,
        torque=Sine(amplitude=torque, frequency=natural / (2 * np.pi)),
        start=Start(plucks=plucks),
        scheme=Scheme(segments=100),
        recording=Recording(rate=8 * natural / (2 * np.pi)),
    )
    exact = None
    if result.stopped is None:
        largest = max(float(np.max(np.abs(result.midpoint(span)[:, 2]))) for span in heights)
        exact = largest / growth.pluck
    found = float(growth.growth[row, column])
    return SpotCheck(pretension=tension, torque=torque, growth=found, exact=exact)


def spot_check_line(checks: tuple[SpotCheck, ...]) -> str:
    """What the spot checks say, for a caption."""
    if not checks:
        return (
            "No spot check: the comparison with the full nonlinear model needs spans without carriages "
            "that vibrate in their first mode."
        )
    taut = [check for check in checks if check.exact is not None]
    worst = max((abs(check.growth / check.exact - 1.0) for check in taut if check.exact), default=0.0)
    slack = f", {len(checks) - len(taut)} of them slack there" if len(taut) < len(checks) else ""
    grown = sum(check.growth > GROWN for check in checks)
    return (
        f"Full nonlinear model at {len(checks)} random points, {grown} of them inside the instability "
        f"region{slack}: the growth differs by up to {100 * worst:.2g} %."
    )
