"""SPMD text in Python: one kernel, run on NumPy arrays or compiled for packets of lanes."""
