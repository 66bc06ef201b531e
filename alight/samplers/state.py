"""What names one sample: the argument of every sampler."""

from __future__ import annotations

from collections import namedtuple

#: Pixel coordinates x, y on the full film; `index` of the sample within its replicate; `scramble`,
#: the replicate; `seed` of the picture. All u32 lanes; scramble and seed may be uniform.
SamplerState = namedtuple("SamplerState", "x y index scramble seed")
