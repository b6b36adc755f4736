"""Kernel gate: holds the work of a container back until its machine has compiled the kernels that it may call.

Which kernels those are follows from the kernel modules that the container has imported since it was forked: a planner,
controller or node imports those that it calls. All others were compiled before the first container was started.
"""

import asyncio
import contextlib
import sys
from collections.abc import Awaitable, Callable, Sequence
from types import ModuleType

from engine.runtimes.compilation import kernel_modules

PERIOD = 1.0
"""Period at which a container that cannot start yet reports that it waits [s]."""

Ask = Callable[[list[str], float | None], Awaitable[None]]
"""Waits until kernel modules are compiled, for a limited time [s]; raises ``Starting`` after that."""


class KernelGate:
    """The kernels that one container waits for.

    Parameters
    ----------
    compiled : bool
        Whether all kernels are compiled, so that it never waits.
    patience : float, optional
        Time for which a job waits [s]; None for no limit.
    loaded : callable
        Returns the kernel modules that this process has imported.
    """

    def __init__(
        self,
        *,
        compiled: bool = True,
        patience: float | None = None,
        loaded: Callable[[], Sequence[ModuleType]] = kernel_modules.loaded,
    ) -> None:
        self._compiled = compiled
        self._patience = patience
        self._loaded = loaded
        self._ready = set() if compiled else {module.__name__ for module in loaded()}
        self._looked_at = 0
        self._ask: Ask | None = None

    def ask(self, ask: Ask) -> None:
        """Ask for missing kernels by a function from now on."""
        self._ask = ask

    def missing(self) -> list[str]:
        """Return the imported kernel modules that may not be compiled yet."""
        if self._compiled or len(sys.modules) == self._looked_at:
            return []
        found = [module.__name__ for module in self._loaded() if hasattr(module, "warm")]
        missing = [name for name in found if name not in self._ready]
        if not missing:
            self._looked_at = len(sys.modules)
        return missing

    async def for_job(self) -> None:
        """Wait until the kernels that are missing now are compiled.

        Raises
        ------
        Starting
            They are not within the patience of this container.
        """
        await self._wait(self._patience)

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
