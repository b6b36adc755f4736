"""Running what a command waits for."""

from collections.abc import Coroutine
from typing import Any, TypeVar

T = TypeVar("T")


def run(work: Coroutine[Any, Any, T]) -> T:
    """Run a command's coroutine to its end, and return its result."""
    import asyncio  # noqa: PLC0415 - ``ppaas --help`` loads every command, and this would be a quarter of its time

    return asyncio.run(work)
