"""Files of kind "route" and of a lift: they load, their geometry follows, what cannot be is refused."""

import re
import tomllib
from dataclasses import replace
from math import acos, atan2, hypot, pi, sqrt
from pathlib import Path

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics import derived_quantities
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.span_table import route_warnings
from cabledrive.parameters.drive_file import drive_from_text, drive_text, packaged_text
from cabledrive.parameters.keys import varied_together
from cabledrive.parameters.route import moved, posed
from cabledrive.parameters.route.strain_free import place_of
from cabledrive.reduction import lumped_model, simulate_fast
from cabledrive.trajectories import move_limits
from command import refused
from network_samples import routed

ROUTES = Path(__file__).parent / "routes"
NAMES = sorted(path.stem for path in ROUTES.glob("*.toml"))


def load(name, *overrides):
    return cd.load_drive(ROUTES / f"{name}.toml", overrides=overrides)


def text_of(name):
    return (ROUTES / f"{name}.toml").read_text(encoding="utf-8")


def test_a_route_may_state_a_damping_of_zero_beside_that_of_the_cable(tmp_path):
    """In a file as read, overridden, varied and written again."""
    stated = ("route.belt a.transverse_damping=0", "route.belt b.axial_damping=0")
    drive = cd.load_drive("corexy", overrides=stated)
    varied = varied_together(cd.load_drive("corexy"), {own.removesuffix("=0"): 0.0 for own in stated})
    cd.save_drive(drive, tmp_path / "damped.toml")
    for own in (drive, varied, cd.load_drive(tmp_path / "damped.toml")):
        assert [(rope.transverse_damping, rope.axial_damping) for rope in own.ropes] == [
            (0.0, 1.0),
            (10.0, 0.0),
        ]


@pytest.mark.parametrize("name", NAMES)
def test_names_have_no_bearing_on_the_hash(name):
    text, renamed = text_of(name), text_of(name)
    tables = tomllib.loads(text)
    parts = [part["name"] for key in ("body", "pulley", "anchor", "route") for part in tables.get(key, [])]
    for number, part in enumerate(parts):
        renamed = re.sub(rf'(["+-]){re.escape(part)}"', rf'\1part {number}"', renamed)
    assert f'"part {len(parts) - 1}"' in renamed
    one, other = (cd.content_hash(drive_from_text(each)) for each in (text, renamed))
    assert one == other


def test_named_tables_are_reached_by_name_and_bodies_move_with_what_they_carry():
    places = ("head.x=0.10", "beam.y=0.05")
    drive = load("corexy", *places, "body.head.mass=0.5 kg", "pulley.motor a.inertia=2e-7")
    assert drive.body[1].mass == 0.5
    assert drive.pulley[0].inertia == 2e-7
    assert drive.body[1].at == pytest.approx((0.10, 0.05))
    anchors = {anchor.name: anchor.at for anchor in drive.anchor}
    assert anchors["head left a"] == pytest.approx((0.08, 0.044))
    on_beam = next(pulley for pulley in drive.pulley if pulley.name == "beam right a")
    assert on_beam.at == pytest.approx((0.408, 0.038))


def test_an_arm_turns_about_its_pivot():
    turned = posed(load("serpentine"), {"arm.turn": np.radians(-5)})
    (px, py), (dx, dy) = (0.2508, 0.0635), (0.3477 - 0.2508, 0.05715 - 0.0635)
    c, s = np.cos(np.radians(-5)), np.sin(np.radians(-5))
    assert turned.pulley[1].at == pytest.approx((px + c * dx - s * dy, py + s * dx + c * dy))
    with pytest.raises(cd.InputRefused, match="the cable has left the pulley"):
        load("serpentine", "arm.turn=90 deg")


def test_lengths_of_a_crossed_and_an_open_belt_are_those_of_the_textbook():
    """Open: sqrt(D^2 - (r1 - r2)^2); crossed: sqrt(D^2 - (r1 + r2)^2)."""
    for path, offset in ('["+a", "+b"]', 0.1), ('["+a", "-b"]', 0.3):
        drive = routed(f"""
cable = {{ axial_rigidity = 1e4, mass_per_length = 0.01, pretension = 10 }}
layout = {{ gravity = 0 }}
pulley = [
    {{ name = "a", at = [0, 0], radius = 0.2, inertia = 1e-3 }},
    {{ name = "b", at = [0.6, 0.8], radius = 0.1, inertia = 1e-3 }},
]
route = [{{ name = "r", path = {path}, closed = true, crossed = true }}]
""")
        for span in drive.free_spans:
            assert span.length == pytest.approx(np.sqrt(1 - offset**2), rel=1e-12)
        lean = 2 * np.arcsin(offset)
        sides = (np.pi - lean, np.pi + lean) if offset == 0.1 else (np.pi + lean,) * 2
        assert [span.wrap for span in drive.free_spans] == pytest.approx(sides)


REFUSALS = [
    ("printer", '"+motor"', '"+moter"', 'did you mean "motor"'),
    ("printer", '"+motor"', '"motor"', 'write "+motor"'),
    ("printer", 'on = "head"', 'on = "haed"', 'did you mean "head"'),
    ("printer", 'pulley = "motor"', 'pulley = "moter"', 'did you mean "motor"'),
    ("printer", 'moves = "x"', 'moves = ["x", "y"]\nload = ["0 N", "5 N"]', "5 N along y are missing"),
    ("printer", 'moves = "x"', 'moves = "x"\nload = ["-70 N", "0 N"]', "a rope cannot push"),
    ("printer", 'moves = "x"', "moves = 5", 'must be "x"'),
    ("printer", 'pretension = "30 N"', "", "give pretension"),
    ("printer", '"+lower idler", "+upper idler"', '"+upper idler", "+lower idler"', "cross"),
    ("ropeway", '["701.2 m", "12.0000 m"]', '["701.2 m", "11.9800 m"]', "the cable has left the pulley"),
    ("serpentine", '"0.3477 m", "0.05715 m"', '"0.3477 m", "0.16 m"', "the cable has left the pulley"),
    ("serpentine", 'at = ["0.3477 m", "0.05715 m"]', 'at = ["0.5 m", "0.05715 m"]', "no free span"),
    (
        "serpentine",
        "[[route]]",
        '[[body]]\nname = "loose"\nmass = 1\nat = [0, 0]\nmoves = "x"\n[[route]]',
        "nothing holds it along x",
    ),
    ("corexy", 'on = "beam"\nmass', 'on = "head"\nmass', "carried by itself"),
    ("corexy", 'name = "beam left a"', 'name = "motor a"', "given twice"),
    ("printer", 'mass = "0.35 kg"', 'mas = "0.35 kg"', 'did you mean "body.0.mass"'),
    ("printer", 'moves = "x"', 'moves = "z"', "moves ="),
    ("finger", 'pivot = ["0 mm", "0 mm"]', "", "add pivot"),
    ("ropeway", '"2050 m"]', '"2950 m"]', "outside its route"),
    ("printer", 'at = ["0.18 m", "6.366 mm"]', 'at = ["0.18 m"]', "two quantities"),
    ("printer", 'at = ["0.18 m", "6.366 mm"]', 'at = ["0.18 kg", "6.366 mm"]', "not m"),
    ("printer", 'axial_rigidity = "19.4 kN"', "", "axial rigidity is missing"),
    ("printer", 'axial_rigidity = "19.4 kN"', 'type = "GT2-6m"', 'did you mean "GT2-6mm"'),
]


@pytest.mark.parametrize(("name", "old", "new", "words"), REFUSALS)
def test_what_cannot_be_is_refused_in_one_line(name, old, new, words):
    text = text_of(name)
    assert old in text
    refused(lambda: network_of(drive_from_text(text.replace(old, new, 1))), words)


def test_weights_that_nothing_holds_are_refused():
    """Also where directions of spans are level up to round-off, which times 1e19 N would hold the body."""
    text = text_of("ropeway").replace('gravity = "0 m/s^2"', 'inclination = "20 deg"')
    refused(lambda: network_of(drive_from_text(text[: text.index("[motor]")])), "every pulley turns freely")
    heavy = DRUMS.replace('gravity = "0 m/s^2"', 'gravity = "9.81 m/s^2"')
    heavy = heavy.replace('moves = "x"', 'moves = ["x", "y"]')
    refused(lambda: network_of(routed(heavy)), "body cart: no static solution")


DRUMS = """
cable = { axial_rigidity = "500 kN", mass_per_length = "0.1 kg/m", pretension = "500 N" }
layout = { gravity = "0 m/s^2" }
body = [{ name = "cart", mass = "80 kg", at = ["4 m", "0.1 m"], moves = "x" }]
pulley = [
    { name = "drum a", at = ["0 m", "0 m"], radius = "100 mm", inertia = "0.05 kg m^2" },
    { name = "drum b", at = ["12 m", "0 m"], radius = "100 mm", inertia = "0.08 kg m^2" },
]
anchor = [
    { name = "a", on = "cart", at = ["3.8 m", "0.1 m"] },
    { name = "b", on = "cart", at = ["4.2 m", "0.1 m"] },
]
route = [
    { name = "rope a", path = ["-drum a", "a"] },
    { name = "rope b", path = ["b", "-drum b"] },
]
motor = { pulley = "drum a", inertia = "0.05 kg m^2" }
"""


def test_a_drum_that_nothing_holds_is_named_with_its_torque():
    """500 N at 0.1 m, by hand; with a brake, with a motor of its own, or held for the modes none is named."""

    def warned(text, **options):
        drive = routed(text)
        lines = (*route_warnings(drive), *cd.modes(drive, count=2, **options).warnings)
        return [line for line in lines if "nothing in the file holds it" in line]

    assert len(warned(DRUMS)) == 2
    assert all("drum b by 50 N m" in line for line in warned(DRUMS))
    assert warned(DRUMS.replace('inertia = "0.08 kg m^2"', 'inertia = "0.08 kg m^2", fixed = true')) == []
    two = DRUMS.replace("motor = {", 'motor = [{ pulley = "drum b", inertia = "0.05 kg m^2" }, {')[:-1] + "]"
    assert warned(two) == []
    assert len(warned(DRUMS, hold=["drum b"])) == 1  # of the file, which does not hold it
    assert len(warned(DRUMS.replace('inertia = "0.08', 'coulomb_friction = "60 N m", inertia = "0.08'))) == 0


def test_a_rope_beyond_its_elastic_range_is_named():
    soft = routed(DRUMS.replace("500 kN", "20 kN"))  # 500 N strain it by 0.025
    lines = [line for line in route_warnings(soft) if "elastic range" in line]
    assert len(lines) == 2
    assert all("0.025" in line for line in lines)


# --- A moved body keeps every rope as long as it is: others follow, or the pose is refused with its strain
LIFT = "lift-2-to-1"


def crane(x, y, radius, height, travel=""):
    """A trolley at (x, 0) whose rope runs over a sheave to a weight at (radius, y)."""
    return routed(f"""
cable = {{ axial_rigidity = "1 MN", mass_per_length = "0.1 kg/m" }}
layout = {{ gravity = 9.81 }}
body = [
    {{ name = "trolley", at = [{x}, 0], moves = "x", mass = 50, stiffness = 1{travel} }},
    {{ name = "weight", at = [{radius}, {y}], moves = "y", mass = 20 }},
]
pulley = [{{ name = "sheave", at = [0, {height}], radius = {radius}, inertia = 0.01 }}]
anchor = [
    {{ name = "hook", on = "trolley", at = [{x}, 0] }},
    {{ name = "shackle", on = "weight", at = [{radius}, {y}] }},
]
route = [{{ name = "rope", path = ["hook", "-sheave", "shackle"] }}]
""")


def rope_of(x, radius, height):
    """Length from a hook at (x, 0), x < 0, to the level of the axle on the other side of the sheave.

    By the angles of hook and contact seen from the axle.
    """
    distance = hypot(x, height)
    to_hook = atan2(-height, x) % (2.0 * pi)
    contact = to_hook - acos(radius / distance)
    return sqrt(distance**2 - radius**2) + radius * contact


@pytest.mark.parametrize("seed", range(20))
def test_a_weight_rises_by_what_its_trolley_takes(seed):
    """Lengths by trigonometry of one point and one circle, not by the tangents of the package."""
    rng = np.random.default_rng(seed)
    x, height, radius = -rng.uniform(1.0, 4.0), rng.uniform(4.0, 9.0), rng.uniform(0.05, 0.4)
    y, there = rng.uniform(0.0, 1.0), -rng.uniform(0.5, 6.0)
    expected = y + rope_of(there, radius, height) - rope_of(x, radius, height)
    found = moved(crane(x, y, radius, height), {"trolley.x": there})
    assert place_of(found, "trolley.x") == pytest.approx(there, abs=1e-12)
    assert place_of(found, "weight.y") == pytest.approx(expected, abs=1e-10)


def test_what_no_motion_allows_is_refused_with_its_strain():
    """The frame lifted by 0.1 m leaves 0.2 m of the compensating ropes over."""
    drive = cd.load_drive(LIFT)
    rope = 2.0 * (18.5 + 2.0) + 0.9 * pi
    with pytest.raises(cd.InputRefused, match="compensation") as refused:
        moved(drive, {"tension frame.y": -1.9})
    strain = float(str(refused.value).split("strained by ")[1].split(" %")[0])
    assert strain == pytest.approx(100.0 * 0.2 / rope, rel=2e-3)
    with pytest.raises(cd.InputRefused, match="strained by"):
        moved(drive, {"car.y": 35.0, "counterweight.y": 6.0})


def test_a_body_keeps_to_its_travel():
    limited = crane(-2.0, 0.5, 0.2, 6.0, travel=', travel = "-4 m : -1 m"')
    assert limited.body[0].travel == (-4.0, -1.0)
    assert drive_from_text(cd.parameters.drive_text(limited)) == limited
    with pytest.raises(cd.InputRefused, match=r"trolley\.x = -5 m lies outside its travel, -4 : -1 m"):
        moved(limited, {"trolley.x": -5.0})
    for x, travel in ((-2.0, "-1 m : -4 m"), (-5.0, "-4 m : -1 m"), (-2.0, "-4 m")):
        with pytest.raises(cd.InputRefused, match="travel"):
            crane(x, 0.5, 0.2, 6.0, travel=f', travel = "{travel}"')
    free = crane(-2.0, 0.5, 0.2, 6.0)
    assert cd.content_hash(limited) == cd.content_hash(free), "where it may go does not change its modes"


# --- Carriages that move together: by name or number, in one direction or against each other
@pytest.mark.parametrize(
    ("first", "second", "word"),
    [
        ({}, {"coupled": "cabin"}, "no carriage of this drive"),
        ({}, {"coupled": "counterweight"}, "the carriage itself"),
        ({}, {"coupled": "", "direction": -1}, "needs carriage.1.coupled"),
        ({}, {"direction": 2}, "direction = 2 is not one of its values"),
        ({"coupled": "counterweight", "direction": -1}, {}, "contradicts"),
    ],
)
def test_couplings_that_make_no_sense_are_refused(first, second, word):
    drive = cd.load_drive("elevator").listed
    car, weight = drive.carriage
    with pytest.raises(cd.InputRefused, match=word):
        replace(drive, carriage=(replace(car, **first), replace(weight, **second)))


def test_a_wave_across_a_rope_has_the_density_of_the_stretched_one():
    """c^2 = T/rho with rho per stretched metre: of a rope that 20 N stretch by a fifth."""
    rope = cd.Cable(given_rigidity=100.0, mass_per_length=0.03, pretension=20.0)
    assert rope.wave_speed(20.0) ** 2 * (0.03 / 1.2) == pytest.approx(20.0, rel=1e-14)


# --- The file of a lift: its excitation is written as it was read, one key stretches it
LIFT_TEXT = packaged_text("lift-2-to-1")
REFUSED = [
    ("", "torque_ripple"),
    ("torque_ripple = 0", "torque_ripple"),
    ("torque_ripple = 1.5", "torque_ripple"),
    ('orders = ["poles=traction sheave*20"]', "speed"),
    ('speed = "car.y=0.2m/s:1m/s"', "orders"),
    ('orders = ["poles"]\nspeed = "car.y=0.2m/s:1m/s"', "orders"),
    ('orders = ["a=pit sheave", "a=traction sheave"]\nspeed = "car.y=0.2m/s:1m/s"', "orders"),
    ('orders = ["poles=traction sheave*-1"]\nspeed = "car.y=0.2m/s:1m/s"', "number"),
    ('orders = ["rails=car.y/0m"]\nspeed = "car.y=0.2m/s:1m/s"', "length"),
    ('orders = "poles=traction sheave"\nspeed = "car.y=0.2m/s:1m/s"', "orders"),
    ('orders = ["poles=traction sheave"]\nspeed = "car.y=1m/s:0.2m/s"', "speed"),
]


GEARED = packaged_text("dissertation-3")
ORDERS = 'orders = ["poles=motor*20"]\nspeed = "motor=1rad/s:2rad/s"'
PLACE, SHAFT = '"0.5 shaft + 0.5 m"', 'shaft = "42 m"'


@pytest.mark.parametrize(
    ("text", "name"),
    [
        *((f"{LIFT_TEXT}\n[excitation]\n{table}\n", name) for table, name in REFUSED),
        (packaged_text("dissertation-2") + "\n[excitation]\ntorque_ripple = 0.02\n", "torque_limit"),
        (f"{GEARED}\n[excitation]\n{ORDERS}\n", "route"),
        (LIFT_TEXT.replace(SHAFT, ""), "shaft"),
        (LIFT_TEXT.replace(SHAFT, 'shaft = "-1 m"'), "shaft"),
        (LIFT_TEXT.replace(SHAFT, 'shaft = "3 kg"'), "kg"),
        (LIFT_TEXT.replace(PLACE, '"shaft of 3 m"'), "place"),
        (LIFT_TEXT.replace(PLACE, '"0.5 shaft + 1 kg"'), "kg"),
        (packaged_text("ropeway-towers").replace('name = "tower 1"', "name = {}"), "a table, not text"),
        (
            packaged_text("ropeway-towers").replace("[[carriage]]", "[[carriage]]\nname = 5"),
            "a number, not text",
        ),
    ],
)
def test_what_is_no_excitation_place_or_name_is_refused(text, name):
    with pytest.raises(cd.InputRefused, match=name):
        drive_from_text(text)


def test_an_excitation_is_written_as_it_was_read():
    orders = 'orders = ["poles=traction sheave*20", "rails=car.y/5m"]\nspeed = "car.y=0.2m/s:1m/s"'
    drive = drive_from_text(f'{LIFT_TEXT}\n[excitation]\ntorque_ripple = "2 %"\n{orders}\n')
    assert drive_from_text(drive_text(drive)) == drive
    assert drive.excitation.torque_ripple == 0.02
    assert [order.number for order in drive.excitation.listed] == [20.0, 1.0]


# --- One key stretches a lift: places relative to `shaft`


def test_a_shaft_of_60_m_is_the_lift_with_every_place_written_anew():
    stretched = cd.load_drive("lift-2-to-1", overrides=["shaft=60 m"])
    text = LIFT_TEXT.replace('shaft = "42 m"', "").replace('"0.5 shaft - 1 m"', '"29 m"')
    text = text.replace('"0.5 shaft + 0.5 m"', '"30.5 m"').replace('"0.5 shaft - 2.5 m"', '"27.5 m"')
    text = text.replace('"2 m : shaft - 4 m"', '"2 m : 56 m"').replace('"shaft"', '"60 m"')
    assert "shaft" not in text.split("[cable]")[1].replace("--set shaft", "")
    assert stretched == drive_from_text(text)


@pytest.mark.parametrize(
    "asked",
    [
        derived_quantities,
        move_limits,
        lumped_model,
        lambda drive: simulate_fast(drive, 0.1),
    ],
)
def test_what_takes_two_pulleys_alone_refuses_other_machines_in_one_line(asked):
    refused(lambda: asked(cd.load_drive("corexy")), "takes one cable between two pulleys")
