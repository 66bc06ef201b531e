"""Rays of light that leave the lights, where light paths begin."""
