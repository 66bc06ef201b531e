"""Paths from both ends: light subpaths, camera subpaths, and how they are joined."""
