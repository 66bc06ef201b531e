"""Warnings of what is legal but suspicious in a scene, and shows only in its tables."""
