"""How a result shows itself: a few lines in a terminal, a table in a notebook."""

from abc import ABC, abstractmethod
from html import escape


class ResultCard(ABC):
    """Base of results that show their main figures instead of all their arrays."""

    __slots__ = ()

    @abstractmethod
    def _card(self) -> list[tuple[str, str]]:
        """Heading and its text, then name and value of each figure."""

    def __repr__(self) -> str:
        (kind, title), *rows = self._card()
        width = max((len(name) for name, _ in rows), default=0)
        return "\n".join([f"{kind}: {title}", *(f"  {name:<{width}}  {value}" for name, value in rows)])

    def _repr_html_(self) -> str:
        (kind, title), *rows = self._card()
        body = "".join(f"<tr><th>{escape(name)}</th><td>{escape(value)}</td></tr>" for name, value in rows)
        return f"<table><caption>{escape(kind)}: {escape(title)}</caption>{body}</table>"
