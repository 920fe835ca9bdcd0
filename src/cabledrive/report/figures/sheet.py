"""Elements of a line drawing in SVG, their colours variables of the page."""

from dataclasses import dataclass, field

from markupsafe import Markup, escape

Point = tuple[float, float]


@dataclass(slots=True)
class Sheet:
    """A sheet on which lines, circles and words are drawn, y downwards, in pixels."""

    elements: list[str] = field(default_factory=list)  # what has been drawn so far
    wordless: bool = False  # whether words are left out

    def line(self, *points: Point, colour: str = "ink", width: float = 1.2, dashes: str = "") -> None:
        """A line through points; width and dashes with gaps [px]."""
        path = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in points)
        self.path(path, colour=colour, width=width, dashes=dashes)

    def path(
        self, path: str, *, colour: str = "ink", width: float = 1.2, fill: str = "none", dashes: str = ""
    ) -> None:
        """A path in the language of SVG; width and dashes with gaps [px]."""
        inside = fill if fill == "none" else f"var(--{fill})"
        dashed = f"; stroke-dasharray: {dashes}" if dashes else ""
        self.elements.append(
            f'<path d="{path}" style="fill: {inside}; stroke: var(--{colour}); stroke-width: {width:g}; '
            f'stroke-linecap: round; stroke-linejoin: round{dashed}"/>'
        )

    def circle(
        self, centre: Point, radius: float, *, colour: str = "ink", width: float = 1.2, fill: str = "none"
    ) -> None:
        """A circle; radius and width of its line [px]."""
        inside = fill if fill == "none" else f"var(--{fill})"
        self.elements.append(
            f'<circle cx="{centre[0]:.1f}" cy="{centre[1]:.1f}" r="{radius:.1f}" '
            f'style="fill: {inside}; stroke: var(--{colour}); stroke-width: {width:g}"/>'
        )

    def box(self, centre: Point, size: Point, *, colour: str = "ink", fill: str = "card") -> None:
        """An upright box with rounded corners, width and height [px]."""
        x, y = centre[0] - size[0] / 2, centre[1] - size[1] / 2
        self.elements.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{size[0]:.1f}" height="{size[1]:.1f}" rx="2" '
            f'style="fill: var(--{fill}); stroke: var(--{colour}); stroke-width: 1.2"/>'
        )

    def words(
        self, text: str, at: Point, *, anchor: str = "middle", colour: str = "ink", size: float = 12.0
    ) -> None:
        """Words, one line, that start, are centred ("middle") or end at a point; size of the letters [px]."""
        if self.wordless:
            return
        self.elements.append(
            f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" style="font: {size:g}px var(--sans); '
            f'text-anchor: {anchor}; fill: var(--{colour})">{escape(text)}</text>'
        )

    def arrow(self, start: Point, end: Point, *, colour: str = "ink", width: float = 1.2) -> None:
        """A straight arrow. ``colour``: name of a colour of the page; ``width``: of the line [px]."""
        dx, dy = end[0] - start[0], end[1] - start[1]
        length = max((dx**2 + dy**2) ** 0.5, 1e-9)
        dx, dy = dx / length, dy / length
        back = (end[0] - 7 * dx, end[1] - 7 * dy)
        left, right = ((back[0] - side * 3.2 * dy, back[1] + side * 3.2 * dx) for side in (1, -1))
        self.line(start, back, colour=colour, width=width)
        head = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in (end, left, right)) + " Z"
        self.path(head, colour=colour, width=0.6, fill=colour)

    def svg(self, size: Point) -> Markup:
        """The sheet as part of a page. ``size``: width and height [px]. Returns an ``svg`` element."""
        width, height = size
        return Markup(
            f'<svg viewBox="0 0 {width:g} {height:g}" style="max-width: {width:g}px" aria-hidden="true">'
            + "\n".join(self.elements)
            + "</svg>"
        )
