"""Cameras and lights of files, and those that a file of a model lacks."""
