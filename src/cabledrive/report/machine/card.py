"""The card of a machine on the first page: verdict, lowest modes, warnings."""

from collections.abc import Callable
from typing import Any, Protocol

from cabledrive.modal import Mode, Modes
from cabledrive.report.machine.internal_resonance import ResonanceVerdict
from cabledrive.report.numbers import number
from cabledrive.report.views import Badge, Card

Fact = tuple[str, str]


class MachineContent(Protocol):
    """What a card needs of the page behind it."""

    @property
    def drive(self) -> Any:
        """A drive of any kind."""

    @property
    def modes(self) -> Modes:
        """Its first modes."""

    @property
    def resonance(self) -> ResonanceVerdict:
        """Its internal resonance."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What its user should know."""


def machine_card(page: MachineContent, sketch: Any, fact: Callable[[str, tuple[Mode, ...]], Fact]) -> Card:
    """The card that leads to a page; ``fact``: the lowest of some modes in words."""
    certificate = page.modes.certificate
    below = f"{number(certificate.below, 4)} Hz"
    complete = Badge(text=f"Modes complete up to {below}", tone="good")
    doubtful = Badge(text=f"Modes up to {below} not certified", tone="warning")
    facts = [fact("Longitudinal", page.modes.longitudinal), fact("Transverse", page.modes.transverse)]
    if page.warnings:
        facts.append(("Warnings", f"{len(page.warnings)}"))
    return Card(
        text=page.drive.title,
        picture=sketch,
        badges=(complete if page.modes.certified and certificate.count else doubtful, page.resonance.badge),
        facts=tuple(facts),
    )
