"""Checkpoints: written while a picture is rendered, and gone on from."""
