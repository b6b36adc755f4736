"""Kernel service: containers wait here for kernels that the machine compiles, and report those they compile themselves.

A container that compiles a kernel itself, such as one from another distribution's plug-in, holds its event loop for
seconds, and sends no heartbeats. The agent answers for it meanwhile, for a limited time.
"""

import asyncio
import contextlib
from collections.abc import Iterator

from engine.processes.background import cancel_all
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import refusal_of
from engine.runtimes.compilation.kernel_compiler import KernelCompiler
from engine.specs.start_state import MOST_NAMED, RETRY_AFTER, KernelProgress, short_name
from ppaas.clock import Clock, monotonic
from ppaas.errors import Starting

MOST_COMPILING = 120.0
"""Longest time that a container may compile one kernel, with those that this one calls, without heartbeats [s]."""


def progress_of(compiler: KernelCompiler) -> KernelProgress | None:
    """Return the progress of a kernel compiler; None if it has ended, or has reported none yet."""
    report = compiler.report
    if report is None or compiler.is_over:
        return None
    compiling = tuple(map(short_name, report.compiling[:MOST_NAMED]))
    return KernelProgress(len(report.compiled), len(report.modules), compiling)


class KernelService:
    """Serves the kernels of one machine to its containers.

    Parameters
    ----------
    compiler : KernelCompiler
        Kernel compiler of the machine.
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, compiler: KernelCompiler, clock: Clock = monotonic) -> None:
        self._compiler = compiler
        self._clock = clock
        self._compiling: dict[str, float] = {}

    @property
    def is_complete(self) -> bool:
        """Whether no container need ask for kernels."""
        return self._compiler.is_over

    @property
    def progress(self) -> KernelProgress | None:
        """Progress of the machine; None if nothing is being compiled."""
        return progress_of(self._compiler)

    async def serve(self, asked: machine_link.AwaitKernels, stream: FrameStream[machine_link.FromContainer]) -> None:
        """Answer a request, unless the container leaves meanwhile."""
        waiting, left = asyncio.create_task(self.wait(asked)), asyncio.create_task(stream.receive())
        try:
            await asyncio.wait((waiting, left), return_when=asyncio.FIRST_COMPLETED)
            if waiting.done():
                error = waiting.exception()
                refusal = refusal_of(error) if isinstance(error, Starting) else None
                await stream.send(machine_link.Done(0, refusal))
        finally:
            await cancel_all((waiting, left))

    async def wait(self, asked: machine_link.AwaitKernels) -> None:
        """Wait until the modules of a request are compiled.

        Raises
        ------
        Starting
            They are not, within the time of the request.
        """
        try:
            async with asyncio.timeout(asked.within):
                await self._compiler.until_compiled(asked.modules)
        except TimeoutError as error:
            raise self._refusal(asked) from error

    def _refusal(self, asked: machine_link.AwaitKernels) -> Starting:
        missing = sorted(map(short_name, self._compiler.missing(asked.modules)))
        names = ", ".join(missing[:MOST_NAMED]) + (", …" if len(missing) > MOST_NAMED else "")
        count = f"{len(asked.modules) - len(missing)} of {len(asked.modules)}"
        whole = f"; {progress} in all" if (progress := self.progress) is not None else ""
        return Starting(
            f"the kernels of this request are being compiled, {count} (missing: {names}){whole}: try again",
            retry_after=RETRY_AFTER,
        )

    @contextlib.contextmanager
    def compiles(self, container: str) -> Iterator[None]:
        """Answer for a container while the context is open."""
        self._compiling[container] = self._clock()
        try:
            yield
        finally:
            self._compiling.pop(container, None)

    def compiling(self) -> tuple[str, ...]:
        """Return the containers that compile a kernel themselves, and have not done so for too long."""
        now = self._clock()
        return tuple(name for name, began in self._compiling.items() if now - began < MOST_COMPILING)


def nothing_to_compile() -> KernelService:
    """Return the service of a machine all of whose kernels are compiled."""
    compiler = KernelCompiler()
    compiler.is_over = True
    return KernelService(compiler)
