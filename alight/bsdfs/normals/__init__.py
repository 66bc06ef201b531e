"""Shading normals from pictures: normal maps, bump maps, coats with normals of their own."""
