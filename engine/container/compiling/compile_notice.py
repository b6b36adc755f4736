"""Compile notice: a container reports to its machine that it compiles a kernel itself, and may be silent meanwhile.

Kernels of PPaaS are compiled by the machine. Kernels from another distribution's plug-in, and one that is called with
other types than its module warms, are compiled where they are called: in a job, or on the event loop, which then sends
no heartbeats. A thread could send none in time either, since numba holds the interpreter's lock in long stretches. The
notice is an open connection, which ends with this process, however it ends.
"""

import contextlib
import logging
import socket
import threading

from numba.core import event

from engine.protocols import machine_link
from engine.protocols.framing import pack
from engine.specs.containers import Launch

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
