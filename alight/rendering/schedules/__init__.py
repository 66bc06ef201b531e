"""What is rendered next, and when it is enough: counts, promises, adaptive sampling."""
