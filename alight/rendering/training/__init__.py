"""Training a guide before the picture is rendered."""
