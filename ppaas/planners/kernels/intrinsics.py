"""Decorator for functions of kernels that emit LLVM instructions, for operations that numba lacks."""

import inspect
from collections.abc import Callable
from typing import Any

from numba import types
from numba.extending import intrinsic

number = types.int64
ARRAY = None
"""Placeholder among parameter types: an array of any element type."""


def operation(result: Any, *parameters: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Make a numba intrinsic of a function that emits LLVM instructions.

    The function is called with the builder and the arguments: scalars and rows as values, arrays as a pointer to their
    first element.

    Parameters
    ----------
    result : numba type
        Type of the result; ``types.none`` for none.
    *parameters : numba type or `ARRAY`
        Types of the arguments.
    """

    def decorate(emit: Callable[..., Any]) -> Callable[..., Any]:
        def typed(_: Any, *given: Any) -> Any:
            def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
                for_each = zip(parameters, signature.args, values, strict=True)
                inputs = (
                    context.make_array(kind)(context, builder, value).data if parameter is ARRAY else value
                    for parameter, kind, value in for_each
                )
                emitted = emit(builder, *inputs)
                return context.get_dummy_value() if result is types.none else emitted

            taken = [
                kind if parameter is ARRAY else parameter for parameter, kind in zip(parameters, given, strict=True)
            ]
            return result(*taken), generate

        names = ["typing_context", *(f"argument{place}" for place in range(len(parameters)))]
        positions = [inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD) for name in names]
        typed.__signature__ = inspect.Signature(positions)  # type: ignore[attr-defined]
        typed.__name__, typed.__doc__ = emit.__name__, emit.__doc__
        made: Callable[..., Any] = intrinsic(typed)
        return made

    return decorate
