"""A diffuse base with a highlight: clear coats over it, and Phong's lobe."""
