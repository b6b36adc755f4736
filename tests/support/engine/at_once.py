"""Results of coroutines that wait for nothing, for conditions that are not awaited."""

from collections.abc import Coroutine
from typing import Any, TypeVar

R = TypeVar("R")


def at_once(coroutine: Coroutine[Any, Any, R]) -> R:
    """Return the result of a coroutine that waits for nothing."""
    try:
        coroutine.send(None)
    except StopIteration as ended:
        result: R = ended.value
        return result
    coroutine.close()
    raise AssertionError("it waits for something")
