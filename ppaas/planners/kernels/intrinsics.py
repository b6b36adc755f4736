"""Functions for kernels that are written as LLVM instructions, since numba has nothing like them."""

import inspect
from collections.abc import Callable
from typing import Any

from numba import types
from numba.extending import intrinsic

number = types.int64
ARRAY = None
"""Stands for an array of any type among the types of parameters."""


def operation(result: Any, *parameters: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Make a function that emits instructions one that kernels can call.

    It is given the builder and what it is called with: values as they are, of an array where its elements begin.
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
