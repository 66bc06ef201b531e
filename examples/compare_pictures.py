"""Are two pictures the same but for noise? One pair is; the other has walls that are 5 % darker.

Each comparison has error metrics and a verdict: whether the difference exceeds the noise.
"""

import alight

if __name__ == "__main__":
    scene = alight.load("cornell-box", ["film.size=[48, 48]"])
    darker = alight.changed(scene, {"bsdfs.white.reflectance": (0.84, 0.66, 0.63)})
    first = alight.render(scene, spp=64, seed=1)
    for name, other in [("same scene", scene), ("darker walls", darker)]:
        second = alight.render(other, spp=64, seed=2)
        found = alight.compare(first, second, flip=False)
        print(f"{name}: {found.found[0].verdict}")
