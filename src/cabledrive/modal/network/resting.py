"""Heavy strings and beams between ends at rest: one count for all ropes and both planes of a span."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cabledrive.mechanics.network.assembly import DIRECTIONS, Network
from cabledrive.modal.mode import HEAVY_STRING, SHALLOW_SAG, TENSIONED_BEAM
from cabledrive.modal.network.component import HeldElement
from cabledrive.modal.network.elastic_links import ElasticLink
from cabledrive.modal.network.structure import ComponentStructure
from cabledrive.modal.solver import Proven


class RestingElement:
    """The modes of one piece of rope, and the links that have them.

    Parameters
    ----------
    network : Network
    held : HeldElement
    """

    def __init__(self, network: Network, held: HeldElement) -> None:
        self.network, self.links = network, held.links
        self.structure = ComponentStructure(held.component)

    def below(self, omega: float) -> int:
        """How many modes of all its links lie below a frequency [rad/s]."""
        return sum(count for _, count in self.links) * self.structure.count(omega)

    @property
    def hangs(self) -> bool:
        """Whether it moves along as well as across."""
        return self.structure.component.elastic[0].hangs

    def each(self, solved: Proven) -> Iterator[Proven]:
        """A mode of one rope as that of every link."""
        own = solved.frame.component
        for link, count in self.links:
            segments = tuple(
                replace(part, links=tuple(_as_of(one, link) for one in part.links)) for part in own.segments
            )
            yield solved._replace(
                multiplicity=count * solved.multiplicity,
                shapes=np.repeat(solved.shapes, count, axis=1),
                frame=replace(solved.frame, component=replace(own, segments=segments)),
            )


def _as_of(link: ElasticLink, number: int) -> ElasticLink:
    """An element as that of another link; a hanging rope has one link across, and is always its own."""
    return link if link.hangs else replace(link, link=number, covers=(number,))


def models_of(network: Network, elastic: dict[int, ElasticLink]) -> dict[tuple[str, str], str]:
    """What the rope of a span is taken for, by span and direction, where it is no even string."""
    found = {}
    for number, link in elastic.items():
        span = network.drive.free_spans[network.pieces[network.piece[number]].span].name
        straight = TENSIONED_BEAM if link.element.bending else HEAVY_STRING
        model = SHALLOW_SAG if link.hangs else straight
        found[span, DIRECTIONS[network.direction[number]]] = model
    return found
