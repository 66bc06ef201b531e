"""Materials made of other materials: blends, masks, both sides, normals from pictures."""
