"""Hair and fur."""
