"""Diffuse surfaces: light that is scattered widely, without a highlight."""
