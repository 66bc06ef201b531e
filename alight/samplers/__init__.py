"""Sample generators, one model per file. A new model is one file and one line here."""

from alight.samplers import halton, independent, multijittered, sobol, stratified

MODELS = (
    independent,
    stratified,
    multijittered,
    halton,
    sobol,
)

#: Of scenes that name none.
DEFAULT = sobol.Sobol()
