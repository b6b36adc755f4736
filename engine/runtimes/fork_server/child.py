"""The first lines that run in the process of a container, before anything of the container itself."""

import fcntl
import importlib
import multiprocessing
import os
import select
import signal
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import NamedTuple

from engine.specs.containers import Launch

Main = Callable[[Launch], int | None]

_THREADS_OF_LIBRARIES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class ServerReport(NamedTuple):
    """What a fork server is: its process, its threading layer, and the kernels modules that it has loaded."""

    pid: int
    layer: str
    kernels: tuple[str, ...]


def resolve(entry: str) -> Main:
    """Return the function named by ``"module:function"``.

    Raises
    ------
    ImportError, AttributeError
        There is none of that name.
    """
    module, _, function = entry.partition(":")
    found: Main = getattr(importlib.import_module(module), function)
    return found


def run(entry: str, launch: Launch) -> None:
    """Settle in, and be the container: what ``entry`` returns becomes the exit status."""
    die_with_parent()
    os.sched_setaffinity(0, launch.cpus)  # threads take it over from the thread that starts them
    os.setsid()
    settle(launch)
    sys.exit(resolve(entry)(launch))


def settle(launch: Launch) -> None:
    """Take the place that this container was given on its machine. No other thread may exist yet."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C in a terminal is for the agent, which ends its containers
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    # NUMBA_NUM_THREADS stays as it is: numba refuses another value once its threads run.
    os.environ.update(dict.fromkeys(_THREADS_OF_LIBRARIES, str(launch.threads)))

    # Loaded already where the fork server is warm.
    from engine.runtimes.compilation.threads import use_threads  # noqa: PLC0415

    use_threads(launch.threads)


def die_with_parent() -> None:
    """End with the agent whose fork server forked this process, as ``die_with`` does."""
    parent = multiprocessing.parent_process()
    if parent is None:
        raise RuntimeError("a container is started by the fork server of an agent")
    die_with(int(parent.sentinel))


def die_with(pipe: int) -> None:
    """Let the kernel kill this process when the agent is gone, even if it is stopped or holds the interpreter's lock.

    The agent holds the other end of a pipe, or of a socket, and never writes to it from now on. Its end, by whatever
    death, is an event on our end, for which we ask to be sent SIGKILL.
    """
    fcntl.fcntl(pipe, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(pipe, fcntl.F_SETSIG, signal.SIGKILL)
    fcntl.fcntl(pipe, fcntl.F_SETFL, fcntl.fcntl(pipe, fcntl.F_GETFL) | os.O_ASYNC)
    poll = select.poll()
    poll.register(pipe, 0)  # a hang-up is told in any case
    if poll.poll(0):
        os._exit(0)  # it had gone before we asked


def probe(entry: str, answer: Connection) -> None:
    """Be a probe: tell the agent what the fork server is and has loaded, or why containers cannot start from it."""
    try:
        resolve(entry)
        from engine.runtimes.compilation import kernel_modules, threading_layer  # noqa: PLC0415  # numba, which is there

        layer = threading_layer.chosen()
    except (ImportError, AttributeError, RuntimeError) as error:
        answer.send(f"{type(error).__name__}: {error}")
    else:
        loaded = tuple(module.__name__ for module in kernel_modules.loaded())
        answer.send(ServerReport(os.getppid(), layer, loaded))
