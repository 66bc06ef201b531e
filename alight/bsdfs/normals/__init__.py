"""Shading normals that pictures bend: what they do to directions, and coats of their own."""
