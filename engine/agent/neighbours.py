"""How far other machines are: each answers the pings of the others over the fabric, on the way of what robots share.

::

    ppaas-machines/<machine>/alive    a token, there while the agent is
    ppaas-machines/<machine>/ping     is answered with nothing

No container reaches these keys: they are not below the root of what robots share.
"""

import asyncio
import random

from engine.fabric.session import Declaration, Fabric
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError

ROOT = "ppaas-machines"
PERIOD = 5.0
"""Seconds between two rounds of pings."""

AT_A_TIME = 8
"""Machines that are pinged in a round, whichever: of thousands, not each can ping all."""

MOST_KNOWN = 100_000
TIMEOUT = 1.0
NEWEST = 0.3
"""Share of the newest of the round trips to a machine in what is told."""


class Neighbours:
    """Measures the round trips from one machine to the others.

    Parameters
    ----------
    fabric : Fabric
        Of this machine.
    machine : str
        Its name.
    """

    def __init__(self, fabric: Fabric, machine: str) -> None:
        self._fabric = fabric
        self._machine = machine
        self._there: set[str] = set()
        self._round_trips: dict[str, float] = {}
        self._declared: list[Declaration] = []
        self._measuring: asyncio.Task[None] | None = None

    @property
    def round_trips(self) -> dict[str, float]:
        """Seconds to each machine that answered, by name."""
        return dict(self._round_trips)

    async def start(self) -> None:
        """Answer the others, and ping them from now on."""
        self._declared = [
            self._fabric.serve(f"{ROOT}/{self._machine}/ping", _answer),
            self._fabric.watch(f"{ROOT}/*/alive", self._changed, limit=MOST_KNOWN),
            self._fabric.announce(f"{ROOT}/{self._machine}/alive"),
        ]
        self._measuring = asyncio.create_task(self._measure())

    def _changed(self, key: str, alive: bool) -> None:
        machine = key.split("/")[1]
        if machine == self._machine:
            return
        if alive:
            self._there.add(machine)
        else:
            self._there.discard(machine)
            self._round_trips.pop(machine, None)

    async def _measure(self) -> None:
        while True:
            await self.ping_some()
            await asyncio.sleep(PERIOD)

    async def ping_some(self) -> None:
        """Ping some of the others."""
        for machine in random.sample(sorted(self._there), min(AT_A_TIME, len(self._there))):
            await self._ping(machine)

    async def _ping(self, machine: str) -> None:
        began = monotonic()
        try:
            await self._fabric.request(f"{ROOT}/{machine}/ping", b"", timeout=TIMEOUT)
        except PPaaSError:
            self._round_trips.pop(machine, None)  # it is not there any more, or too far to be told
            return
        seconds = monotonic() - began
        known = self._round_trips.get(machine, seconds)
        if machine in self._there:
            self._round_trips[machine] = known + NEWEST * (seconds - known)

    async def close(self) -> None:
        """Ping no more, and answer no more."""
        if self._measuring is not None:
            self._measuring.cancel()
            await asyncio.gather(self._measuring, return_exceptions=True)
        for declared in self._declared:
            declared.close()


async def _answer(_key: str, _payload: bytes) -> bytes:
    return b""
