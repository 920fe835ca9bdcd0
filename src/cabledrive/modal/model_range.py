"""Where the models of the transverse modes hold, and which warnings touch a list of modes."""

from collections.abc import Iterator, Sequence
from math import pi

from cabledrive.mechanics.rest import RestingSection
from cabledrive.mechanics.warnings import warnings_of_rest
from cabledrive.modal.band import Band
from cabledrive.modal.mode import LONGITUDINAL, SHALLOW_SAG, Mode
from cabledrive.modal.plane_spectrum import MOST_SAGGING_JOINTS
from cabledrive.modal.resting_modes import RestingBand
from cabledrive.parameters import Drive

INCOMPLETE = "the count gives more modes than could be found and proven"

LARGEST_SAG = 0.05
"""Sag of a section over its length up to which the shallow theory is used."""

SHIFTED = 1e-4
"""Relative shift of a longitudinal mode by sag above which it is said."""


def model_limit(drive: Drive, listed: Sequence[Mode], across: Band, bound: float) -> str | None:
    """Why the list is not certified although the count agrees: a model outside its range.

    ``bound``: frequency up to which the list is complete [rad/s].
    """
    if not isinstance(across, RestingBand):
        return None
    if across.slack:
        return _slack_line(across.slack[0])
    if across.too_many:
        return (
            f"more than {MOST_SAGGING_JOINTS} carriages and pulleys: the modes in the plane of gravity are "
            "without sag; take fewer carriages"
        )
    deepest = max(across.rest.sections, key=lambda section: section.sag_ratio)
    if deepest.sag_ratio > LARGEST_SAG and any(mode.model == SHALLOW_SAG for mode in listed):
        return (
            f"the {deepest.span} span sags by {deepest.sag:.4g} m, {100 * deepest.sag_ratio:.3g}% of its "
            f"length: the theory of shallow sag is used up to {LARGEST_SAG:.0%}; raise cable.pretension"
        )
    return None


def mode_warnings(drive: Drive, listed: Sequence[Mode], across: Band, bound: float) -> tuple[str, ...]:
    """Warnings that touch a list of modes.

    ``bound``: frequency up to which the list is complete [rad/s].
    Returns one line each.
    """
    return (*warnings_of_rest(drive), *_sagging(listed, across, bound))


def _sagging(listed: Sequence[Mode], across: Band, bound: float) -> Iterator[str]:
    """What sag does to the longitudinal modes, which are listed for the taut cable."""
    if not isinstance(across, RestingBand):
        return
    if across.slack:
        yield _slack_line(across.slack[0]) + "; its transverse modes are not listed"
    with_sag = across.along_with_sag(bound)
    taut = [m.frequency for m in listed if m.kind == LONGITUDINAL and 2 * pi * m.frequency < bound]
    for own in taut:
        nearest = min(with_sag, key=lambda other: abs(other - own), default=None)
        if nearest is not None and abs(nearest / own - 1.0) > SHIFTED:
            yield (
                f"the longitudinal mode at {own:.5g} Hz is listed for the taut cable: sag moves it to "
                f"{nearest:.5g} Hz"
            )


def _slack_line(section: RestingSection) -> str:
    return (
        f"the {section.span} span hangs slack at rest between {section.start:.4g} m and {section.end:.4g} m, "
        f"lowest tension {section.lowest_tension:.4g} N: raise cable.pretension"
    )
