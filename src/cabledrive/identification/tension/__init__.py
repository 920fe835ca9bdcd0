"""Tension of the spans: from the tones of a plucked span, and from a load cell."""
