"""Interface of one end of a link: the methods that the other end may call, with the types of what they take and give.

An interface is a class whose methods are all ``async``, and whose annotations msgspec encodes.
"""

import inspect
from collections.abc import Callable
from functools import cache
from typing import Any, get_type_hints

import msgspec


class Method:
    """Codec of a method.

    Parameters
    ----------
    function : callable
        The method, as the class has it.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        hints = get_type_hints(function)
        names = list(inspect.signature(function).parameters)[1:]
        kinds = tuple(hints[name] for name in names)
        self.name = function.__name__
        self.arguments: msgspec.msgpack.Decoder[tuple[Any, ...]] = msgspec.msgpack.Decoder(tuple[kinds])  # type: ignore[valid-type]
        self.result: msgspec.msgpack.Decoder[Any] = msgspec.msgpack.Decoder(hints["return"])


@cache
def method_of(function: Callable[..., Any]) -> Method:
    """Return the codec of a method, given as the class has it."""
    return Method(function)


@cache
def methods_of(interface: type) -> dict[str, Method]:
    """Return the methods of an interface by name."""
    return {
        name: method_of(function)
        for name, function in inspect.getmembers(interface, inspect.iscoroutinefunction)
        if not name.startswith("_")
    }
