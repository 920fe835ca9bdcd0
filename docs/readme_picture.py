"""Draws the picture of the README: natural modes of the packaged lift. Takes the file to write."""

import sys
from pathlib import Path

import cabledrive as cd
from cabledrive.report.mode_figure import mode_picture

drive = cd.load_drive("elevator")
found = cd.modes(drive, below=25.0)
assert found.certified
Path(sys.argv[1]).write_bytes(mode_picture(drive, found, "svg", most=5))
