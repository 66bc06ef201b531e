"""The identity of one sample: the argument of every sampler."""

from __future__ import annotations

from collections import namedtuple

from alight.core.rng import pixel_keys
from lanewise.jit import kernel

#: Pixel coordinates x, y on the full film; `index` of the sample within its replicate; `scramble`,
#: the replicate; `seed` of the picture; a, b: keys of the pixel's stream (`rng.pixel_keys`), worked
#: out once a sample. All u32 lanes; scramble and seed may be uniform.
SamplerState = namedtuple("SamplerState", "x y index scramble seed a b")


@kernel
def sampler_state(x, y, index, scramble, seed):
    """The state that names a sample."""
    a, b = pixel_keys(x, y, scramble, seed)
    return SamplerState(x=x, y=y, index=index, scramble=scramble, seed=seed, a=a, b=b)
