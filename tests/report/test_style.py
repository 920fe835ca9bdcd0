"""Colours can be read and distinguished, in light and in dark."""

from itertools import combinations

import pytest

from cabledrive.report.style import COLOURS, FAMILY_COLOURS, theme_css

WORDS = ("ink", "quiet", "blue", "orange", "green", "purple", "ochre", "red")
# Severe deficiency of one kind of cone, in linear light: G. M. Machado, M. M. Oliveira, L. A. F. Fernandes,
# "A physiologically-based model for simulation of color vision deficiency", IEEE TVCG 15(6), 2009, table 1.
DEFICIENCIES = {
    "none": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "red": (
        (0.152286, 1.052583, -0.204868),
        (0.114503, 0.786281, 0.099216),
        (-0.003882, -0.048116, 1.051998),
    ),
    "green": (
        (0.367322, 0.860646, -0.227968),
        (0.280085, 0.672501, 0.047413),
        (-0.011820, 0.042940, 0.968881),
    ),
}


def linear(colour: str) -> list[float]:
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    return [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]


def luminance(colour: str) -> float:
    return sum(w * p for w, p in zip((0.2126, 0.7152, 0.0722), linear(colour), strict=True))


def contrast(one: str, other: str) -> float:
    """Contrast ratio of the Web Content Accessibility Guidelines, 1 to 21."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def lab(rgb: list[float]) -> list[float]:
    """Linear RGB in the even colour space Oklab, lightness 0 to 1."""
    r, g, b = (max(v, 0.0) for v in rgb)
    cones = (
        0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b,
        0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b,
        0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b,
    )
    l, m, s = (cone ** (1 / 3) for cone in cones)
    return [
        0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
        1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
        0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s,
    ]


@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
@pytest.mark.parametrize("ground", ["paper", "card", "faint"])
@pytest.mark.parametrize("word", WORDS)
def test_words_reach_the_contrast_of_readable_text(word, ground, theme):
    """4.5 to 1, level AA."""
    seen = contrast(COLOURS[word][theme], COLOURS[ground][theme])
    assert seen >= 4.5, f"{word} on {ground}: {seen:.2f}"


@pytest.mark.parametrize("deficiency", DEFICIENCIES)
@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
def test_colours_that_name_families_differ_for_every_eye(theme, deficiency):
    """Distance in Oklab of at least 0.04, twice what is just seen side by side; labels say the same."""
    light = {pair[0]: pair for pair in COLOURS.values()}
    seen = {}
    for family, colour in FAMILY_COLOURS.items():
        rgb = linear(light[colour][theme])
        rows = DEFICIENCIES[deficiency]
        seen[family] = lab([sum(w * p for w, p in zip(row, rgb, strict=True)) for row in rows])
    for one, other in combinations(seen, 2):
        distance = sum((a - b) ** 2 for a, b in zip(seen[one], seen[other], strict=True)) ** 0.5
        assert distance >= 0.04, f"{one} and {other}: {distance:.3f}"


def test_every_colour_has_a_value_for_light_and_one_for_dark():
    css = theme_css()
    assert all(css.count(f"--{name}:") == 2 for name in COLOURS)
    assert "screen and (prefers-color-scheme: dark)" in css  # print stays light
