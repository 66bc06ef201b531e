"""Triangle meshes: their files, one format a file, and what makes triangles of other surfaces."""
