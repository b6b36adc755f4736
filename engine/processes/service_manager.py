"""Notifications to the service manager that started this process: sd_notify(3) of systemd.

Without ``NOTIFY_SOCKET`` in the environment nothing is sent.
"""

import os
import socket
from collections.abc import MutableMapping
from contextlib import suppress

from engine.processes.background import Background, repeat

ADDRESS, WATCHDOG, WATCHED = "NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"


class ServiceManager:
    """The service manager, if one started this process and waits for its notifications.

    Parameters
    ----------
    environment : mutable mapping
        The environment. Its variables for the manager are removed, so that no child speaks for this process.
    """

    def __init__(self, environment: MutableMapping[str, str] = os.environ) -> None:
        self._background = Background()
        self._address = environment.pop(ADDRESS, "")
        limit, watched = environment.pop(WATCHDOG, ""), environment.pop(WATCHED, "")
        is_watched = limit.isdecimal() and watched in ("", str(os.getpid()))
        self.period = int(limit) / 2e6 if is_watched else None
        """Time between two signs of life [s]: half the limit; None if the manager expects none."""

    def notify(self, **states: str) -> None:
        """Send states, such as ``READY="1"`` or ``STATUS="text"``; a manager that cannot be reached misses them."""
        if not self._address:
            return
        # An address in the abstract namespace is written with "@" in place of its zero byte.
        address = "\0" + self._address[1:] if self._address.startswith("@") else self._address
        text = "\n".join(f"{name}={value}" for name, value in states.items())
        with suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as sending:
            sending.setblocking(False)
            sending.sendto(text.encode(), address)

    def start(self) -> None:
        """Send signs of life from the running event loop: if it hangs, the manager restarts this process."""
        if self.period is not None:
            self._background.run(repeat(self._live, self.period))

    async def stop(self) -> None:
        """Send that this process is about to end, and no more signs of life."""
        self.notify(STOPPING="1")
        await self._background.cancel()

    async def _live(self) -> None:
        self.notify(WATCHDOG="1")
