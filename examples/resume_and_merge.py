"""Stop, go on, add up: in any order, the same picture to the last bit.

Writes box.alight, a checkpoint, and half.alight.
"""

import numpy as np

import alight

if __name__ == "__main__":
    whole = alight.render("cornell-box", size=32, spp=32)

    # Sixteen samples with a checkpoint, as if stopped there; then the rest.
    alight.render("cornell-box", size=32, spp=16, checkpoint="box.alight")
    resumed = alight.resume("box.alight", spp=32)
    print("resumed, the same bits:", np.array_equal(resumed.sums, whole.sums))

    # Two halves, as two machines would render them; one travels as a file.
    first = alight.render("cornell-box", size=32, spp=16)
    alight.render("cornell-box", size=32, spp=16, first_sample=16, output="half.alight")
    merged = alight.merge("half.alight", first)
    print("merged, the same bits:", np.array_equal(merged.sums, whole.sums))
