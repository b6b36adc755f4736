"""Calls from threads to the event loop: long work in a thread ends with a step that waits for its turn there."""

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

TIMEOUT = 600.0
"""Time limit of such a step [s]; it ends a thread whose event loop has ended."""


def callable_in_thread(function: Callable[P, Coroutine[Any, Any, T]]) -> Callable[P, T]:
    """Return a function for threads that runs a coroutine function on the present event loop.

    It blocks until there is a result, and raises the errors of the coroutine; ``TimeoutError`` after ``TIMEOUT``.
    """
    loop = asyncio.get_running_loop()

    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        return asyncio.run_coroutine_threadsafe(function(*args, **kwargs), loop).result(TIMEOUT)

    return call
