"""Replicates of arms: rendered and measured here, or by the workers of a cluster."""
