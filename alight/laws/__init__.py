"""The laws that every model must obey, for our own models and for those that users register."""

from alight.laws.check import check_laws
from alight.laws.report import BrokenLawError, Report, Result

__all__ = ["BrokenLawError", "Report", "Result", "check_laws"]
