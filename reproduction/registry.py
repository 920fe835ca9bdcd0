"""Every numbered table and figure of the dissertation, and what computes it anew."""

from importlib import import_module

from reproduction.item import Entry

MODULES = (
    "chapter_2",
    "chapter_3_tables",
    "chapter_3_figures",
    "chapter_4_setup",
    "chapter_4_estimates",
    "chapter_4_responses",
    "chapter_5",
    "chapter_6_models",
    "chapter_6_rig",
    "chapter_7",
    "appendix",
)


def _figures(chapter: int, *ranges: tuple[int, int]) -> list[str]:
    return [f"Fig. {chapter}.{number}" for low, high in ranges for number in range(low, high + 1)]


TABLES = tuple(
    f"Table {number}" for number in ["3.1", "3.2", "4.1", "4.2", "6.1", "6.2", "6.3", "A.1", "A.2", "A.3"]
)
FIGURES = (
    *_figures(3, (1, 6), (8, 10)),
    *_figures(4, (6, 17), (19, 19), (21, 21)),
    *_figures(5, (2, 7)),
    *_figures(6, (1, 1), (3, 3), (5, 29)),
)
"""Figures whose data the text defines; the others are photographs and sketches."""

SKETCHES = (
    *_figures(1, (1, 2)),
    *_figures(2, (1, 3)),
    *_figures(3, (7, 7), (11, 13)),
    *_figures(4, (1, 5), (18, 18), (20, 20)),
    *_figures(5, (1, 1)),
    *_figures(6, (2, 2), (4, 4)),
)
"""Sketches, schemes and photographs, which hold no data."""


def entries() -> tuple[Entry, ...]:
    """All entries, in the order of the print."""
    return tuple(entry for name in MODULES for entry in import_module(f"{__package__}.{name}").ENTRIES)
