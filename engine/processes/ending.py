"""Ends a process of this machine that is not a child of this one."""

import asyncio
import os
import signal

from engine.processes.instances import is_dead, pid_of

GRACE = 5.0
"""Time for a process to exit by itself after SIGTERM [s]."""

BLINK = 0.02
"""Time between two checks whether it has exited [s]."""


async def end_process(instance: str) -> None:
    """Stop a process, which leads a process group; kill the group if the process does not exit by itself.

    Parameters
    ----------
    instance : str
        Instance name of the process.
    """
    os.kill(pid_of(instance), signal.SIGTERM)
    try:
        async with asyncio.timeout(GRACE):
            while not is_dead(instance):  # noqa: ASYNC110 - it is not our child
                await asyncio.sleep(BLINK)
    except TimeoutError:
        os.killpg(pid_of(instance), signal.SIGKILL)
