"""What a terminal shows: a line that the next one covers, and a result in a few lines."""

import sys
from abc import ABC, abstractmethod
from html import escape


def on_a_terminal() -> bool:
    """Whether somebody may be looking: standard error is a terminal; a closed one is none."""
    return sys.stderr is not None and sys.stderr.isatty()


class TerminalLine:
    """A line that is rewritten in place and cleared at the end."""

    def __init__(self) -> None:
        self._width = 0

    def write(self, line: str) -> None:
        """Show a line over the one before, all of it."""
        print(f"\r{line:<{self._width}}", end="", file=sys.stderr, flush=True)
        self._width = len(line)

    def clear(self) -> None:
        """Leave nothing behind."""
        if self._width:
            self.write("")
            print("\r", end="", file=sys.stderr, flush=True)


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
