"""What all machines have in common, whichever form their file has."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from cabledrive.answers.result import Result
from cabledrive.parameters.drive_parts import Goal, Motor, Sensors, StatedExcitation
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import check_fields, choice, meaning, words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCHEMA_VERSION = 1
MOST_CARRIAGES = 100_000
WORDS = ("name", "title", "source")


@dataclass(frozen=True, kw_only=True, repr=False)
class MachineBase(Result):
    """Base of drives: names, instruments, goal; a card by the keys that ``--set`` takes, and a drawing."""

    name: str = words("short name")
    sensors: Sensors | None = meaning("encoders and sampling", None)
    goal: Goal | None = meaning("what is asked of it", None)
    excitation: StatedExcitation | None = meaning("what excites it in operation", None)
    title: str = words("what it is", "")
    source: str = words("where its figures come from", "")
    schema: int = choice((SCHEMA_VERSION,), "version of the file format", SCHEMA_VERSION)

    _heading = "{0.name}"

    def __post_init__(self) -> None:
        check_fields(self)
        for key in ("body", "pulley", "anchor", "route", "carriage", "motor"):
            if isinstance(rows := getattr(self, key, None), Iterable):
                object.__setattr__(self, key, tuple(rows))
        check_count(len(self.carriage))  # type: ignore[attr-defined]  # of its own form
        ripple = self.excitation is not None and self.excitation.torque_ripple is not None
        if ripple and not (self.motors and self.motors[0].torque_limit is not None):
            raise InputRefused("excitation.torque_ripple is a share of motor.torque_limit: add that")

    @property
    def motors(self) -> tuple[Motor, ...]:
        """Its motors, in the order of the file."""
        motor: Any = self.motor  # type: ignore[attr-defined]  # of its own form: some, or one or none
        return motor if isinstance(motor, tuple) else () if motor is None else (motor,)

    def plot(self) -> "Figure":
        """Draw the pulleys and the free spans between them to scale, a line of its own colour a route."""
        from matplotlib import patches, pyplot

        machine = self.machine  # type: ignore[attr-defined]  # a drive, of whichever kind
        figure, axes = pyplot.subplots(layout="constrained")
        for span in machine.free_spans:
            axes.plot(*zip(*span.contacts, strict=True), color=f"C{span.route % 10}")
        for pulley in machine.pulley:
            axes.add_patch(patches.Circle(pulley.at, pulley.radius, fill=False))
        axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=self._head)
        return figure


def check_count(carriages: int) -> None:
    """Refuse more than `MOST_CARRIAGES` carriages."""
    if carriages > MOST_CARRIAGES:
        raise InputRefused(
            f"carriage: {carriages} given, at most {MOST_CARRIAGES} are taken: lump some together"
        )
