"""Runs the coroutine of a command, and has SIGTERM end a command as Ctrl-C does: in order, with all that it started."""

import signal
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from asyncio import AbstractEventLoop

T = TypeVar("T")

TERMINATED = 128 + signal.SIGTERM
"""Exit status of a command that SIGTERM ended, as a shell tells it."""


class Terminated(KeyboardInterrupt):
    """SIGTERM came: as ``KeyboardInterrupt``, no error that a command may catch and go on from."""


def run(work: Coroutine[Any, Any, T], loop_factory: "Callable[[], AbstractEventLoop] | None" = None) -> T:
    """Run a command's coroutine to its end, and return its result.

    SIGTERM cancels it, as Ctrl-C does. Outside the main thread, to which alone signals come, neither does.

    Parameters
    ----------
    work : coroutine
        What to run.
    loop_factory : callable, optional
        Makes the event loop (that of asyncio).

    Raises
    ------
    Terminated
        SIGTERM came, and the coroutine has ended.
    """
    import asyncio  # noqa: PLC0415 - ``ppaas --help`` loads every command, and this would be a quarter of its time

    with asyncio.Runner(loop_factory=loop_factory) as runner:
        if not _in_main_thread():
            return runner.run(work)
        came = []

        async def until_terminated() -> T:
            task = asyncio.current_task()
            assert task is not None

            def terminate() -> None:
                came.append(signal.SIGTERM)
                task.cancel()

            asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, terminate)
            return await work

        before = signal.getsignal(signal.SIGTERM)
        try:
            return runner.run(until_terminated())
        except asyncio.CancelledError:
            if came:
                raise Terminated from None
            raise
        finally:
            runner.get_loop().remove_signal_handler(signal.SIGTERM)
            signal.signal(signal.SIGTERM, before)


@contextmanager
def terminable() -> Iterator[None]:
    """Have SIGTERM raise ``Terminated`` in what runs inside without an event loop."""
    if not _in_main_thread():
        yield
        return

    def terminate(*_: object) -> None:
        raise Terminated

    before = signal.signal(signal.SIGTERM, terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _in_main_thread() -> bool:
    import threading  # noqa: PLC0415

    return threading.current_thread() is threading.main_thread()
