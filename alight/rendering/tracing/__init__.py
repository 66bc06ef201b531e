"""Paths that are looked at: one sample in plain Python, and logs of contributions."""
