"""A turntable: the camera goes once around a model, and the frames become a GIF.

Writes turntable.gif. Kept frames make an animation that goes on after a kill: add
``"frame_####.png"`` to the output.
"""

from mesh_figure import wavy_torus

import alight

if __name__ == "__main__":
    scene = alight.load(wavy_torus(), up="z", smooth=60, color_map="viridis")
    files = alight.animate(
        scene, turntable=True, frames="0:12", size="96x72", spp=8, output="turntable.gif"
    )
    print("written:", *files)
