"""What the certificate of a list of modes says, in plain words."""

from cabledrive.modal import Modes
from cabledrive.modal.model_range import INCOMPLETE
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
    """A count with its noun.

    ``what``: noun in the singular, regular in the plural.
    Returns "one mode", "157 modes".
    """
    shown = _SMALL[count] if count < len(_SMALL) else f"{count}"
    return f"{shown} {what}" if count == 1 else f"{shown} {what}s"


def certificate_words(modes: Modes) -> str:
    """The certificate of a list of modes as a reader takes it."""
    proof = modes.certificate
    below = f"{number(proof.below, 6)} Hz"
    held = (
        f"Below {below} this machine has exactly {count_words(proof.count, 'natural mode')}: "
        f"{proof.longitudinal} along the cable and {proof.transverse} across it, both planes counted"
    )
    rigid = (
        "Besides them it has one motion that strains nothing, at 0 Hz: everything turns together."
        if modes.rigid_body_modes
        else "No motion leaves the cable unstrained: an end is held."
    )
    if modes.certified:
        return (
            f"{held}. The list holds all of them. That number comes from a count that does not look at the "
            f"list, and two such counts, {number(proof.enclosure, 1)} of the frequency to either side, "
            f"enclose every mode. {rigid}"
        )
    if modes.certified_reason != INCOMPLETE:
        return f"{held}, by the model taken for it. It is not certified: {modes.certified_reason}. {rigid}"
    doubt = "The list could not be proven to hold all of them; do not rely on its being complete."
    return f"{held}. {doubt} {rigid}"
