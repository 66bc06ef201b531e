"""Bounds, displacement and skinning of meshes, whatever file they come from."""
