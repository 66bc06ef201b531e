"""What type inference has found out about calls, so that it need not again."""

from __future__ import annotations

from typing import Any

from numba import types


class RememberingContext:
    """Numba's typing context, which gives at once the answers that it has given before.

    To find out what ``a + b`` is, Numba asks everything that is known of +, ours last, and writes
    a message for each that does not fit: an eighth of the time of a compilation.
    """

    def __init__(self, context: Any) -> None:
        self._context = context
        #: ((dispatcher, arguments, keywords), signature) of each call of a kernel.
        self.calls: list[tuple] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, function: Any, arguments: Any, keywords: Any) -> Any:
        """The signature of a call; not of kernels and methods, which are resolved once each."""
        if keywords or not isinstance(function, types.Function):
            answer = self._context.resolve_function_type(function, arguments, keywords)
            if isinstance(function, types.Dispatcher):
                asked = function.dispatcher, tuple(arguments), dict(keywords)
                if (asked, answer) not in self.calls:
                    self.calls.append((asked, answer))
            return answer
        question = function, tuple(arguments)
        if question not in ANSWERS:
            answer = self._context.resolve_function_type(function, arguments, keywords)
            if answer is None:
                return None
            ANSWERS[question] = answer
        return ANSWERS[question]


#: Function and types of arguments -> the signature of the call.
ANSWERS: dict[tuple, Any] = {}
