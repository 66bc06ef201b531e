"""`max` and `min` of scalars in kernels.

Numba has them as functions of its own: compiled with the fast-math of whichever kernel calls them
first, named by a count of the process, and inlined only where LLVM finds it worth while. The same
kernel could round differently from one process to the next. Here they are instructions.
"""

from __future__ import annotations

import operator
from functools import reduce

from numba import types
from numba.extending import intrinsic

from lanewise.instructions import PRIMITIVES


def _extremum(function, better):
    """Python's `max` (operator.gt) or `min` (operator.lt), NaN included: the first of equals."""

    def one_of(typing, *numbers):
        kinds = _listed(numbers)
        if len(kinds) < 2 or not all(isinstance(k, types.Number | types.Boolean) for k in kinds):
            return None
        result = typing.unify_types(*map(types.unliteral, kinds))
        return result and (result(types.StarArgTuple(numbers)), codegen)

    def codegen(context, builder, sig, args):
        (given,), (values,), result = sig.args, args, sig.return_type
        kinds = _listed(given)
        if len(given) == 1:
            values = builder.extract_value(values, 0)
        numbers = [
            context.cast(builder, builder.extract_value(values, at), kind, result)
            for at, kind in enumerate(kinds)
        ]
        is_better = context.get_function(better, types.boolean(result, result))

        def choose(best, number):
            return builder.select(is_better(builder, (number, best)), number, best)

        return reduce(choose, numbers)

    # Messages call it so.
    one_of.__name__ = function.__name__
    PRIMITIVES[function] = intrinsic(one_of)


def _listed(numbers):
    """The types of what is compared: of all arguments, or of a tuple, if that is the only one."""
    only = numbers[0] if len(numbers) == 1 else None
    return tuple(only) if isinstance(only, types.BaseTuple) else tuple(numbers)


_extremum(max, operator.gt)
_extremum(min, operator.lt)
