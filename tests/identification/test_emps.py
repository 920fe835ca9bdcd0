"""The EMPS benchmark: the authors' figures by their recipe, ours by nothing but the log."""

import numpy as np
import pytest
from scipy import io, signal

from cabledrive.identification.friction_regressors import FrictionModel
from cabledrive.identification.logs.column_map import ColumnMap, with_choices
from cabledrive.identification.logs.reading import read_log
from cabledrive.identification.recipe import published_recipe, recipe_rows
from cabledrive.identification.rigid_axis import AxisOptions, identify_rigid_axis
from oracles.position_loop import PositionLoop, integrate_position_loop_of

FILE = "emps/DATA_EMPS.mat"
COLUMNS = with_choices(ColumnMap(), ["time=t", "position=qm", "force=vir:N*gtau"])
PUBLISHED = {
    "mass": 95.1089,
    "viscous_friction": 203.5034,
    "coulomb_friction": 20.3935,
    "offset_force": 3.1648,
}
OPEN = PositionLoop(position_gain=0.0, speed_gain=0.0, force_per_volt=0.0)
BOUNDS = {"mass": 0.01, "viscous_friction": 0.02, "coulomb_friction": 0.02, "offset_force": 0.05}


def unexplained(values, position, force, interval, **recipe):
    """Norm of what parameters of one log leave of the force of another, over that of the force."""
    regressor, measured = recipe_rows(position, force, interval, **recipe)
    return float(np.linalg.norm(measured - regressor @ values) / np.linalg.norm(measured))


@pytest.fixture
def log(shared_data):
    return read_log(shared_data(FILE), COLUMNS)


def test_the_authors_recipe_gives_every_printed_digit(log, measured):
    found = published_recipe(log.channel("position"), log.channel("force"), 1e-3)
    printed = " ".join(f"{x:.4f}" for x in (*found.values, *found.deviations, found.condition))
    measured(f"{printed}, residual {found.residual_norm:.4f}, {100 * found.residual_relative:.4f} %")
    assert [f"{x:.4f}" for x in found.values] == ["95.1089", "203.5034", "20.3935", "-3.1648"]
    assert [f"{x:.4f}" for x in found.deviations] == ["0.1085", "1.1460", "0.1012", "0.0444"]
    assert (f"{found.condition:.4f}", f"{found.residual_norm:.4f}") == ("25.9883", "108.7569")
    assert f"{100 * found.residual_relative:.4f}" == "4.0834"
    assert (f"{found.residual_deviation:.4f}", found.rows) == ("2.1843", 2480)


def test_the_authors_asymmetric_friction_gives_every_printed_digit(log):
    found = published_recipe(log.channel("position"), log.channel("force"), 1e-3, asymmetric=True)
    assert [f"{x:.4f}" for x in found.values] == ["95.1540", "166.7061", "20.1440", "240.4236", "20.6277"]
    assert f"{100 * found.residual_relative:.4f}" == "3.1117"


def test_our_defaults_are_near_the_published_figures(log, measured):
    """With no options: bandwidth, dead zone and segments come from the data."""
    found = identify_rigid_axis([log])
    deviations = {name: found[name] / value - 1 for name, value in PUBLISHED.items()}
    measured(", ".join(f"{name} {100 * off:+.2f} %" for name, off in deviations.items()))
    assert all(abs(deviations[name]) < BOUNDS[name] for name in BOUNDS), deviations
    assert found.identifiable
    for name, value in PUBLISHED.items():
        assert found.parameters[name].low < value < found.parameters[name].high


def test_asymmetric_friction_beside_an_offset_is_not_identifiable_and_the_direction_is_named(log, measured):
    options = AxisOptions(friction=FrictionModel(kind="asymmetric-offset"))
    found = identify_rigid_axis([log], options)
    measured("; ".join(found.unidentifiable) or "not refused")
    assert not found.identifiable
    words = found.unidentifiable[0]
    assert "coulomb friction (positive speed), coulomb friction (negative speed), offset force" in words
    assert "are not identifiable separately" in words
    for name in ("coulomb_friction_positive", "coulomb_friction_negative", "offset_force"):
        assert np.isnan(found[name])
        assert found.parameters[name].high == float("inf")
        assert found.as_dict()["parameters"][name]["value"] is None
    assert found["mass"] == pytest.approx(95.1, rel=0.01)


def test_asymmetric_friction_without_an_offset_is_found(log):
    found = identify_rigid_axis([log], AxisOptions(friction=FrictionModel(kind="asymmetric")))
    assert found["viscous_friction_positive"] == pytest.approx(166.7, rel=0.02)
    assert found["viscous_friction_negative"] == pytest.approx(240.4, rel=0.02)


@pytest.mark.parametrize("filter_", ["causal", "ideal"])
def test_the_other_filters_agree_within_their_bounds(log, filter_):
    found = identify_rigid_axis([log], AxisOptions(filter=filter_))
    deviations = {name: found[name] / value - 1 for name, value in PUBLISHED.items()}
    assert all(abs(deviations[name]) < 2 * BOUNDS[name] for name in BOUNDS), deviations


def test_the_identified_model_in_its_loop_follows_the_measured_motion(log, shared_data, measured):
    """At most 0.02 and 0.25 %; published: position 0.013752 %, velocity 0.22911 %.

    The record begins in motion, so the simulation begins with the measured position and speed. The velocity
    is that of the authors' recipe, Butterworth of order 4 at 100 Hz forwards and backwards and a central
    difference, over all samples; the difference of the raw positions beside it.
    """
    data = io.loadmat(shared_data(FILE), squeeze_me=True)
    found = identify_rigid_axis([log])
    values = np.array([estimate.value for estimate in found.parameters.values()])
    loop = PositionLoop(
        position_gain=float(data["kp"]),
        speed_gain=float(data["kv"]),
        force_per_volt=float(data["gtau"]),
        largest_command=10.0,
    )
    record = log.channel("position")
    start = (record[0], (record[1] - record[0]) / 1e-3)
    position, _, _ = integrate_position_loop_of(values, loop, data["qg"], 1e-3, start=start)
    errors = {"position": share(record, position)}
    errors["raw"] = share(np.gradient(record, 1e-3), np.gradient(position, 1e-3))
    errors["recipe"] = share(recipe_velocity(record), recipe_velocity(position))
    smoother = share(recipe_velocity(record, 20.0), recipe_velocity(position, 20.0))
    message = ", ".join(f"{name} {error:.4f} %" for name, error in errors.items())
    measured(f"{message}, up to 20 Hz {smoother:.4f} %")
    assert errors["position"] <= 0.02, f"{errors} %"
    assert max(errors["raw"], errors["recipe"]) <= 0.25, f"{errors} %"


def share(measured, simulated):
    """Norm of the difference over that of the measured [%]."""
    return 100 * np.linalg.norm(measured - simulated) / np.linalg.norm(measured)


def recipe_velocity(position, limit=100.0):
    smooth = signal.filtfilt(*signal.butter(4, limit / 500.0), position, padlen=12)
    return np.gradient(smooth, 1e-3)


def test_parameters_of_one_half_explain_the_force_of_the_other(log, measured):
    """By the authors' recipe, as its own residual of 4.1 % does: at most 6 %, forth and back."""
    position, force = log.channel("position"), log.channel("force")
    halves = [slice(0, position.size // 2), slice(position.size // 2, None)]
    shares = []
    for own, other in (halves, halves[::-1]):
        found = published_recipe(position[own], force[own], 1e-3)
        shares.append(unexplained(found.values, position[other], force[other], 1e-3))
    measured(f"{100 * shares[0]:.2f} and {100 * shares[1]:.2f} %")
    assert max(shares) < 0.06, shares


def test_the_open_loop_needs_a_small_disturbance_to_follow(log, measured):
    """Half a second under the measured force alone drifts by a tenth of the stroke.

    A constant 2.1 N more, a tenth of the Coulomb friction, bring it to a quarter of a per cent.
    """
    found = identify_rigid_axis([log])
    values = np.array([estimate.value for estimate in found.parameters.values()])
    record, force = log.channel("position")[:500], log.channel("force")[:500]
    start = (record[0], (record[1] - record[0]) / 1e-3)

    def off(disturbance):
        more = force + disturbance
        position = integrate_position_loop_of(values, OPEN, 0 * force, 1e-3, start=start, disturbance=more)[0]
        return float(np.abs(position - record).max() / np.ptp(record))

    best = min(np.linspace(-4.0, 4.0, 81), key=off)
    measured(f"alone {100 * off(0.0):.1f} % of the stroke, with {best:.1f} N {100 * off(best):.2f} %")
    assert off(0.0) < 0.15, off(0.0)
    assert off(best) < 0.01, off(best)
    assert abs(best) < 0.15 * values[2], best
