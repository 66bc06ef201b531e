"""The light tree: chooses a light for a point."""
