"""Boundaries of clear bodies: glass, water, panes; their indices and dispersion."""
