"""A printed number or claim beside what is computed, and the verdict."""

from reproduction.item import (
    AGREES,
    DIFFERS,
    ERRATUM,
    NOT_COMPARABLE,
    NOT_COMPUTABLE,
    UNEXPLAINED,
    Item,
    Otherwise,
)

INPUT = "a measured or chosen input: what the packaged drive holds"


def compared(
    name: str,
    source: str,
    printed: str,
    computed: float,
    unit: str,
    *,
    tolerance: float = 0.0,
    note: str = "",
    otherwise: Otherwise = (DIFFERS, UNEXPLAINED),
    tested: bool = True,
) -> Item:
    """A printed number beside a computed one: it agrees inside the print's rounding or a stated tolerance.

    ``name``: becomes the id; ``printed``: digits as printed; ``tolerance``: in the unit, beyond the rounding;
    ``note``: where it agrees; ``otherwise``: verdict and reason where it does not; ``tested``: whether
    `computed` comes from a computation and not from printed values.
    """
    value = float(printed)
    half = 0.5 * last_place(printed)
    good = abs(computed - value) <= max(half, tolerance) * (1 + 1e-9)
    inside = f"inside {tolerance:.3g} {unit}".strip() if tolerance > half else "inside the print's rounding"
    return Item(
        id=name,
        source=source,
        printed=value,
        computed=float(computed),
        unit=unit,
        deviation=None if value == 0.0 else float(computed) / value - 1.0,
        verdict=AGREES if good else otherwise[0],
        note=(f"{inside}; {note}" if note else inside) if good else otherwise[1],
        tested=tested,
    )


def last_place(printed: str) -> float:
    """Value of the last printed digit.

    ``printed``: such as "0.0011", "7.316e-6" or "1000".
    """
    mantissa, _, exponent = printed.lower().partition("e")
    return float(10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2])))


def claimed(
    name: str,
    source: str,
    printed: str,
    computed: str,
    holds: bool,
    *,
    otherwise: Otherwise,
    note: str = "",
    tested: bool = True,
) -> Item:
    """A claim in words beside what is found.

    ``name``: becomes the id; ``printed``, ``computed``: the claim, and what is found; ``otherwise``: verdict
    and reason where it does not hold; ``note``: where it does; ``tested``: whether what is found comes from a
    computation and not from the print alone.
    """
    return Item(
        id=name,
        source=source,
        printed=printed,
        computed=computed,
        unit="",
        deviation=None,
        verdict=AGREES if holds else otherwise[0],
        note=(note or "the claim holds") if holds else otherwise[1],
        tested=tested,
    )


def erratum(
    name: str, source: str, printed: float | str, computed: float | str | None, unit: str, why: str
) -> Item:
    """A printed number or claim that the derivation contradicts.

    ``name``: becomes the id; ``why``: with the place of the derivation.
    """
    numbers = isinstance(printed, float) and isinstance(computed, float) and printed != 0.0
    deviation = float(computed) / float(printed) - 1.0 if numbers else None  # type: ignore[arg-type]
    return Item(
        id=name,
        source=source,
        printed=printed,
        computed=computed,
        unit=unit,
        deviation=deviation,
        verdict=ERRATUM,
        note=why,
        tested=False,
    )


def not_comparable(name: str, source: str, printed: float, computed: float, unit: str, why: str) -> Item:
    """A printed and a computed figure whose conditions differ: both are shown, and neither is judged.

    ``name``: becomes the id; ``why``: what of the print's conditions is lost.
    """
    return Item(
        id=name,
        source=source,
        printed=printed,
        computed=computed,
        unit=unit,
        deviation=computed / printed - 1.0,
        verdict=NOT_COMPUTABLE,
        note=f"{NOT_COMPARABLE}: {why}",
        tested=False,
    )


def unknown(name: str, source: str, printed: str | float | None, unit: str, why: str) -> Item:
    """Something that cannot be computed.

    ``name``: becomes the id.
    """
    return Item(
        id=name,
        source=source,
        printed=printed,
        computed=None,
        unit=unit,
        deviation=None,
        verdict=NOT_COMPUTABLE,
        note=why,
        tested=False,
    )


def taken(name: str, source: str, printed: str, used: float, unit: str, note: str = "") -> Item:
    """A parameter that is an input: the value this package uses for it.

    ``name``: becomes the id; ``printed``: digits as printed.
    """
    words = f"{INPUT}; {note}" if note else INPUT
    return compared(name, source, printed, used, unit, note=words, tested=False)
