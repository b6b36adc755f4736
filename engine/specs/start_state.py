"""State of a cloud whose kernels are being compiled: whether containers can start, and how far the compilation is."""

import contextlib
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
