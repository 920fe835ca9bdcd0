"""Options with a unit: a bare number counts in the unit of the help, text brings its own."""

import click
import pytest

from cabledrive.app.main import main as command
from cabledrive.app.options import ANGLE, DURATION, FREQUENCY
from cabledrive.parameters import InputRefused


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        (ANGLE, "45", 45.0),
        (ANGLE, "45 deg", 45.0),
        (ANGLE, "0.5 rad", 28.64788975654116),
        (DURATION, "0.5", 0.5),
        (DURATION, "500ms", 0.5),
        (FREQUENCY, "3", 3.0),
        (FREQUENCY, "0.003 kHz", 3.0),
    ],
)
def test_a_quantity_is_read_with_its_unit_or_without(kind, text, value):
    assert kind.convert(text, None, None) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(("kind", "text"), [(ANGLE, "3 s"), (DURATION, "3 kg"), (FREQUENCY, "18 rad/s")])
def test_a_quantity_of_another_dimension_is_refused(kind, text):
    with pytest.raises(InputRefused, match=text.split()[0]):
        kind.convert(text, None, None)


def test_every_option_that_measures_takes_a_unit():
    """A plain float is left where the option counts: pixels, and a share."""
    context = click.Context(command)
    plain = [
        (name, option.name)
        for name in command.list_commands(context)
        for option in command.get_command(context, name).params
        if option.type is click.FLOAT
    ]
    assert plain == [("camera", "known_pixels"), ("map", "margin"), ("tolerance", "target")]


def test_the_help_of_track_lists_the_laws():
    track = command.get_command(click.Context(command), "track")
    shown = " ".join(track.get_help(click.Context(track, info_name="track")).split())
    for law in ("darc-4-damped", "backstepping-6", "darc-indirect", "pd", "lqg", "shaper", "best"):
        assert law in shown.partition("Control laws:")[2]


def test_no_command_is_without_a_section():
    assert "More:" not in command.get_help(click.Context(command))
