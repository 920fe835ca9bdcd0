"""The last touch on a page.

Powers and indices are raised and lowered, a minus is a minus, and no line ends between a number and its unit.
Formulas, code, styles and scripts stay as they are, and so does what stands inside a tag.
"""

import re

from cabledrive.answers.figures import RAISED, SPACE, number

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
    words = _POWER.sub(lambda m: m[1].translate(RAISED), words)
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
