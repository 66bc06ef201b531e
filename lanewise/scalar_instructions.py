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


def _extremum(better):
    """Python's `max` (operator.gt) or `min` (operator.lt), NaN included: the first of equals."""

    def one_of(typing, *numbers):
        kinds = tuple(map(types.unliteral, numbers))
        if len(kinds) < 2 or not all(isinstance(k, types.Number | types.Boolean) for k in kinds):
            return None
        result = typing.unify_types(*kinds)
        return result and (result(types.StarArgTuple(kinds)), codegen)

    def codegen(context, builder, sig, args):
        (kinds,), (values,), result = sig.args, args, sig.return_type
        numbers = [
            context.cast(builder, builder.extract_value(values, at), kind, result)
            for at, kind in enumerate(kinds)
        ]
        is_better = context.get_function(better, types.boolean(result, result))

        def choose(best, number):
            return builder.select(is_better(builder, (number, best)), number, best)

        return reduce(choose, numbers)

    return intrinsic(one_of)


PRIMITIVES[max] = _extremum(operator.gt)
PRIMITIVES[min] = _extremum(operator.lt)
