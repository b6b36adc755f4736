"""A custom runtime: containers are forked processes as usual, but yield to all other processes of the machine."""

import os
from contextlib import suppress

from engine.runtimes.process.container import ForkedContainer
from engine.runtimes.process.runtime import ProcessRuntime
from engine.specs.containers import Launch

NICENESS = int(os.environ.get("PPAAS_NICENESS", "5"))
"""By how much the priority of containers is lowered, 0 to 19 (nice(1))."""


class NiceRuntime(ProcessRuntime):
    """Forks containers, and lowers their priority before they start threads."""

    async def launch(self, launch: Launch) -> ForkedContainer:
        container = await super().launch(launch)
        with suppress(ProcessLookupError):  # it has exited already, which its agent notices
            os.setpriority(os.PRIO_PROCESS, container.pid, min(os.getpriority(os.PRIO_PROCESS, 0) + NICENESS, 19))
        return container
