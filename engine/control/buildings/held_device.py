"""Device of a building that is kept connected, and gets the newest order for it."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Generic, TypeVar

from engine.devices.opening import keep_connected
from engine.processes.occasional_log import OccasionalLog
from ppaas.errors import PPaaSError

logger = logging.getLogger(__name__)

OrderT = TypeVar("OrderT")

SEND_TIMEOUT = 5.0
"""Time limit of an order to a device [s]; a newer one is due by then."""


class HeldDevice(Generic[OrderT]):
    """Device whose connection is renewed, and whose orders do not pile up: a newer one replaces one that waits.

    Parameters
    ----------
    name : str
        Name for the log.
    run : callable
        Reports states until cancelled, or until the device is lost.
    send : callable
        Sends an order.
    """

    def __init__(
        self, name: str, run: Callable[[], Awaitable[None]], send: Callable[[OrderT], Awaitable[None]]
    ) -> None:
        self._name, self._run, self._send = name, run, send
        self._log = OccasionalLog(logger)
        self._newest: OrderT | None = None
        self._filled = asyncio.Event()

    @property
    def was_ordered(self) -> bool:
        """Whether it was given an order."""
        return self._newest is not None

    def order(self, order: OrderT) -> None:
        """Send an order soon."""
        self._newest = order
        self._filled.set()

    async def run(self) -> None:
        """Exchange states and orders until cancelled."""
        async with asyncio.TaskGroup() as group:
            group.create_task(keep_connected(self._name, self._run))
            group.create_task(self._send_all())

    async def send_now(self, order: OrderT) -> None:
        """Send an order; a failure is logged, for the controller repeats what matters."""
        try:
            async with asyncio.timeout(SEND_TIMEOUT):
                await self._send(order)
        except (PPaaSError, TimeoutError) as error:
            self._log.warning("%s did not take an order: %s", self._name, error or "no answer")

    async def _send_all(self) -> None:
        while True:
            await self._filled.wait()
            self._filled.clear()
            if self._newest is not None:
                await self.send_now(self._newest)
