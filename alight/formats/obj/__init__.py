"""OBJ files and their materials."""
