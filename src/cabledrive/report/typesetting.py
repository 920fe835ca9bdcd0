"""Numbers as people read them, and the last touch on a page.

Powers and indices are raised and lowered, a minus is a minus, and no line ends between a number and its unit.
Formulas, code, styles and scripts stay as they are, and so does what stands inside a tag.
"""

import re
from math import degrees, floor, isfinite, log10, pi

SPACE = "\N{NARROW NO-BREAK SPACE}"
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PREFIXES = {3: "k", 6: "M", 9: "G", 12: "T"}
_PREFIXED = {"N", "Pa", "Hz", "N/m", "N m", "N m/rad"}


def number(value: float, digits: int = 5) -> str:
    """A number of some significant digits, trailing zeros dropped: "0.03", "116.33", "7.316 × 10⁻⁶"."""
    if not isfinite(value):
        return "infinite" if value > 0 else "minus infinite" if value < 0 else "not a number"
    rounded = float(f"{value:.{digits}g}")
    if rounded == 0.0:
        return "0"
    if 1e-3 <= abs(rounded) < 1e6:
        return f"{rounded:.{max(digits, 6)}g}".replace("-", "−")
    exponent = floor(log10(abs(value)))
    mantissa = f"{value / 10.0**exponent:.{digits}g}"
    if abs(float(mantissa)) >= 10.0:  # 9.99999 rounds up
        mantissa, exponent = f"{float(mantissa) / 10:.{digits}g}", exponent + 1
    return f"{mantissa}{SPACE}×{SPACE}10{str(exponent).translate(_RAISED)}".replace("-", "−")


def stated(value: float | None, digits: int) -> str:
    """A `number`; nothing where there is none."""
    return "" if value is None else number(value, digits)


def fixed(value: float, decimals: int) -> str:
    """A number with a given count of decimals, for columns that line up."""
    return f"{value:.{decimals}f}".replace("-", "−")


def decimals_for(largest: float, digits: int = 6) -> int:
    """Decimals, at least 1, that give the largest number of a column this many digits."""
    return max(1, digits - 1 - floor(log10(abs(largest)))) if largest else 1


def unit_name(unit: str) -> str:
    """A unit of a drive file as it is printed: "kg m²" for "kg m^2"; nothing for a plain number."""
    if unit == "1":
        return ""
    head, *powers = unit.split("^")
    return head + "".join(p[0].translate(_RAISED) + p[1:] for p in powers)


def quantity(value: float, unit: str, digits: int = 5) -> str:
    """A quantity in SI in the unit people use for its size: "2.6 GPa", "0.49 g/m", "3 cm", "1092 rpm"."""
    value, unit = _customary(value, unit)
    name = unit_name(unit)
    gap = "" if name.startswith("°") else SPACE
    return f"{number(value, digits)}{gap}{name}" if name else number(value, digits)


def _customary(value: float, unit: str) -> tuple[float, str]:
    size = abs(value)
    if unit == "rad":
        return degrees(value), "°"
    if unit == "rad/s":
        return value * 30 / pi, "rpm"
    if unit == "m^2" and size < 1e-2:
        return value * 1e6, "mm^2"
    if unit == "m" and 0 < size < 0.1:
        return (value * 1e3, "mm") if size >= 1e-4 else (value * 1e6, "µm")
    if unit in ("kg", "kg/m") and 0 < size < 0.1:
        return value * 1e3, unit.replace("kg", "g")
    if unit in _PREFIXED and size >= 1e3:
        power = min(3 * floor(log10(size) / 3 + 1e-12), 12)
        return value / 10.0**power, _PREFIXES[power] + unit
    if unit in ("N", "N m") and 0 < size < 0.1:
        return value * 1e3, "m" + unit
    return value, unit


_KEPT = re.compile(r"(<(style|script|code|math)\b.*?</\2>|<[^>]+>)", re.S)

_LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_LETTERS = {"chi": "χ", "eps": "ε", "rho": "ρ", "gamma": "γ", "Gamma": "Γ"}

_EXPONENT = re.compile(r"(?<![\w.#])(\d+(?:\.\d+)?)e([+-]?)0*(\d+)(?!\w)")
_POWER = re.compile(r"(?<=[\w)\]])\^(-?\d+)(?![\d.]*\d)")
_MINUS = re.compile(r"(?:(?<=[\s(=\[])|^)-(?=\d)")
_SYMBOL = re.compile(r"\b(chi|eps|rho|[JTr])(\d{1,2})\b|\b([gG]amma)\b")
_MICRO = re.compile(rf"(?<=\d[ {SPACE}])u(?=[ms]\b)")
_ONE = r"(?:[kMGmµ]?(?:N|Hz|Pa|m|s|V|A|W|rad)|k?g|deg|rpm|dB)[²³]?"
_DIVISOR = rf"(?:{_ONE}|\({_ONE}(?: {_ONE})*\))"
_UNIT = re.compile(rf"(?<=[\d⁰¹²³⁴-⁹])[ {SPACE}]((?:%|1/s|{_ONE}(?: {_ONE})*(?:/{_DIVISOR})?)(?![\w/^]))")


def typeset(html: str) -> str:
    """Set the words of well-formed HTML outside tags, code, formulas, styles and scripts."""
    pieces = _KEPT.split(html)
    # two groups of the pattern lie between one stretch of words and the next: what is kept, and its tag
    pieces[::3] = [typeset_words(words) if words.strip() else words for words in pieces[::3]]
    del pieces[2::3]
    return "".join(pieces)


def typeset_words(words: str) -> str:
    """Set words that hold no tags. Returns "3.3 × 10⁻⁵ kg m²" for "3.3e-05 kg m^2"."""
    words = _EXPONENT.sub(lambda m: number(float(m[0]), sum(map(str.isdigit, m[1]))), words)
    words = _POWER.sub(lambda m: m[1].translate(_RAISED), words)
    words = words.replace("+-", "±")
    words = _MINUS.sub("−", words)
    words = _SYMBOL.sub(_symbol, words)
    words = _MICRO.sub("µ", words)
    return _UNIT.sub(lambda m: SPACE + m[1].replace(" ", "\N{NO-BREAK SPACE}"), words)


def capital(words: str) -> str:
    """A capital at the beginning, but not of a key such as motor.torque_limit."""
    first = words.partition(" ")[0]
    return words if "." in first or "_" in first else words[:1].upper() + words[1:]


def _symbol(found: re.Match[str]) -> str:
    if found[3]:
        return _LETTERS[found[3]]
    return _LETTERS.get(found[1], found[1]) + found[2].translate(_LOWERED)
