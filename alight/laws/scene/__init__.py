"""The laws for a user's own scene: its materials, lights, random numbers, and its picture."""

from alight.laws.scene.check import check, check_scene
from alight.laws.scene.findings import Finding, Verdict

__all__ = ["Finding", "Verdict", "check", "check_scene"]
