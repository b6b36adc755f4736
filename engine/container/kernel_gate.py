"""Kernel gate: holds the work of a container back until its machine has compiled the kernels that it may call.

Which kernels those are follows from the kernel modules that the container has imported since it was forked: a planner,
controller or node imports those that it calls. All others were compiled before the first container was started.

Kernels of PPaaS are compiled by the machine. Kernels from another distribution's plug-in, and one that is called with
other types than its module warms, are compiled where they are called: in a job, or on the event loop, which then sends
no heartbeats. A thread could send none in time either, since numba holds the interpreter's lock in long stretches. The
notice of it to the machine is an open connection, which ends with this process, however it ends.
"""

import asyncio
import contextlib
import logging
import socket
import sys
import threading
from collections.abc import Awaitable, Callable, Iterator, Sequence
from types import ModuleType

from numba.core import event

from engine.protocols import machine_link
from engine.protocols.framing import FrameStream, pack
from engine.protocols.refusals import error_of
from engine.runtimes.compilation import kernel_modules
from engine.specs.containers import Launch
from ppaas.errors import Starting, Unavailable

PERIOD = 1.0
"""Period at which a container that cannot start yet reports that it waits [s]."""

AGAIN = 0.2
"""Time for which a job waits after another one has waited in vain [s]: it may have waited behind that one already."""

Ask = Callable[[list[str], float | None], Awaitable[None]]
"""Waits until kernel modules are compiled, for a limited time [s]; raises ``Starting`` after that."""


class KernelsMissing(Exception):  # it is caught where the work is done again, and never shown
    """A kernel was called that the machine has not compiled yet."""


async def await_kernels(launch: Launch, modules: list[str], within: float | None) -> None:
    """Wait until the machine has compiled modules; it compiles them before others.

    Raises
    ------
    Starting
        They are not compiled within a time [s]; the text says how far the compilation is.
    Unavailable
        The machine is gone.
    """
    reader, writer = await asyncio.open_unix_connection(launch.machine)
    stream: FrameStream[machine_link.ToContainer] = FrameStream(reader, writer, machine_link.ToContainer)
    try:
        stream.write(machine_link.AwaitKernels(launch.spec.id, launch.secret, modules, within))
        answer = await stream.receive()
    finally:
        await stream.close()
    if not isinstance(answer, machine_link.Done):
        raise Unavailable("the machine did not answer a request for kernels")
    if answer.refusal is not None:
        raise error_of(answer.refusal)


class _Refusal(event.Listener):
    """Listener of numba that lets no kernel of some modules be compiled."""

    def __init__(self, missing: Callable[[], list[str]]) -> None:
        self._missing = missing

    def on_start(self, event: event.Event) -> None:
        """Raise ``KernelsMissing`` if the kernel is of one of the modules."""
        if event.data["dispatcher"].py_func.__module__ in self._missing():
            raise KernelsMissing

    def on_end(self, event: event.Event) -> None:
        """Do nothing."""


class KernelGate:
    """The kernels that one container waits for.

    Parameters
    ----------
    ask : callable, optional
        Waits until modules are compiled. Without it all are compiled, and nobody waits.
    patience : float, optional
        Time for which a job waits [s]; None for no limit.
    loaded : callable
        Returns the kernel modules that this process has imported.
    """

    def __init__(
        self,
        ask: Ask | None = None,
        *,
        patience: float | None = None,
        loaded: Callable[[], Sequence[ModuleType]] = kernel_modules.loaded,
    ) -> None:
        self._ask = ask
        self._patience = self._within = patience
        self._loaded = loaded
        self._ready = set() if ask is None else {module.__name__ for module in loaded()}
        self._looked_at = 0

    def missing(self) -> list[str]:
        """Return the imported kernel modules that may not be compiled yet."""
        if self._ask is None or len(sys.modules) == self._looked_at:
            return []
        found = [module.__name__ for module in self._loaded() if hasattr(module, "warm")]
        missing = [name for name in found if name not in self._ready]
        if not missing:
            self._looked_at = len(sys.modules)
        return missing

    @contextlib.contextmanager
    def only_compiled(self) -> Iterator[None]:
        """Raise ``KernelsMissing`` in the body if it calls a kernel that is missing: it must be done again later."""
        with event.install_listener("numba:compile", _Refusal(self.missing)):
            yield

    async def for_job(self) -> None:
        """Wait until the kernels that are missing now are compiled.

        Raises
        ------
        Starting
            They are not within the patience of this container, which one job has for all that wait behind it.
        """
        try:
            await self._wait(self._within)
        except Starting:
            self._within = AGAIN
            raise
        self._within = self._patience

    async def for_start(self, report: Callable[[], None]) -> None:
        """Wait without a time limit, before the container is ready, and report again and again that it waits."""
        waiting = asyncio.create_task(self._wait(None))
        try:
            while not waiting.done() and self.missing():
                report()
                await asyncio.wait((waiting,), timeout=PERIOD)
            await waiting
        finally:
            waiting.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await waiting

    async def _wait(self, within: float | None) -> None:
        missing = self.missing()
        if missing and self._ask is not None:
            await self._ask(missing, within)
            self._ready.update(missing)


logger = logging.getLogger(__name__)

PATIENCE = 1.0
"""Time within which the machine takes the connection [s]; it is busy, or gone, if not."""


class CompileNotice(event.Listener):
    """Listener of numba that reports each compilation, with those that it causes, from its start to its end.

    Parameters
    ----------
    launch : Launch
        Names the container, its secret and the socket of its machine.
    """

    def __init__(self, launch: Launch) -> None:
        self._launch = launch
        self._lock = threading.Lock()
        self._depth = 0
        self._open: socket.socket | None = None

    def register(self) -> None:
        """Report the compilations of this process from now on."""
        event.register("numba:compile", self)  # type: ignore[no-untyped-call]

    def on_start(self, _event: event.Event) -> None:
        """Report the first compilation of several that overlap."""
        with self._lock:
            self._depth += 1
            if self._depth == 1:
                self._open = self._report()

    def on_end(self, _event: event.Event) -> None:
        """Report the end of the last of them."""
        with self._lock:
            self._depth -= 1
            if self._depth == 0 and self._open is not None:
                self._open.close()
                self._open = None

    def _report(self) -> socket.socket | None:
        machine = socket.socket(socket.AF_UNIX)
        with contextlib.ExitStack() as if_failed:
            if_failed.callback(machine.close)
            try:
                machine.settimeout(PATIENCE)
                machine.connect(self._launch.machine)
                machine.sendall(b"".join(pack(machine_link.Compiling(self._launch.spec.id, self._launch.secret))))
            except OSError as error:
                logger.warning("cannot report that a kernel is being compiled, which may take long: %s", error)
                return None
            if_failed.pop_all()
        return machine
