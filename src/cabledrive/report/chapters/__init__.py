"""The studies of the report, one file each: a card in the overview and the page behind it.

A chapter is a module here with a number ``PLACE`` that orders it and a function ``chapter(context)`` that
returns a `Chapter`, or None where it has nothing to say about the drives of this report. Adding the file adds
the chapter.
"""

import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise

from cabledrive.report.blocks import Chapter
from cabledrive.report.context import ReportContext
from cabledrive.report.views import TOPICS, Card, View


@dataclass(frozen=True, slots=True, kw_only=True)
class ChapterEntry:
    """A chapter in the registry.

    Attributes
    ----------
    place : int
        Chapters follow one another in ascending order.
    name : str
        Name of the module.
    write : callable
        The function ``chapter(context)`` of the module.
    """

    place: int
    name: str
    write: Callable[[ReportContext], Chapter | None]


def registry() -> tuple[ChapterEntry, ...]:
    """All chapters in the order in which they are read.

    Raises `ValueError` if two chapters claim one place.
    """
    entries = []
    for found in pkgutil.iter_modules(__path__):
        module = import_module(f"{__name__}.{found.name}")
        entries.append(ChapterEntry(place=module.PLACE, name=found.name, write=module.chapter))
    entries.sort(key=lambda entry: entry.place)
    for first, second in pairwise(entries):
        if first.place == second.place:
            raise ValueError(f"chapters {first.name} and {second.name} both have PLACE = {first.place}")
    return tuple(entries)


def topic_views(context: ReportContext) -> tuple[View, ...]:
    """A page for every chapter that has something to say of the drives of a report."""
    written = []
    for entry in registry():
        context.progress(f"study: {entry.name.replace('_', ' ')}")
        chapter = entry.write(context)
        if chapter is not None:
            written.append(_view(chapter))
    return tuple(written)


def _view(chapter: Chapter) -> View:
    return View(
        anchor=chapter.anchor,
        title=chapter.title,
        group=TOPICS,
        card=Card(text=chapter.summary or chapter.headline),
        template="topic.html",
        content=chapter,
        blocks=chapter.all_blocks,
        methods=chapter.methods,
    )
