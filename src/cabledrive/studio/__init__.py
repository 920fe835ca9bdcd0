"""The door to the screen: a drive, its modes, logs and controllers in the browser, on this machine."""

from cabledrive.studio.server import open_studio

__all__ = ["open_studio"]
