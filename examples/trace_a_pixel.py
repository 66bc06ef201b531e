"""What happened to this pixel: one sample, vertex by vertex, and the brightest of four."""

import alight

PIXEL = 250, 300

if __name__ == "__main__":
    paths = [alight.trace("mirror-and-glass", PIXEL, sample=k) for k in range(4)]
    print(paths[0])
    brightest = max(paths, key=lambda path: sum(path.value))
    print(f"\nbrightest of four: sample {brightest.sample}, {len(brightest.vertices)} vertices")
    for vertex in brightest.vertices:
        print(
            f"  {vertex.depth} {vertex.shape or 'left the scene'}: {sum(vertex.contribution):.4f}"
        )
