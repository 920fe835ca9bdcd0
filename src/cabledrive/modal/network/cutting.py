"""Elements of one kind of a component, cut for a range of frequencies."""

from collections.abc import Sequence

from cabledrive.modal.network.elastic_links import ElasticLink
from cabledrive.modal.network.hanging_segments import hanging_segments
from cabledrive.modal.network.segments import Segments
from cabledrive.modal.network.wave_segments import beam_segments, string_segments


def segments_of(links: Sequence[ElasticLink], octaves: Sequence[int], first: int) -> tuple[Segments, int]:
    """The segments of elements of one kind; their joints are coordinates behind those of the component.

    ``octaves``: each link serves up to 2^octave rad of phase; ``first``: coordinate of the first joint.
    Returns them, and the coordinate after the last joint.
    """
    if links[0].hangs:
        return hanging_segments(links, octaves, first)
    return (beam_segments if links[0].element.bending else string_segments)(links, octaves, first)
