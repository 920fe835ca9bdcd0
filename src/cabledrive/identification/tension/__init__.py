"""Tension of the spans: from the tones of a plucked span, and from a load cell."""

from cabledrive.identification.tension.answers import BothTensions, FamilyTension, PingTension, SpanTension
from cabledrive.identification.tension.both_spans import tension_of_both
from cabledrive.identification.tension.from_ping import tension_from_ping
from cabledrive.identification.tension.load_cell import SpanTensions, tensions_from_load_cell
from cabledrive.identification.tension.prepared_recording import read_ping, read_wav

__all__ = [
    "BothTensions",
    "FamilyTension",
    "PingTension",
    "SpanTension",
    "SpanTensions",
    "read_ping",
    "read_wav",
    "tension_from_ping",
    "tension_of_both",
    "tensions_from_load_cell",
]
