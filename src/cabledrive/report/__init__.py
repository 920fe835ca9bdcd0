"""Chapters with tables and figures on one self-contained page."""

from typing import TYPE_CHECKING

from cabledrive.parameters.on_demand import on_demand

if TYPE_CHECKING:
    from cabledrive.report.writing import report_html, write_report

# Loaded when first asked for: commands that only need this room's words start in half the time.
__getattr__ = on_demand(__name__, {"report_html": "writing", "write_report": "writing"})

__all__ = ["report_html", "write_report"]
