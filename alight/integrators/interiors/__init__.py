"""What happens to paths between surfaces: media, bodies that scatter or absorb."""
