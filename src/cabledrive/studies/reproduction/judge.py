"""A printed number or claim beside what is computed, and the verdict."""

from cabledrive.studies.reproduction.item import (
    AGREES,
    DIFFERS,
    ERRATUM,
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
) -> Item:
    """A printed number beside a computed one: it agrees inside the print's rounding or a stated tolerance.

    Parameters
    ----------
    name : str
        Becomes the id.
    source : str
    printed : str
        Digits as printed.
    computed : float
    unit : str
    tolerance : float, default 0.0
        In the unit, beyond the rounding.
    note : str, default ""
        Where it agrees.
    otherwise : (str, str)
        Verdict and reason where it does not.

    Returns
    -------
    Item
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
    )


def last_place(printed: str) -> float:
    """Value of the last printed digit.

    Parameters
    ----------
    printed : str
        Such as "0.0011", "7.316e-6" or "1000".

    Returns
    -------
    float
    """
    mantissa, _, exponent = printed.lower().partition("e")
    return float(10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2])))


def claimed(
    name: str, source: str, printed: str, computed: str, holds: bool, *, otherwise: Otherwise, note: str = ""
) -> Item:
    """A claim in words beside what is found.

    Parameters
    ----------
    name : str
        Becomes the id.
    source : str
    printed, computed : str
        The claim, and what is found.
    holds : bool
    otherwise : (str, str)
        Verdict and reason where it does not hold.
    note : str, default ""
        Where it does.

    Returns
    -------
    Item
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
    )


def erratum(
    name: str, source: str, printed: float | str, computed: float | str | None, unit: str, why: str
) -> Item:
    """A printed number or claim that the derivation contradicts.

    Parameters
    ----------
    name : str
        Becomes the id.
    source : str
    printed, computed : float, str or None
    unit : str
    why : str
        With the place of the derivation.

    Returns
    -------
    Item
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
    )


def unknown(name: str, source: str, printed: str | float | None, unit: str, why: str) -> Item:
    """Something that cannot be computed.

    Parameters
    ----------
    name : str
        Becomes the id.
    source : str
    printed : float, str or None
    unit : str
    why : str

    Returns
    -------
    Item
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
    )


def taken(name: str, source: str, printed: str, used: float, unit: str, note: str = "") -> Item:
    """A parameter that is an input: the value this package uses for it.

    Parameters
    ----------
    name : str
        Becomes the id.
    source : str
    printed : str
        Digits as printed.
    used : float
    unit : str
    note : str, default ""

    Returns
    -------
    Item
    """
    return compared(name, source, printed, used, unit, note=f"{INPUT}; {note}" if note else INPUT)
