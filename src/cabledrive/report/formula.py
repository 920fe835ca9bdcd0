"""Formulas as MathML, put together from small parts: no script, no network, read aloud by screen readers."""

from markupsafe import Markup, escape

Part = str | Markup


def _part(part: Part) -> Markup:
    """Markup as it is; a number, an operator or a letter in the element where it belongs."""
    if isinstance(part, Markup):
        return part
    if part.replace(".", "", 1).isdigit():
        return Markup("<mn>{}</mn>").format(part)
    if part.isalpha():
        return Markup("<mi>{}</mi>").format(part)
    return Markup("<mo>{}</mo>").format(part)


def row(*parts: Part) -> Markup:
    """Parts side by side. ``*parts``: letters, numbers, operators, or parts made by the functions here."""
    return Markup("<mrow>{}</mrow>").format(Markup("").join(map(_part, parts)))


def sub(base: Part, index: Part) -> Markup:
    """A letter with an index."""
    return Markup("<msub>{}{}</msub>").format(_part(base), _part(index))


def power(base: Part, exponent: Part) -> Markup:
    """A power."""
    return Markup("<msup>{}{}</msup>").format(_part(base), _part(exponent))


def fraction(above: Part, below: Part) -> Markup:
    """A fraction."""
    return Markup("<mfrac>{}{}</mfrac>").format(_part(above), _part(below))


def root(*parts: Part) -> Markup:
    """A square root."""
    return Markup("<msqrt>{}</msqrt>").format(row(*parts))


def total(index: Part, *parts: Part) -> Markup:
    """A sum over an index. ``index``: the index that runs; ``*parts``: what is summed."""
    return Markup("<munder><mo>∑</mo>{}</munder>{}").format(_part(index), row(*parts))


def inline(*parts: Part) -> Markup:
    """A formula inside running text. Returns a ``math`` element."""
    return Markup("<math>{}</math>").format(row(*parts))


def block(formula: Markup, words: str) -> Markup:
    """A displayed formula. ``words``: the formula as it is read aloud. Returns a ``math`` element."""
    return Markup('<math display="block" aria-label="{}">{}</math>').format(escape(words), formula)


MODE_COUNT = row(
    "J", "(", "ω", ")", "=", "s", "{", "K", "(", "ω", ")", "}", "+",
    total("i", "⌊", fraction(row("ω", sub("l", "i")), row("π", "c")), "⌋"),
)  # fmt: skip
"""The count of Wittrick and Williams."""
