"""The natural modes of a drive as a table to read."""

from collections.abc import Iterator, Sequence

from cabledrive.modal.certified import Modes
from cabledrive.modal.mode import LONGITUDINAL, TRANSVERSE
from cabledrive.modal.mode_rows import ModeRow, mode_rows
from cabledrive.modal.ranges import INCOMPLETE

HEADER = ("frequency [Hz]", "modes", "kind", "family", "where")


def mode_table(found: Modes) -> str:
    """Table of the modes, what repeats in both planes and spans in one row, and the certificate below it.

    Returns lines of text; the first is the header.
    """
    rows = [HEADER, *(_cells(row) for row in mode_rows(found))]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    below = [certificate_line(found), *_remarks(found)]
    return "\n".join([*(_line(row, widths) for row in rows), "", *below])


def certificate_line(found: Modes) -> str:
    """Completeness of a list of modes, in one sentence."""
    proof = found.certificate
    held = f"{proof.count} modes ({proof.longitudinal} longitudinal, {proof.transverse} transverse)"
    if found.certified:
        return f"Complete up to {proof.below:.8g} Hz (certified): {held}."
    if found.certified_reason != INCOMPLETE:
        return f"Not certified: {found.certified_reason}. Count up to {proof.below:.8g} Hz: {held}."
    return f"NOT complete: {held} exist up to {proof.below:.8g} Hz; the list lacks some of them."


def _remarks(found: Modes) -> Iterator[str]:
    """What the rows do not show."""
    proof = found.certificate
    reached = ((LONGITUDINAL, proof.longitudinal_below), (TRANSVERSE, proof.transverse_below))
    for kind, below in reached:
        if any(mode.frequency > proof.below for mode in found.modes if mode.kind == kind):
            yield f"{kind.capitalize()} modes alone are listed up to {below:.8g} Hz."
    yield from (f"Transverse modes: {line}." for line in [_models(found)] if line)
    yield from (f"Warning: {line}." for line in found.warnings)
    if found.rigid_body_modes:
        yield f"Rigid-body modes not listed: {found.rigid_body_modes}."


def _models(found: Modes) -> str:
    """What the cable is taken for in each plane."""
    planes = (
        (plane, sorted({m.model or "" for m in found.transverse if m.plane == plane})) for plane in "wv"
    )
    words = {"w": "in the plane of gravity", "v": "across it"}
    parts = [(words[plane], " and ".join(models)) for plane, models in planes if models]
    if len({models for _, models in parts}) == 1:
        return parts[0][1]
    return "; ".join(f"{models} {plane}" for plane, models in parts)


def _cells(row: ModeRow) -> tuple[str, ...]:
    return f"{row.frequency:.9g}", str(row.count), row.kind, row.family, row.where


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    frequency, count, *words = row
    cells = [frequency.rjust(widths[0]), count.rjust(widths[1])]
    cells += [word.ljust(width) for word, width in zip(words, widths[2:], strict=True)]
    return "  ".join(cells).rstrip()
