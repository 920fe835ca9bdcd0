"""The version of the package, at the bottom of all rooms, so that every result can name it."""

__version__ = "0.3.0"
