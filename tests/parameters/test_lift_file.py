"""The file of a lift: its excitation is written as it was read, one key stretches it, the rest is refused."""

import pytest

import cabledrive as cd
from cabledrive.parameters.drive_file import drive_from_text, drive_text, packaged_text

LIFT = packaged_text("lift-2-to-1")
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
        *((f"{LIFT}\n[excitation]\n{table}\n", name) for table, name in REFUSED),
        (packaged_text("dissertation-2") + "\n[excitation]\ntorque_ripple = 0.02\n", "torque_limit"),
        (f"{GEARED}\n[excitation]\n{ORDERS}\n", "route"),
        (LIFT.replace(SHAFT, ""), "shaft"),
        (LIFT.replace(SHAFT, 'shaft = "-1 m"'), "shaft"),
        (LIFT.replace(SHAFT, 'shaft = "3 kg"'), "kg"),
        (LIFT.replace(PLACE, '"shaft of 3 m"'), "place"),
        (LIFT.replace(PLACE, '"0.5 shaft + 1 kg"'), "kg"),
    ],
)
def test_what_is_no_excitation_and_no_relative_place_is_refused(text, name):
    with pytest.raises(cd.InputRefused, match=name):
        drive_from_text(text)


def test_an_excitation_is_written_as_it_was_read():
    orders = 'orders = ["poles=traction sheave*20", "rails=car.y/5m"]\nspeed = "car.y=0.2m/s:1m/s"'
    drive = drive_from_text(f'{LIFT}\n[excitation]\ntorque_ripple = "2 %"\n{orders}\n')
    assert drive_from_text(drive_text(drive)) == drive
    assert drive.excitation.torque_ripple == 0.02
    assert [order.number for order in drive.excitation.listed] == [20.0, 1.0]


# --- One key stretches a lift: places relative to `shaft`


def test_a_shaft_of_60_m_is_the_lift_with_every_place_written_anew():
    stretched = cd.load_drive("lift-2-to-1", overrides=["shaft=60 m"])
    text = LIFT.replace('shaft = "42 m"', "").replace('"0.5 shaft - 1 m"', '"29 m"')
    text = text.replace('"0.5 shaft + 0.5 m"', '"30.5 m"').replace('"0.5 shaft - 2.5 m"', '"27.5 m"')
    text = text.replace('"2 m : shaft - 4 m"', '"2 m : 56 m"').replace('"shaft"', '"60 m"')
    assert "shaft" not in text.split("[cable]")[1].replace("--set shaft", "")
    assert stretched == drive_from_text(text)
