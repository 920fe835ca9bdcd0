"""What every result can do: show its main figures, give its numbers as a table, draw them."""

from collections.abc import Mapping
from dataclasses import fields
from functools import reduce
from html import escape
from itertools import chain
from typing import TYPE_CHECKING, Any, ClassVar

from cabledrive.answers.figures import Row, aligned, figures_of, given, key_of, part_of, shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Result:
    """Base of results: a card of the main figures, a table and a drawing."""

    __slots__ = ()
    _heading: ClassVar[str] = ""  # what the card is about, "{0.name}"
    _shown: ClassVar[tuple[Row, ...]] = ()  # figures of the card
    _table: ClassVar[str] = ""  # arrays over an axis, "time: error torque", or the place of rows, "modes"
    _columns: ClassVar[str] = ""  # of rows; default: all their fields

    @property
    def _about(self) -> Any:
        """Where the figures are: a summary, if there is one, else the result."""
        summary = getattr(self, "summary", self)
        return summary() if callable(summary) else summary

    @property
    def figures(self) -> list[tuple[str, str]]:
        """Words and value of each main figure, or key and value of each quantity that is stated."""
        if self._shown:
            return shown(self._shown, self._about)
        values = {key_of(one): getattr(self, one.name) for one in fields(self)}  # type: ignore[arg-type]
        return shown(chain(*figures_of(type(self)).values()), values) or list(given(self))

    @property
    def _head(self) -> str:
        return ": ".join(filter(None, (type(self).__name__, self._heading.format(self))))

    def __repr__(self) -> str:
        return "\n".join([self._head, *aligned(self.figures)])

    def _repr_html_(self) -> str:
        cells = "".join(f"<tr><th>{escape(a)}</th><td>{escape(b)}</td></tr>" for a, b in self.figures)
        listed = self.to_dataframe().to_html() if self._table and ":" not in self._table else ""
        return f"<table><caption>{escape(self._head)}</caption>{cells}</table>{listed}"

    def to_dataframe(self) -> Any:
        """The numbers of the result as a table.

        Returns
        -------
        pandas.DataFrame
            Arrays over their axis, in the units of the attributes of the same names, one column each; else
            one row for each part that the result lists; else its figures.
        """
        from pandas import DataFrame, Index

        over, _, names = self._table.partition(":")
        if not over:
            return DataFrame(self.figures, columns=["figure", "value"]).set_index("figure")
        if names:
            columns: dict[str, Any] = {}
            for name in names.split():
                values = getattr(self, name)
                if isinstance(values, Mapping):
                    columns |= values
                elif values is not None and len(values) == len(getattr(self, over)):  # else it has none
                    many = {f"{name}_{k}": one for k, one in enumerate(values.T)}
                    columns |= many if values.ndim > 1 else {name: values}
            return DataFrame(columns, Index(getattr(self, over), name=over))
        found: Any = reduce(part_of, over.split("."), self)
        rows = found.values() if isinstance(found, Mapping) else found
        listed = [f.name for f in fields(next(iter(rows)))] if rows and not self._columns else []
        table = [{name: part_of(one, name) for name in self._columns.split() or listed} for one in rows]
        return DataFrame(table, list(found) if isinstance(found, Mapping) else None)

    def plot(self) -> "Figure":
        """Draw the numbers of the table, one panel each.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from matplotlib import pyplot

        table = self.to_dataframe().select_dtypes("number")
        figure, axes = pyplot.subplots(
            max(len(table.columns), 1), sharex=True, squeeze=False, layout="constrained"
        )
        for place, (name, values) in zip(axes[:, 0], table.items(), strict=False):
            place.plot(table.index.map(str) if table.index.dtype == object else table.index, values, ".-")
            place.set_ylabel(str(name).replace("_", " "))
        axes[0, 0].set_title(self._head)
        axes[-1, 0].set_xlabel(table.index.name or "")
        return figure
