"""The kernel compiler of a machine: a process beside the containers that compiles all kernels into the cache.

It is watched, and started again if it is killed. Its progress is known here, and containers that need kernels which
are not compiled yet wait for them here, instead of compiling them.

Kernels that stores use to write and read plans are loaded apart, without waiting for others.
"""

import asyncio
import contextlib
import logging
import os
import sys
from collections.abc import Collection
from pathlib import Path

import msgspec

from engine.processes.background import Background
from engine.processes.disk_notes import exclusive
from engine.runtimes.compilation import rest_compiler
from engine.runtimes.compilation.compile_pool import CompileReport
from ppaas.decoding import from_json
from ppaas.plans import encoding

logger = logging.getLogger(__name__)

MAX_LINE = 1 << 20
"""Largest report of the process [bytes]."""

PAUSE = 1.0
"""Time until a compiler that has ended early is started again [s]."""

ATTEMPTS = 5
"""Number of compilers in a row that may end early without having compiled a module; there is no further one then."""


class KernelCompiler:
    """The kernel compiler of a machine, from `begin` until `close`.

    Attributes
    ----------
    report : CompileReport, optional
        Its progress; None before the first report.
    is_over : bool
        Whether it has compiled all kernels, or given up; nobody need wait for it.
    """

    def __init__(self) -> None:
        self.report: CompileReport | None = None
        self.is_over = False
        self._news = asyncio.Event()
        self._wanted: set[str] = set()
        self._process: asyncio.subprocess.Process | None = None
        self._background = Background()
        self._begun = False

    def begin(self) -> None:
        """Start the process, unless it was started before; the next start continues with what is not compiled yet."""
        if not self._begun:
            self._begun = True
            self._background.run(self._keep_running())

    async def close(self) -> None:
        """End the process."""
        await self._background.cancel()

    # -- the process ---------------------------------------------------------------------------------------------------

    async def _keep_running(self) -> None:
        vain = 0
        while vain < ATTEMPTS:
            before = len(self._compiled)
            status = await self._run()
            if status == 0:
                break
            vain = 0 if len(self._compiled) > before else vain + 1
            logger.warning("the kernel compiler exited with status %d, and is started again", status)
            if self.report is not None and not self._missing():
                break  # only kernels are missing that cannot be compiled
            await asyncio.sleep(PAUSE)
        else:
            logger.warning("the kernel compiler failed %d times: planners may be slow at their first use", ATTEMPTS)
        self.is_over = True
        self._tell()

    async def _run(self) -> int:
        pipe = asyncio.subprocess.PIPE
        command = (*rest_compiler.COMMAND, str(os.getpid()))
        process = await asyncio.create_subprocess_exec(*command, stdin=pipe, stdout=pipe, limit=MAX_LINE)
        try:
            self._process = process
            # The compiler before may have been killed with requests: they come first here too.
            self._ask(self._wanted)
            assert process.stdout is not None
            async for line in process.stdout:
                self._read(line)
            return await process.wait()
        finally:
            self._process = None
            if process.returncode is None:
                process.kill()
                await process.wait()

    def _read(self, line: bytes) -> None:
        try:
            self.report = from_json(line, CompileReport)
        except msgspec.DecodeError:
            logger.debug("a line of the kernel compiler is no report: %r", line)
            return
        self._wanted &= self._missing()
        self._tell()

    def _tell(self) -> None:
        self._news.set()
        self._news = asyncio.Event()

    def _ask(self, modules: Collection[str]) -> None:
        if modules and self._process is not None and self._process.stdin is not None:
            with contextlib.suppress(ConnectionError):  # it has just ended: the next one is asked again
                self._process.stdin.write(msgspec.json.encode(sorted(modules)) + b"\n")

    # -- what is compiled ----------------------------------------------------------------------------------------------

    @property
    def _compiled(self) -> tuple[str, ...]:
        return () if self.report is None else self.report.compiled

    def _missing(self) -> set[str]:
        assert self.report is not None
        return set(self.report.modules).difference(self.report.compiled, self.report.failed)

    def missing(self, modules: Collection[str]) -> set[str]:
        """Return which of these modules are not compiled yet; those that cannot be compiled are not missing."""
        if self.is_over:
            return set()
        return set(modules) if self.report is None else self._missing() & set(modules)

    async def until_compiled(self, modules: Collection[str]) -> None:
        """Put modules at the head of the queue, and wait until they are compiled; ones without kernels are ignored."""
        self._wanted |= self.missing(modules)
        self._ask(self._wanted)
        while self.missing(modules):
            await self._news.wait()


# -- kernels of the stores ---------------------------------------------------------------------------------------------


def prepare() -> None:
    """Load the kernels from the cache, or compile them: at the first plan this would block all robots.

    Call it once, in a thread, before any kernel is called. If several processes do so on a new computer, one compiles
    and the others wait for it. Once the stamp file exists no process waits: another one that compiles for a different
    cloud, or is stopped, must not block this one.
    """
    # Imported here because numba takes a third of a second.
    from engine.runtimes.compilation import kernel_modules, stamp  # noqa: PLC0415
    from engine.runtimes.memory_tuning import cached_kernels  # noqa: PLC0415

    cached_kernels.load_without_compiler()
    from ppaas.plans.encoding import kernels  # noqa: PLC0415

    if stamp.is_compiled(*_of_stores()):
        kernel_modules.warm_package(kernels)
        return
    noted = stamp_of_stores()
    with exclusive(noted.with_suffix(".lock")):
        modules = kernel_modules.warm_package(kernels)
    stamp.note(noted, [file for module in modules for file in stamp.cache_files(module)])


def stamp_of_stores() -> Path:
    """Return the stamp file of these kernels for this process."""
    from engine.runtimes.compilation import stamp  # noqa: PLC0415  # as above

    return stamp.stamp_file(*_of_stores())


def _of_stores() -> tuple[Path, str]:
    return Path(encoding.__path__[0]), f"stores, -O{sys.flags.optimize}"  # -O changes the bytecode
