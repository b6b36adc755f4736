"""Reports of a machine to its master while it cannot start containers yet, before it registers."""

import asyncio
import logging
from collections.abc import Awaitable, Callable

from engine.agent.config import AgentConfig
from engine.agent.master_redial import Master
from engine.agent.requests.kernel_service import progress_of
from engine.protocols import control_link
from engine.runtimes.compilation.kernel_compiler import KernelCompiler
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

USUAL_START = 1.0
"""Time within which a machine has usually started, if its kernels are compiled [s]; it reports nothing until then."""

PERIOD = 0.5
"""Period of the reports [s]."""


async def report_start(
    config: AgentConfig, compiler: KernelCompiler, dial: Callable[[], Awaitable[Master]], delay: float = USUAL_START
) -> None:
    """Report to the master that this machine is starting, and how far its kernels are, until cancelled.

    Parameters
    ----------
    config : AgentConfig
        Settings of the machine.
    compiler : KernelCompiler
        Its kernel compiler, which begins now: it waits for the one of the fork server, and knows how far that is.
    dial : callable
        Connects to the master.
    delay : float
        Time until the first report [s].
    """
    await asyncio.sleep(delay)
    compiler.begin()
    while True:
        try:
            stream = await dial()
        except Unavailable as error:
            logger.debug("the master cannot be told yet that the machine is starting: %s", error)
        else:
            await _report(config, compiler, stream)
        await asyncio.sleep(PERIOD)


async def _report(config: AgentConfig, compiler: KernelCompiler, stream: Master) -> None:
    """Report until the master closes the connection."""
    closed = asyncio.create_task(stream.receive())
    try:
        while not closed.done():
            stream.write(control_link.MachineStarting(config.machine, config.secret, progress_of(compiler)))
            await asyncio.wait((closed,), timeout=PERIOD)
    finally:
        closed.cancel()
        await asyncio.gather(closed, return_exceptions=True)
        await stream.close()
