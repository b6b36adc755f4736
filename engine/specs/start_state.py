"""State of a cloud whose kernels are being compiled: whether containers can start, and the log of it."""

import asyncio
import contextlib
import logging
from collections.abc import Callable, Iterator

import msgspec

from ppaas.errors import Starting, Unavailable

RETRY_AFTER = 3.0
"""Time after which a request that was refused because of missing kernels may succeed [s]."""

KERNEL_PATIENCE = 8.0
"""Time for which a request waits in a planning container until kernels are compiled that it needs [s]."""

MOST_NAMED = 3
"""Number of kernel modules that are named as being compiled."""


class KernelProgress(msgspec.Struct, frozen=True):
    """Progress of the kernel compiler of a machine.

    Parameters
    ----------
    done, total : int
        Number of kernel modules that are compiled, and of all.
    compiling : tuple of str
        Some that are being compiled now (`short_name`).
    """

    done: int
    total: int
    compiling: tuple[str, ...] = ()

    @property
    def is_complete(self) -> bool:
        """Whether all kernels are compiled."""
        return self.done >= self.total

    def __str__(self) -> str:
        """Return how far it is, in words."""
        now = f" (now {', '.join(self.compiling)})" if self.compiling else ""
        return f"compiling kernels, {self.done} of {self.total}{now}"


def short_name(module: str) -> str:
    """Return the name of a kernel module for people: its room and its file, such as ``lattice/hybrid_astar``."""
    packages = [package for package in module.split(".")[:-1] if package not in ("ppaas", "kernels")]
    return "/".join([*packages[-1:], module.rpartition(".")[2]])


class StartState(msgspec.Struct, frozen=True):
    """Whether containers of a cloud can start, and the kernels that its machines compile now.

    Parameters
    ----------
    ready : bool
        Whether a machine can start containers.
    machines : dict of str to KernelProgress
        Machines that compile kernels or have not joined yet, by name; None if the progress is not known.
    """

    ready: bool = True
    machines: dict[str, KernelProgress | None] = {}

    @property
    def kernels(self) -> KernelProgress | None:
        """Progress of the machine that is furthest; None if no machine compiles kernels."""
        known = [progress for progress in self.machines.values() if progress is not None]
        return max(known, key=lambda progress: progress.done, default=None)

    @property
    def text(self) -> str:
        """Why the cloud cannot start containers, or cannot start all of them; empty if it can."""
        if self.ready and not self.machines:
            return ""
        what = "its machine is starting" if self.kernels is None else str(self.kernels)
        return f"{'the cloud' if self.ready else 'the cloud is starting'}: {what}"

    def refusal(self) -> Starting | None:
        """Return the error of a request for which no container was ready; None if no kernels are being compiled."""
        text = self.text
        if not text:
            return None
        return Starting(f"{text}; kernels are compiled once on a computer: try again", retry_after=RETRY_AFTER)


READY = StartState()
"""State of a cloud all of whose kernels are compiled."""


@contextlib.contextmanager
def explained(start_of: Callable[[], StartState]) -> Iterator[None]:
    """Replace an ``Unavailable`` of the body by the reason, if no container of the cloud can start yet."""
    try:
        yield
    except Unavailable as error:
        start = start_of()
        reason = None if start.ready else start.refusal()
        if reason is None:
            raise
        raise reason from error


logger = logging.getLogger(__name__)

USUAL_START = 3.0
"""Time after which a start is reported as slow [s]."""

PERIOD = 3.0
"""Time between two lines while the cloud is starting [s]."""

LATER_PERIOD = 15.0
"""Time between two lines while the kernels of further planners are compiled [s]."""


async def log_start(state_of: Callable[[], StartState]) -> None:
    """Log the state of a cloud until it is ready and all its kernels are compiled, each line once.

    Parameters
    ----------
    state_of : callable
        Returns the state of the cloud.
    """
    await asyncio.sleep(USUAL_START)
    logged = ""
    was_slow = False
    while (state := state_of()).text:
        line = _line(state)
        if line != logged:
            logger.info("%s", line)
            logged = line
        was_slow = True
        await asyncio.sleep(LATER_PERIOD if state.ready else PERIOD)
    if was_slow:
        logger.info("the cloud is ready, and all kernels are compiled")


def _line(state: StartState) -> str:
    if not state.ready:
        return f"{state.text}. The first start on a computer compiles the kernels, which takes some minutes"
    return f"the cloud is ready: {state.kernels} for further planners; requests that need them wait for them"
