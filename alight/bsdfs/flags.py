"""What a sampled direction did: bits of the flags that `sample` returns."""

REFLECTION = 1
TRANSMISSION = 2
#: One of finitely many directions: `evaluate` is 0 for it, and `pdf` is a probability.
DELTA = 4
#: Straight on through a surface that is not there.
NULL = 8

#: From this bit on, the number of the model, of a material that is a sum of several.
LAYER = 4

#: What programs call a material with both delta and smooth lobes.
DELTA_AND_SMOOTH = "delta_and_smooth"
