"""The main loop inside a tile: samples become paths, and paths become sums of a film."""
