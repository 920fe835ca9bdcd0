"""Numbers, words and colours of a page: customary units, as print has them, readable in light and dark."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cabledrive.report.picture import COLOURS
from cabledrive.report.typesetting import number, quantity, typeset


def plain(text: str) -> str:
    return text.replace("\N{NARROW NO-BREAK SPACE}", " ")


@pytest.mark.parametrize(
    "value, shown",
    [
        (0.0, "0"),
        (5.0, "5"),
        (-600e-6, "−6 × 10⁻⁴"),
        (116.32932059, "116.33"),
        (36000.0, "36000"),
        (1234567.0, "1.2346 × 10⁶"),
        (7.316e-6, "7.316 × 10⁻⁶"),
        (9.999996e-5, "1 × 10⁻⁴"),
        (0.00099999999, "0.001"),
        (float("inf"), "infinite"),
    ],
)
def test_a_number_has_five_digits_and_a_readable_size(value, shown):
    assert plain(number(value)) == shown


@given(st.floats(min_value=1e-25, max_value=1e25), st.booleans(), st.integers(2, 9))
def test_a_shown_number_reads_back_to_its_digits(size, negative, digits):
    value = -size if negative else size
    text = plain(number(value, digits)).replace("−", "-").replace(" × 10", "e")
    text = text.translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-"))
    assert float(text) == pytest.approx(value, rel=0.5000001 * 10.0 ** (1 - digits))


@pytest.mark.parametrize(
    "value, unit, shown",
    [
        (2.6e9, "Pa", "2.6 GPa"),
        (4.9e-4, "kg/m", "0.49 g/m"),
        (4.26e-7, "m^2", "0.426 mm²"),
        (0.03, "m", "30 mm"),
        (1100.0, "m", "1100 m"),
        (3.2e-5, "m", "32 µm"),
        (0.0, "m", "0 m"),
        (114.3539726, "rad/s", "1092 rpm"),
        (-1.5707963267948966, "rad", "−90°"),
        (7.316e-6, "kg m^2", "7.316 × 10⁻⁶ kg m²"),
        (204e3, "N m", "204 kN m"),
        (0.56, "N m", "0.56 N m"),
        (0.0376, "N m", "37.6 mN m"),
        (5000.0, "Hz", "5 kHz"),
        (5.2, "1", "5.2"),
    ],
)
def test_a_quantity_is_shown_in_the_unit_people_use(value, unit, shown):
    assert plain(quantity(value, unit)) == shown


# --- Words are set as print has them; code, formulas and the insides of tags are left alone
N, W = "\N{NARROW NO-BREAK SPACE}", "\N{NO-BREAK SPACE}"


@pytest.mark.parametrize(
    ("plain", "set_"),
    [
        ("raise it to 3.33e+03 N", f"raise it to 3330{N}N"),
        ("7e-08 rad^2 a second", f"7{N}×{N}10⁻⁸{N}rad² a second"),
        ("b = -0.0021 N m s/rad", f"b = −0.0021{N}N{W}m{W}s/rad"),
        ("2 r1 T0 over J11", "2 r₁ T₀ over J₁₁"),
        ("a floor of 10 um", f"a floor of 10{N}µm"),
        ("229 N m/rad.", f"229{N}N{W}m/rad."),
        ("right to 5 % and", f"right to 5{N}% and"),
    ],
)
def test_words_are_set_as_print_has_them(plain: str, set_: str):
    assert typeset(f"<p>{plain}</p>") == f"<p>{set_}</p>"


@pytest.mark.parametrize(
    "html",
    [
        '<a href="#fig-4-17-r1" title="T0 of 5 N">Figures 5-6, darc-4, 3 moves and 2 spans</a>',
        "<code>9c83e05 motor.r1 = 5 N, 1e-3</code>",
        "<style>.a { margin: -2px 1e3px }</style><script>const r1 = -2 ** 1e-3;</script>",
        "<math><mi>T0</mi><mo>-5</mo></math>",
    ],
)
def test_code_formulas_and_tags_are_left_alone(html: str):
    assert typeset(html) == html


# --- Colours can be read and distinguished, in light and in dark
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
