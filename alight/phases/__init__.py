r"""Phase functions, one model per file; a new one is a line here too.

With :math:`\mu` the cosine between the direction before and after, a phase function p is a density
on the sphere. Kernels work with :math:`1 - \mu`, which is accurate where forward peaks are sharp.
"""

from alight.phases import henyey_greenstein, isotropic, rayleigh

MODELS = (
    isotropic,
    henyey_greenstein,
    rayleigh,
)

#: That of media which say nothing.
DEFAULT = isotropic.Isotropic()

#: One that mostly goes on, for examples of media.
FORWARD = henyey_greenstein.HenyeyGreenstein(g=0.8)
