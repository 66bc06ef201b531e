"""Path guiding: where light comes from, learnt while rendering, as densities to sample."""
