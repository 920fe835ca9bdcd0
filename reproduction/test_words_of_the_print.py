"""What the errata say the print says: sentences and table rows, looked up in the text where it is at hand."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TEXT = ROOT.parent / "shared" / "reference" / "dissertation.txt"

PHRASES = {
    "convention-density": ["static linear mass density", "linear mass density of cable"],
    "convention-symbols": ["apparent strain", r"where $k_{m}=\frac{K_{\sigma}}{\mu}$"],
    "erratum-2-31-spacing": [
        r"$n$ equal segments of length $d x=\frac{L_{e}}{n-1}$",
        "applied at $m=1, n+1$",
    ],
    "erratum-2-32-indices": [r"\frac{w_{1}\left(t_{j+1}, x_{m}\right)-2 w_{i}", r"& \pm g \tag{2.32c}"],
    "erratum-2-33-boundary-slope": ["calculated using central differences"],
    "erratum-fig-3-8-midpoint": [r"the configuration is equivalent to $\chi_{m}=0$"],
    "erratum-table-3-2-in-phase": [
        "in-phase cable oscillations in Figure 3.5(b) do not require angular acceleration"
    ],
    "erratum-4-1-motor-power": ["rated for 240 W", "RE 5050 mm , Graphite Brushes, 200 Watt"],
    "erratum-4-1-achievable-torque": ["maximum achievable value of 2.1 Nm", "8920.0 mNm"],
    "erratum-4-1-camera": ["maximum speed of 480 frames", "at 400 frames/sec"],
    "erratum-4-8-smoothing": ["hyperbolic tangent function with $K=0.5$"],
    "erratum-4-14-line-spacing": ["1000 sine waves", "hanning window of 1 second"],
    "erratum-4-20-current": [
        "voltage command and motor current is essentially a constant gain of about 4.2 dB"
    ],
    "erratum-table-4-1-excitations": [
        "Experiment 1 using",
        "Experiment 2 using",
        "from all experiments performed",
    ],
    "erratum-table-4-1-consistency": ["with only a small increase with increasing inertia"],
    "erratum-5-2-pretension": ["Only cable tension was changed to satisfy"],
    "erratum-figure-6-3": ["around 7 Hz", "around 120 Hz"],
    "erratum-table-3-2-mixture": ["matches closely with the theoretical frequency of 81.6 Hz"],
    "number-rig-results": ["about five times the encoder resolution", "tracking accuracy of 0.3 deg"],
    "number-joint-pair": ["pair is observed near 100 Hz", "$b_{m}=0.075, k_{m}=135$"],
    "number-pulse": [r"for a given $\theta_{f}$ and $t_{f}$"],
}
ROWS = """
| $J_{1}$ | $7.316 \\times 10^{-6} \\mathrm{kgm}^{2}$ | $0.0011 \\mathrm{kgm}^{2}$ |
| $J_{2}$ | $7.316 \\times 10^{-6} \\mathrm{kgm}^{2}$ | $7.316 \\times 10^{-6} \\mathrm{kgm}^{2}$ |
| $r_{1}$ | 3 cm | 3 cm |
| $E$ | 2.6 Gpa | 2.6 Gpa |
| $A$ | $4.26 \\times 10^{-7} \\mathrm{~m}^{2}$ | $4.26 \\times 10^{-7} \\mathrm{~m}^{2}$ |
| $T_{0}$ | 5 N | 5 N |
| Configuration 1 | 116 Hz | 766 Hz | 50.5 Hz | 751.8 Hz |
| Configuration 2 | 81.6 Hz | 757.5 Hz | 50.5 Hz | 751.8 Hz |
| 0.001742 | 0.0011 | 0.000642 | 0.00235 |
| $1 \\mathrm{~Hz}+3 \\mathrm{~Hz}+5 \\mathrm{~Hz}$ | 0.0011 | 0.00216 | 0.024 | -0.0057 |
| $1 \\mathrm{~Hz}+3 \\mathrm{~Hz}+5 \\mathrm{~Hz}$ | 0.001742 | 0.0031 | 0.0376 | -0.0006 |
| $1 \\mathrm{~Hz}+3 \\mathrm{~Hz}+5 \\mathrm{~Hz}$ | 0.00345 | 0.005 | 0.045 | -0.0008 |
| $E$ | 3 Gpa |
| $A$ | $1.46 \\times 10^{-7} \\mathrm{~m}^{2}$ |
| 850 | 0.18 | 135 | 0.075 |
| Nominal speed | 5680.0 rpm |
| Nominal torque (max. continuous torque) | 405.0 mNm |
| Torque constant | $38.5 \\mathrm{mNm} / \\mathrm{A}$ |
| Terminal resistance | 0.103 |
| Mechanical time constant | 3.75 ms |
| Rotor inertia | $536.0 \\mathrm{gcm}^{2}$ |
| Counts per turn | 500.0 |
| Reduction | 5.2 |
| Intermittently permissible torque at gear output | 12.0 Nm |
| Average backlash no load | $1.0^{\\circ}$ |
| Mass inertia | $109.0 \\mathrm{gcm}^{2}$ |
| Recommended input speed | 3000.0 rpm |
"""

needs_text = pytest.mark.skipif(not TEXT.is_file(), reason="needs ../shared/reference/dissertation.txt")


def without_blanks(text):
    return re.sub(r"\s+", "", text)


@needs_text
@pytest.mark.parametrize("anchor", PHRASES)
def test_sentences_stand_in_the_text_as_quoted(anchor):
    """An item that judges a sentence judges one that is there."""
    text = without_blanks(TEXT.read_text(encoding="utf-8"))
    absent = [phrase for phrase in PHRASES[anchor] if without_blanks(phrase) not in text]
    assert not absent, f"{anchor}: not in the text: {absent}"
    assert f"({anchor})=" in (ROOT / "reproduction" / "errata.md").read_text(encoding="utf-8")


@needs_text
def test_tables_stand_in_the_text_as_used():
    """Every table value used by the tests of this folder."""
    text = without_blanks(TEXT.read_text(encoding="utf-8"))
    absent = [row for row in ROWS.strip().splitlines() if without_blanks(row) not in text]
    assert not absent, "\n".join(absent)
