"""Names that can stand in a link."""

import re
import unicodedata
from collections.abc import Sequence


def anchor(title: str) -> str:
    """A title as the name of a place on the page: lower-case letters first, digits and hyphens."""
    plain = unicodedata.normalize("NFKD", title).encode("ascii", "ignore").decode().lower()
    words = re.sub(r"[^a-z0-9]+", "-", plain).strip("-")
    return words if words[:1].isalpha() else f"drive-{words}".rstrip("-")


def anchors(titles: Sequence[str]) -> tuple[str, ...]:
    """Anchors of several titles, numbered where they would be the same. Returns all different."""
    taken: list[str] = []
    for title in titles:
        name, number = anchor(title), 2
        while name in taken:
            name, number = f"{anchor(title)}-{number}", number + 1
        taken.append(name)
    return tuple(taken)
