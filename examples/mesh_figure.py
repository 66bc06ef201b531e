"""From arrays to a figure for a paper: a mesh, coloured by numbers, and its shadow on nothing.

Writes figure.png. For print, give ``size="3.5x2.5in", dpi=300`` and more samples.
"""

import numpy as np

import alight


def wavy_torus(around=96, across=48):
    """Vertices, four-sided faces, and the height of each vertex."""
    u, v = np.meshgrid(
        np.arange(around) / around * 2 * np.pi,
        np.arange(across) / across * 2 * np.pi,
        indexing="ij",
    )
    r = 0.4 + 0.08 * np.cos(5 * u + 3 * v)
    x, y = (1 + r * np.cos(v)) * np.cos(u), (1 + r * np.cos(v)) * np.sin(u)
    vertices = np.stack([x, y, r * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = np.indices((around, across))
    right, up = (i + 1) % around, (j + 1) % across
    corners = [i * across + j, right * across + j, right * across + up, i * across + up]
    return vertices, np.stack(corners, axis=-1).reshape(-1, 4), vertices[:, 2]


if __name__ == "__main__":
    scene = alight.load(wavy_torus(), up="z", smooth=60, color_map="viridis")
    film = alight.render(scene, size="160x120", spp=16, background="shadow", output="figure.png")
    print(f"figure.png: {film.aov('alpha').mean():.0%} of it is torus")
