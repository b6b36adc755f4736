"""Start of a container process, before the code of the container itself."""

import fcntl
import importlib
import multiprocessing
import os
import select
import signal
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from engine.specs.containers import Launch  # it loads numpy, before the preload has set it up

Main = Callable[["Launch"], int | None]

_THREADS_OF_LIBRARIES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class ServerReport(NamedTuple):
    """Report of a fork server: its process id, its threading layer, and the kernel modules that it has imported."""

    pid: int
    layer: str
    kernels: tuple[str, ...]


def resolve(entry: str) -> Main:
    """Return the function named by ``"module:function"``.

    Raises
    ------
    ImportError, AttributeError
        There is no such module or function.
    """
    module, _, function = entry.partition(":")
    found: Main = getattr(importlib.import_module(module), function)
    return found


def run(entry: str, launch: "Launch") -> None:
    """Set this process up and run the container; the result of ``entry`` becomes the exit status."""
    die_with_parent()
    os.sched_setaffinity(0, launch.cpus)  # inherited by all threads
    os.setsid()
    set_up(launch)
    sys.exit(resolve(entry)(launch))


def set_up(launch: "Launch") -> None:
    """Set up signals and numbers of threads for a container. No other thread may exist yet."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C in a terminal is for the agent, which stops its containers
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    # NUMBA_NUM_THREADS stays unchanged: numba refuses another value once its threads run.
    os.environ.update(dict.fromkeys(_THREADS_OF_LIBRARIES, str(launch.threads)))

    # Imported already if the fork server is warm.
    from engine.runtimes.compilation.threading_layer import use_threads  # noqa: PLC0415

    use_threads(launch.threads)


def die_with_parent() -> None:
    """Die when the agent of this fork server exits; see ``die_with``."""
    parent = multiprocessing.parent_process()
    if parent is None:
        raise RuntimeError("this process was not started by the fork server of an agent")
    die_with(int(parent.sentinel))


def die_with(pipe: int) -> None:
    """Make the kernel kill this process when the agent exits, even if it is stopped or holds the interpreter's lock.

    The agent holds the other end of a pipe or socket and never writes to it from now on. However the agent exits, our
    end gets an event, for which the kernel sends SIGKILL.
    """
    fcntl.fcntl(pipe, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(pipe, fcntl.F_SETSIG, signal.SIGKILL)
    fcntl.fcntl(pipe, fcntl.F_SETFL, fcntl.fcntl(pipe, fcntl.F_GETFL) | os.O_ASYNC)
    poll = select.poll()
    poll.register(pipe, 0)  # a hang-up is always reported
    if poll.poll(0):
        os._exit(0)  # the agent had exited before


def probe(entry: str, answer: Connection) -> None:
    """Send the agent a report of the fork server, or the reason why containers cannot start from it.

    Runs in a process that was forked for it.
    """
    try:
        resolve(entry)
        from engine.runtimes.compilation import kernel_modules, threading_layer  # noqa: PLC0415  # numba, which a warm server has imported

        layer = threading_layer.chosen()
    except (ImportError, AttributeError, RuntimeError) as error:
        answer.send(f"{type(error).__name__}: {error}")
    else:
        loaded = tuple(module.__name__ for module in kernel_modules.loaded())
        answer.send(ServerReport(os.getppid(), layer, loaded))
