"""Controllers, plants and loops for other programs: C99, FMU, MuJoCo, Modelica, printer firmware."""

from cabledrive.export.door import export_to

__all__ = ["export_to"]
