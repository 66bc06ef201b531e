"""A render by two processes of a Dask cluster: the same bits as by this one.

Needs the extra ``cluster``. For machines of your own, see `alight cluster keys`.
"""

import numpy as np

import alight

# The processes import this file, so that what it does stands under its name.
if __name__ == "__main__":
    here = alight.render("cornell-box", size=32, spp=16)
    there = alight.render("cornell-box", size=32, spp=16, cluster="local:2")
    print("the same bits:", np.array_equal(here.sums, there.sums))
