"""What readers give back: cameras and lights of files, and those that stand in for missing ones."""
