"""What the certificate of a list of modes says, in plain words."""

from cabledrive.modal import Modes
from cabledrive.modal.ranges import INCOMPLETE
from cabledrive.report.numbers import number

_SMALL = (
    "no",
    "one",
    "two",
    "three",
    "four",
    "five",
    "six",
    "seven",
    "eight",
    "nine",
    "ten",
    "eleven",
    "twelve",
)


def count_words(count: int, what: str) -> str:
    """A count with its noun, regular in the plural: "one mode", "157 modes"."""
    shown = _SMALL[count] if count < len(_SMALL) else f"{count}"
    return f"{shown} {what}" if count == 1 else f"{shown} {what}s"


def certificate_words(modes: Modes) -> str:
    """The certificate of a list of modes as a reader takes it."""
    proof = modes.certificate
    below = f"{number(proof.below, 6)} Hz"
    held = (
        f"Up to {below} this machine has exactly {count_words(proof.count, 'natural mode')}: "
        f"{proof.longitudinal} longitudinal and {proof.transverse} transverse, both planes counted"
    )
    rigid = _rigid_words(modes.rigid_body_modes)
    if modes.certified:
        return (
            f"{held}. All are listed. The number comes from a count that is independent of the list; two "
            f"such counts, {number(proof.enclosure, 1)} of the frequency to either side, enclose each "
            f"mode. {rigid}"
        )
    if modes.certified_reason != INCOMPLETE:
        return f"{held}, according to the model used. Not certified: {modes.certified_reason}. {rigid}"
    doubt = "The list may be incomplete: the count could not be reached."
    return f"{held}. {doubt} {rigid}"


def _rigid_words(count: int) -> str:
    if count == 0:
        return "It has no rigid-body mode (0 Hz)."
    if count == 1:
        return "It also has one rigid-body mode (0 Hz), in which all parts turn together."
    return f"It also has {count_words(count, 'rigid-body mode')} (0 Hz), motions that strain nothing."
