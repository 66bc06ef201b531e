"""What happens to paths between surfaces: media, bodies that scatter, absorb or disperse."""
