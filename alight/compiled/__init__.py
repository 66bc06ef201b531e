"""From flat scenes to the arrays that kernels read."""
