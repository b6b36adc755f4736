"""Calls from threads to the event loop: long work in a thread ends with a step that waits for its turn there."""

import asyncio
from collections.abc import Callable, Coroutine
from concurrent.futures import wait
from typing import Any, ParamSpec, TypeVar

from ppaas.errors import Unavailable

P = ParamSpec("P")
T = TypeVar("T")

PERIOD = 1.0
"""Interval at which a waiting thread looks whether its event loop has ended [s]."""


def callable_in_thread(function: Callable[P, Coroutine[Any, Any, T]]) -> Callable[P, T]:
    """Return a function for threads that runs a coroutine function on the present event loop.

    It blocks until there is a result, and raises the errors of the coroutine; ``Unavailable`` if the loop has ended.
    """
    loop = asyncio.get_running_loop()

    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        running = function(*args, **kwargs)
        future = None if loop.is_closed() else asyncio.run_coroutine_threadsafe(running, loop)
        while future is None or not wait([future], PERIOD).done:
            if loop.is_closed():
                running.close()
                raise Unavailable("this server is stopping: try again in a moment")
        return future.result()

    return call
