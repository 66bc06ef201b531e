"""Caustics: chains of mirrors and clear glass between a surface and a lamp."""
