"""Vibration, identification and control of flexible cable drives."""

__version__ = "0.1.0.dev0"
