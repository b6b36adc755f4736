"""Event loop of a command. SIGTERM ends a command as Ctrl-C does: it cleans up and stops the processes it started."""

import signal
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from asyncio import AbstractEventLoop

T = TypeVar("T")

TERMINATED = 128 + signal.SIGTERM
"""Exit status after SIGTERM, as shells report it."""


class Terminated(KeyboardInterrupt):
    """SIGTERM was received. Like ``KeyboardInterrupt``, it is not an ``Exception``, so commands do not catch it."""


def run(work: Coroutine[Any, Any, T], loop_factory: "Callable[[], AbstractEventLoop] | None" = None) -> T:
    """Run a command's coroutine and return its result.

    SIGTERM cancels it, as Ctrl-C does. In other threads than the main one, which receives no signals, neither does.

    Parameters
    ----------
    work : coroutine
        The command.
    loop_factory : callable, optional
        Creates the event loop (asyncio's).

    Raises
    ------
    Terminated
        SIGTERM was received, and the coroutine has ended.
    """
    import asyncio  # noqa: PLC0415 - ``ppaas --help`` loads every command, and asyncio would be a quarter of its time

    with asyncio.Runner(loop_factory=loop_factory) as runner:
        if not _in_main_thread():
            return runner.run(work)
        received = []

        async def until_terminated() -> T:
            task = asyncio.current_task()
            assert task is not None

            def terminate() -> None:
                received.append(signal.SIGTERM)
                task.cancel()

            asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, terminate)
            return await work

        before = signal.getsignal(signal.SIGTERM)
        try:
            return runner.run(until_terminated())
        except asyncio.CancelledError:
            if received:
                raise Terminated from None
            raise
        finally:
            runner.get_loop().remove_signal_handler(signal.SIGTERM)
            signal.signal(signal.SIGTERM, before)


@contextmanager
def terminable() -> Iterator[None]:
    """Make SIGTERM raise ``Terminated`` in the block, which runs without an event loop."""
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
