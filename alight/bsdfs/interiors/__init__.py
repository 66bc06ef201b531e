"""What lies below a surface: absorption, subsurface scattering, and which body it is."""
