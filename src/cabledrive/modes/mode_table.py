"""The natural modes of a drive as a table to read."""

from collections.abc import Iterator, Sequence

from cabledrive.modes.mode_rows import ModeRow, mode_rows
from cabledrive.modes.natural import Modes

HEADER = ("frequency [Hz]", "modes", "kind", "family", "where")


def mode_table(found: Modes) -> str:
    """Table of the modes, what repeats in both planes and spans in one row, and the certificate below it.

    Parameters
    ----------
    found : Modes

    Returns
    -------
    str
        Lines of text; the first is the header.
    """
    rows = [HEADER, *(_cells(row) for row in mode_rows(found))]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    below = [certificate_line(found), *_remarks(found)]
    return "\n".join([*(_line(row, widths) for row in rows), "", *below])


def certificate_line(found: Modes) -> str:
    """What is certified of a list of modes, in one sentence.

    Parameters
    ----------
    found : Modes

    Returns
    -------
    str
    """
    proof = found.certificate
    held = f"{proof.count} modes below {proof.below:.8g} Hz ({proof.longitudinal} longitudinal, "
    held += f"{proof.transverse} transverse)"
    if found.certified:
        return f"Certified: {held}, none is missing."
    return f"NOT certified: the count gives {held}; the list does not hold them all."


def _remarks(found: Modes) -> Iterator[str]:
    """What the rows do not tell."""
    above = {mode.kind for mode in found.modes if mode.frequency > found.certificate.below}
    if above:
        yield f"Above that frequency the list holds {' and '.join(sorted(above))} modes only."
    if found.rigid_body_modes:
        yield f"Not listed: motions of the whole drive that strain nothing ({found.rigid_body_modes})."


def _cells(row: ModeRow) -> tuple[str, ...]:
    return f"{row.frequency:.9g}", str(row.count), row.kind, row.family, row.where


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    frequency, count, *words = row
    cells = [frequency.rjust(widths[0]), count.rjust(widths[1])]
    cells += [word.ljust(width) for word, width in zip(words, widths[2:], strict=True)]
    return "  ".join(cells).rstrip()
