"""Chapters with tables and figures on one self-contained page."""

from cabledrive.report.writing import report_html, write_report

__all__ = ["report_html", "write_report"]
