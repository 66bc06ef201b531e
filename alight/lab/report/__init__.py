"""Reports: one HTML file that needs no network, and the same numbers as CSV and JSON."""

from alight.lab.report.page import write_report

__all__ = ["write_report"]
