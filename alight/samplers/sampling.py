"""The sampler of a program: what integrators call.

`get_1d` and `get_2d` are pure functions of the sample and the dimension, with values in [0, 1).
"""

from __future__ import annotations

from functools import cache

from alight.core.spec import Sampler
from alight.samplers.model import SAMPLERS
from alight.samplers.state import SamplerState as SamplerState
from alight.samplers.state import sampler_state as sampler_state
from lanewise.jit import specialised


def sampler_key(spec: Sampler) -> tuple:
    """What a program says about its sampler: the type name, then its compile-time parameters.

    Examples
    --------
    >>> from alight.samplers.stratified import Stratified
    >>> sampler_key(Stratified(strata=8))
    ('stratified', 8)
    """
    parameters = spec.model_dump(exclude={"type"})
    return (spec.type_name(), *parameters.values())


@specialised
def get_1d(program):
    """``get_1d(state, dimension)``: one number in [0, 1)."""
    return _kernels(program.sampler)[0]


@specialised
def get_2d(program):
    """``get_2d(state, dimension)``: a pair in [0, 1)^2; it occupies two dimensions."""
    return _kernels(program.sampler)[1]


def _kernels(key):
    name, *parameters = (key,) if isinstance(key, str) else key
    return _made_by(SAMPLERS[name], tuple(parameters))


@cache
def _made_by(model, parameters):
    return model.make_kernels(*parameters)
