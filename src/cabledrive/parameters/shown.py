"""What a machine shows of itself in a notebook."""

from typing import TYPE_CHECKING

from cabledrive.answers.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Machine(Result):
    """Base of drives: what is stated, by the keys that ``--set`` takes, and a drawing."""

    _heading = "{0.name}"

    def plot(self) -> "Figure":
        """Draw the pulleys and the free spans between them to scale, a line of its own colour a route.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from matplotlib import patches, pyplot

        from cabledrive.parameters.route.two_pulleys import as_machine

        machine = as_machine(self)  # type: ignore[arg-type]  # a drive, of whichever kind
        figure, axes = pyplot.subplots(layout="constrained")
        for span in machine.free_spans:
            axes.plot(*zip(*span.contacts, strict=True), color=f"C{span.route % 10}")
        for pulley in machine.pulley:
            axes.add_patch(patches.Circle(pulley.at, pulley.radius, fill=False))
        axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=self._head)
        return figure
