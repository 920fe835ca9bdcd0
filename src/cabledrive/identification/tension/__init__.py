"""Tension of the spans: from the tones of a plucked span, and from a load cell."""

from cabledrive.identification.tension.answers import PingTension, SpanTension
from cabledrive.identification.tension.from_ping import tension_from_ping
from cabledrive.identification.tension.load_cell import SpanTensions, tensions_from_load_cell
from cabledrive.identification.tension.sound import read_ping, read_wav

__all__ = [
    "PingTension",
    "SpanTension",
    "SpanTensions",
    "read_ping",
    "read_wav",
    "tension_from_ping",
    "tensions_from_load_cell",
]
