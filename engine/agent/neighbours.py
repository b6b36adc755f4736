"""Round-trip times between machines: each pings the others over the fabric, the network of shared positions.

::

    ppaas-machines/<machine>/alive    liveliness token, declared while the agent runs
    ppaas-machines/<machine>/ping     queryable that answers with an empty payload

Containers cannot reach these keys, which are outside the root key of shared topics.
"""

import asyncio
import random

from engine.fabric.session import Declaration, Fabric
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError

ROOT = "ppaas-machines"
PERIOD = 5.0
"""Time between two rounds of pings [s]."""

AT_A_TIME = 8
"""Number of machines pinged in a round, chosen at random: with thousands, a machine cannot ping all."""

MOST_KNOWN = 100_000
"""Largest number of machines that are known by their tokens."""

TIMEOUT = 1.0
"""Time limit of a ping [s]."""

NEWEST = 0.3
"""Weight of the newest round trip in the exponential moving average."""


class Neighbours:
    """Measures the round-trip times from one machine to the others.

    Parameters
    ----------
    fabric : Fabric
        Session of this machine on the fabric.
    machine : str
        Name of this machine.
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
        """Average round-trip time to each machine that answered, by name [s]."""
        return dict(self._round_trips)

    async def start(self) -> None:
        """Start to answer pings of other machines, and to ping them."""
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
        """Ping up to `AT_A_TIME` other machines, one after another."""
        for machine in random.sample(sorted(self._there), min(AT_A_TIME, len(self._there))):
            await self._ping(machine)

    async def _ping(self, machine: str) -> None:
        began = monotonic()
        try:
            await self._fabric.request(f"{ROOT}/{machine}/ping", b"", timeout=TIMEOUT)
        except PPaaSError:
            self._round_trips.pop(machine, None)  # it has left, or the ping timed out
            return
        seconds = monotonic() - began
        known = self._round_trips.get(machine, seconds)
        if machine in self._there:
            self._round_trips[machine] = known + NEWEST * (seconds - known)

    async def close(self) -> None:
        """Stop pinging and answering."""
        if self._measuring is not None:
            self._measuring.cancel()
            await asyncio.gather(self._measuring, return_exceptions=True)
        for declared in self._declared:
            declared.close()


async def _answer(_key: str, _payload: bytes) -> bytes:
    return b""
