"""Colours can be read and distinguished, in light and in dark."""

import pytest

from cabledrive.report.style import COLOURS

WORDS = ("ink", "quiet", "blue", "orange", "green", "purple", "ochre", "red")


def linear(colour: str) -> list[float]:
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    return [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]


def luminance(colour: str) -> float:
    return sum(w * p for w, p in zip((0.2126, 0.7152, 0.0722), linear(colour), strict=True))


def contrast(one: str, other: str) -> float:
    """Contrast ratio of the Web Content Accessibility Guidelines, 1 to 21."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
@pytest.mark.parametrize("ground", ["paper", "card", "faint"])
@pytest.mark.parametrize("word", WORDS)
def test_words_reach_the_contrast_of_readable_text(word, ground, theme):
    """4.5 to 1, level AA."""
    seen = contrast(COLOURS[word][theme], COLOURS[ground][theme])
    assert seen >= 4.5, f"{word} on {ground}: {seen:.2f}"
