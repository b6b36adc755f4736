"""The cloud that a demo starts, and the progress of its start."""

import asyncio
import contextlib
import socket
from collections.abc import AsyncIterator
from typing import Any

from ppaas.errors import PPaaSError
from robots.client.rest import RestClient
from robots.client.rest_paths import path_of
from robots.demo.cloud_process import CloudProcess
from robots.demo.options import CloudAccess, Write

PERIOD = 1.0
"""Period at which the cloud is asked [s]."""

STARTING = "the cloud is starting"
"""What is written first."""


@contextlib.asynccontextmanager
async def own_cloud(write: Write) -> AsyncIterator[CloudAccess]:
    """Run a cloud during the block, and write what it does until it is up.

    Raises
    ------
    Unavailable
        The cloud does not start; the text includes the end of its log.
    """
    write(STARTING)
    port = free_port()
    async with contextlib.AsyncExitStack() as stack:
        telling = asyncio.create_task(tell_start(f"http://127.0.0.1:{port}", write))
        try:
            cloud = await stack.enter_async_context(CloudProcess(arguments=("--port", str(port))))
        finally:
            telling.cancel()
            await asyncio.gather(telling, return_exceptions=True)
        yield CloudAccess(cloud.ready.url, cloud.ready.admin_user, cloud.password)


async def tell_start(url: str, write: Write) -> None:
    """Tell what a cloud does while it is starting, whenever that has changed, until cancelled.

    Parameters
    ----------
    url : str
        URL of the cloud, which need not serve yet.
    write : callable
        Called with each text.
    """
    rest, told = RestClient(url), STARTING
    while True:
        with contextlib.suppress(PPaaSError):  # it does not serve yet
            text = start_text(await rest.get(path_of("health")))
            if text and text != told:
                told = text
                write(text)
        await asyncio.sleep(PERIOD)


def start_text(health: dict[str, Any]) -> str:
    """Return what a cloud does, by its health, while it is starting; empty if it is not."""
    if health["status"] != "starting":
        return ""
    kernels = health["kernels"]
    if kernels is None:
        return STARTING
    now = f" (now {', '.join(kernels['compiling'])})" if kernels["compiling"] else ""
    return f"{STARTING}: compiling kernels, {kernels['done']} of {kernels['total']}{now}"


def free_port() -> int:
    """Return a TCP port of this computer that nobody uses now."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
    return port
