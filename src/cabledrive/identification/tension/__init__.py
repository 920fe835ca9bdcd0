"""Tension of the spans: from the tones of a plucked span, and from a load cell."""

from cabledrive.identification.tension.both import tension_of_both
from cabledrive.identification.tension.load_cell import tensions_from_load_cell
from cabledrive.identification.tension.recording import read_ping, read_wav
from cabledrive.identification.tension.strings import tension_from_ping

__all__ = ["read_ping", "read_wav", "tension_from_ping", "tension_of_both", "tensions_from_load_cell"]
