"""Words of a page are set as print has them; code, formulas and the insides of tags are left alone."""

import pytest

from cabledrive.report.typesetting import typeset

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
