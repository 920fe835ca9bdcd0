"""One cable between two pulleys, found in machines with routes that stand, turn and begin otherwise."""

from dataclasses import replace
from functools import cache
from math import cos, sin

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics import derived_quantities, rest_state
from cabledrive.parameters import Carriage, Motor
from cabledrive.parameters.route.two_pulleys import in_machine, two_pulleys_of
from cabledrive.reduction.fast_simulation import simulate_fast
from cabledrive.reduction.lumped_chain import lumped_model, natural_frequencies_of
from cabledrive.reduction.network_axis import as_axis
from cabledrive.simulation import Pluck, Scheme, Sine, Start, simulate
from cabledrive.studies.resonance import resonance
from command import refused
from network_samples import as_routes


def elsewhere(drive, turned, mirrored, backwards, begun):
    """As a machine with routes, its drawing turned by an angle [rad] and shifted, seen in a mirror or not.

    ``backwards``: followed against the way of the file of two pulleys; ``begun``: at the other pulley.
    """
    own = as_routes(drive)
    flip, lengths = -1.0 if mirrored else 1.0, [span.length for span in own.free_spans]
    names = {"drive pulley": "capstan", "load pulley": "idler"}
    pulleys = []
    for pulley in own.pulley:
        x, y = pulley.at
        x, y = cos(turned) * x - sin(turned) * y, sin(turned) * x + cos(turned) * y
        pulleys.append(replace(pulley, name=names[pulley.name], at=(flip * x + 3.0, y - 1.0)))
    order = sorted(range(len(lengths)), reverse=begun != backwards)
    starts = {span: sum(lengths[one] for one in order[:i]) for i, span in enumerate(order)}
    against, carriages = backwards if drive.closed else begun, []
    for carriage in own.carriage:
        span = int(carriage.position > lengths[0])
        along = carriage.position - span * lengths[0]
        place = starts[span] + (lengths[span] - along if against else along)
        carriages.append(replace(carriage, position=place))
    motor = (replace(one, pulley="capstan", offset_torque=flip * one.offset_torque) for one in own.motor)
    path = [("+" if mirrored != backwards else "-") + name for name in ("capstan", "idler")]
    return replace(
        own,
        layout=replace(own.layout, inclination=flip * (own.layout.inclination - turned)),
        pulley=tuple(pulleys[::-1] if begun and own.motor else pulleys),
        motor=tuple(motor),
        stops=(),
        route=(replace(own.route[0], path=tuple(path[::-1] if begun else path)),),
        carriage=tuple(carriages),
    )


WAYS = [
    (0.0, False, False, False),
    (0.6, False, True, False),
    (-0.4, True, False, True),
    (0.3, True, True, True),
    (0.0, False, False, True),
]


def uneven():
    """A loop on a slope with two carriages and pulleys of two sizes."""
    drive = cd.load_drive(
        "dissertation-2", overrides=["cable.pretension=40 N", "layout.inclination=20 deg"]
    ).listed
    load = replace(drive.load_pulley, radius=0.7 * drive.load_pulley.radius)
    carriages = (
        Carriage(mass=0.05, position=0.3),
        Carriage(mass=0.02, position=0.55, span="lower", guided=False),
    )
    return replace(
        drive,
        pulley=(drive.drive_pulley, load),
        motor=Motor(inertia=2e-4, offset_torque=3e-3, torque_limit=0.05),
        carriage=carriages,
    )


@pytest.mark.parametrize("way", WAYS)
def test_it_is_the_same_drive_wherever_it_stands_and_its_path_begins(way):
    drive = uneven()
    own = in_machine(machine := elsewhere(drive, *way))
    assert own.layout.inclination == pytest.approx(drive.layout.inclination, abs=1e-12)
    assert own.motor.offset_torque == drive.motor.offset_torque
    assert [one.span for one in own.carriage] == [one.span for one in drive.carriage]
    places = [[one.position for one in other.carriage] for other in (own, drive)]
    np.testing.assert_allclose(*places, rtol=1e-12)
    lengths = [other.pulley_distance for other in (own, drive)]
    tensions = [rest_state(other).lowest_tension for other in (machine, drive)]
    np.testing.assert_allclose(*zip(lengths, tensions, strict=True), rtol=1e-9)


@pytest.mark.parametrize("way", WAYS)
def test_a_line_on_the_other_side_is_another_machine(way):
    """It hangs otherwise from below a pulley than from above, unless nothing weighs."""
    drive = replace(uneven(), kind="line", carriage=uneven().carriage[:1])
    other = elsewhere(drive, *way)
    light = replace(other, layout=replace(other.layout, gravity=0.0))
    assert in_machine(light).carriage[0].position == pytest.approx(0.3, rel=1e-12)
    if way[2] == way[3]:
        assert in_machine(other).carriage[0].position == pytest.approx(0.3, rel=1e-12)
    else:
        refused(lambda: in_machine(other), "leaves the drive pulley on the other side")


@cache
def closed_forms(name, way=None):
    """Datasheet and resonance of a drive of two pulleys, or of the machine that it is elsewhere."""
    drive = uneven() if name == "uneven" else replace(cd.load_drive(name).listed, lumped=None)
    one = elsewhere(drive, *way) if way else drive
    return derived_quantities(one).as_dict(), resonance(one, torque=0.01)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ["dissertation-2", "dissertation-3", "uneven"])
def test_closed_forms_are_those_of_the_file_of_two_pulleys(name, way):
    sheets, found = zip(closed_forms(name), closed_forms(name, way), strict=True)
    known = [key for key, value in sheets[0].items() if isinstance(value, float) and sheets[1][key]]
    assert len(known) > 14
    np.testing.assert_allclose(*([sheet[key] for key in known] for sheet in sheets), rtol=1e-8)
    figures = ("frequency_ratio", "pulley_frequency", "threshold_here", "coulomb_onset")
    values = [[getattr(one, key) or 0.0 for key in figures] for one in found]
    np.testing.assert_allclose(*values, rtol=1e-6)
    assert found[0].verdict == found[1].verdict
    assert len(found[0].pairs) == len(found[1].pairs) > 0


def test_an_axis_whose_heavy_cable_is_no_chain_of_the_network_is_that_of_its_two_pulleys():
    drive = uneven()
    bare = replace(drive, carriage=(), cable=replace(drive.cable, mass_per_length=0.05))
    machine = elsewhere(bare, *WAYS[2])
    frequencies = [natural_frequencies_of(lumped_model(as_axis(one))) for one in (bare, machine)]
    np.testing.assert_allclose(*frequencies, rtol=1e-12)


def test_the_fast_model_runs_it():
    drive = replace(cd.load_drive("dissertation-2").listed, excitation=None)
    smooth = replace(drive, pulley=tuple(replace(one, coulomb_friction=0.0) for one in drive.pulley))
    smooth = replace(smooth, motor=drive.motor and replace(drive.motor, coulomb_friction=0.0))
    push, machine = Sine(amplitude=0.02, frequency=40.0), elsewhere(smooth, *WAYS[2])
    hung = Start(from_equilibrium=True, hold="drive")
    runs = [simulate_fast(one, 0.05, torque=push, start=hung).rows for one in (smooth, machine)]
    moved = [run - run[0] for run in runs]
    np.testing.assert_allclose(*moved, atol=1e-9 * np.abs(moved[0]).max())


@pytest.mark.parametrize("way", WAYS)
def test_the_fast_model_plucks_the_span_that_the_machine_names_and_moves_about_rest(way):
    """As the cable in segments does, within 0.5 %; it began straight, from where spans fell to their sag."""
    drive = replace(cd.load_drive("dissertation-2").listed, excitation=None)
    machine = elsewhere(drive, *way)
    for span in machine.spans:
        start = Start(plucks=(Pluck(height=1e-3, span=span, shape="half-sine"),))
        fast = simulate_fast(machine, 0.05, start=start)
        exact = simulate(machine, 0.05, start=start, scheme=Scheme(segments=60))
        for name in exact.spans:
            moved = (run.midpoint(name)[:, 2] for run in (exact, fast))
            swings = [(np.ptp(own), own[0]) for own in moved]
            np.testing.assert_allclose(*swings, rtol=5e-3, atol=2e-8)
        assert set(fast.summary()) <= set(exact.summary()) | {"load_angle", "drive_angle"}
    words = refused(lambda: simulate_fast(machine, 0.05, start=Start(plucks=(Pluck(height=1e-3),))))
    assert "capstan to idler" in words


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda own: replace(own, motor=(), stops=()), "nothing holds its pulleys"),
        (lambda own: replace(own, cable=replace(own.cable, pretension=None)), "no pretension"),
        (lambda own: replace(own, route=(replace(own.route[0], speed=1.0),)), "its cable runs"),
        (
            lambda own: replace(
                own, route=(replace(own.route[0], path=("-capstan", "+idler"), crossed=True),)
            ),
            "crosses over",
        ),
    ],
)
def test_what_is_no_such_machine_is_refused_with_the_part_in_the_way(change, said):
    machine = change(elsewhere(uneven(), *WAYS[1]))
    assert machine.two_pulleys is None
    refused(lambda: two_pulleys_of(machine, "the map"), "the map takes one cable between two pulleys", said)


@pytest.mark.parametrize("name", cd.packaged_drives("loop", "line"))
def test_a_machine_changed_in_python_keeps_all_that_its_file_says(name):
    """Measured stiffness and carriages that move together, too, of which a file of routes knows nothing."""
    machine = cd.load_drive(name)
    listed, found = machine.two_pulleys, replace(machine, title="another").two_pulleys
    assert machine.kind == listed.kind
    for key in ("kind", "name", "pulley", "motor", "lumped", "sensors", "goal", "excitation", "called"):
        assert getattr(found, key) == getattr(listed, key), key
    for key in ("span_length", "pulley_distance"):
        assert getattr(found, key) == pytest.approx(getattr(listed, key), rel=1e-15), key
    for one, other in zip(found.carriage, listed.carriage, strict=True):
        assert one.position == pytest.approx(other.position, rel=1e-14)
        assert replace(one, position=other.position) == other
    assert found.cable.axial_rigidity == listed.cable.axial_rigidity
    assert (found.layout.gravity, found.layout.inclination) == (
        listed.layout.gravity,
        listed.layout.inclination,
    )


def test_functions_take_a_machine_or_its_drive():
    """The same answer, byte for byte, of the machine and of the drive that its file lists."""
    machine = cd.load_drive("dissertation-2")
    drive = machine.two_pulleys
    assert cd.content_hash(machine) == cd.content_hash(drive)
    assert cd.drive_warnings(machine) == cd.drive_warnings(drive)
    assert repr(cd.resonance(machine, torque=0.1)) == repr(cd.resonance(drive, torque=0.1))
    one, other = (cd.natural_frequencies(own, count=4) for own in (machine, drive))
    assert (one == other).all()
    run, again = (cd.simulate(own, 0.01, torque=0.1) for own in (machine, drive))
    assert run.provenance == again.provenance
    assert (run.midpoint("upper") == again.midpoint("upper")).all()
