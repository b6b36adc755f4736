"""Progress of the start of a cloud, for people who wait for it."""

import asyncio
import contextlib
import socket
from collections.abc import Callable
from typing import Any

from ppaas.errors import PPaaSError
from robots.client.rest import RestClient
from robots.client.rest_paths import path_of

PERIOD = 1.0
"""Period at which the cloud is asked [s]."""


async def tell_start(url: str, tell: Callable[[str], None]) -> None:
    """Tell what a cloud does while it is starting, whenever that has changed, until cancelled.

    Parameters
    ----------
    url : str
        URL of the cloud, which need not serve yet.
    tell : callable
        Called with each text.
    """
    rest, told = RestClient(url), ""
    while True:
        with contextlib.suppress(PPaaSError):  # it does not serve yet
            text = start_text(await rest.get(path_of("health")))
            if text and text != told:
                told = text
                tell(text)
        await asyncio.sleep(PERIOD)


def start_text(health: dict[str, Any]) -> str:
    """Return what a cloud does, by its health, while it is starting; empty if it is not."""
    if health["status"] != "starting":
        return ""
    kernels = health["kernels"]
    if kernels is None:
        return "the cloud is starting"
    now = f" (now {', '.join(kernels['compiling'])})" if kernels["compiling"] else ""
    return f"the cloud is starting: compiling kernels, {kernels['done']} of {kernels['total']}{now}"


def free_port() -> int:
    """Return a TCP port of this computer that nobody uses now."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
    return port
