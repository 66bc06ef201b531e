"""Metals, smooth, rough and under a clear coat."""
