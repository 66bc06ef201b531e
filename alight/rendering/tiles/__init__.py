"""Tiles: how a film is cut into them, and the loop that renders one."""
