"""A mass carried by the cable."""

from dataclasses import dataclass

from cabledrive.parameters.fields import check_fields, choice, quantity, words


@dataclass(frozen=True, slots=True, kw_only=True)
class Carriage:
    """A point mass clamped to the cable.

    Attributes
    ----------
    mass : float
        Mass m [kg].
    position : float
        Unstretched distance [m] from the pulley at which the span starts (upper: drive, lower: load).
    span : {"upper", "lower"}, default "upper"
        The span that carries it.
    guided : bool, default True
        Rides on a rail and so has no transverse motion; False: it hangs on the cable.
    name : str, default ""
        Name by which it can be called, among the carriages of a drive its own; no part of the content hash.
    coupled : str, default ""
        Name of another carriage that moves together with this one, or "carriage 0" by its number in the file.
    direction : {1, -1}, default 1
        Whether the positions of the two grow together or against each other. Two carriages clamped to one
        loop, one on each span, have 1: each position counts from the pulley where its span starts.
    """

    mass: float = quantity("kg", "positive", "mass clamped to the cable")
    position: float = quantity("m", "positive", "unstretched distance from the pulley where its span starts")
    span: str = choice(("upper", "lower"), "the span that carries it", "upper")
    guided: bool = choice(
        (False, True), "rides on a rail (no transverse motion); false: hangs on the cable", True
    )
    name: str = words("name by which it can be called", "")
    coupled: str = words("name of the carriage that moves together with this one", "")
    direction: int = choice(
        (1, -1), "whether their positions grow together (1) or against each other (-1)", 1
    )

    def __post_init__(self) -> None:
        check_fields(self)
