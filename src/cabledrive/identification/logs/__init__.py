"""Logs of any common format as channels in SI, with a report of what was found in them."""
