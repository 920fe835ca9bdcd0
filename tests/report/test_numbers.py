"""Numbers are shown in customary units, rounded and never falsified."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cabledrive.report.numbers import decimals_for, fixed, number, quantity, unit_name


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


def test_columns_line_up_with_the_digits_asked_for():
    assert decimals_for(1614.7, 7) == 3
    assert fixed(5.9447131, 3) == "5.945"
    assert fixed(-0.25, 1) in ("−0.2", "−0.3")


def test_powers_in_units_are_raised():
    assert unit_name("kg m^2") == "kg m²"
    assert unit_name("1") == ""
