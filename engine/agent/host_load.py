"""Load of a host and its containers, for heartbeats: CPU, memory, network, and round trips to other machines.

Machines ping each other over the fabric, the network of shared positions::

    ppaas-machines/<machine>/alive    liveliness token, declared while the agent runs
    ppaas-machines/<machine>/ping     queryable that answers with an empty payload

Containers cannot reach these keys, which are outside the root key of shared topics.
"""

import asyncio
import random
from collections.abc import Callable, Mapping
from typing import Protocol

import psutil

from engine.fabric.session import Declaration, Fabric
from engine.protocols import control_link
from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError

# -- network -----------------------------------------------------------------------------------------------------------

BITS = 8

MEGA = 1e6


class InterfaceState(Protocol):
    """State of a network interface, as psutil reports it."""

    @property
    def isup(self) -> bool:
        """True if the interface is up."""

    @property
    def duplex(self) -> int:
        """Duplex mode, as a ``NIC_DUPLEX_`` constant of psutil."""

    @property
    def speed(self) -> int:
        """Speed [Mbit/s]; 0 if unknown."""

    @property
    def flags(self) -> str:
        """Flags, as words separated by commas."""


def fastest(interfaces: Mapping[str, InterfaceState]) -> str | None:
    """Return the name of the fastest interface that is up and not a loopback; None if none is."""
    out = {name: state.speed for name, state in interfaces.items() if state.isup and "loopback" not in state.flags}
    return max(sorted(out), key=lambda name: out[name], default=None)


def capacity_of(state: InterfaceState) -> float:
    """Return the capacity of an interface, both directions together [bytes/s]; 0 if unknown."""
    ways = 1 if state.duplex == psutil.NIC_DUPLEX_HALF else 2
    return ways * state.speed * MEGA / BITS


class NetworkLoad:
    """Traffic of this host on its fastest interface.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].

    Attributes
    ----------
    capacity : float
        Capacity, both directions together [bytes/s]; 0 if unknown.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        interfaces = psutil.net_if_stats()
        self._name = fastest(interfaces)
        self.capacity = capacity_of(interfaces[self._name]) if self._name is not None else 0.0
        self._clock = clock
        self._counted, self._at = self._count(), clock()

    def rate(self) -> float:
        """Return the mean traffic since the last call, both directions together [bytes/s]."""
        count, now = self._count(), self._clock()
        more, seconds = count - self._counted, now - self._at
        self._counted, self._at = count, now
        return max(more, 0) / seconds if seconds > 0.0 else 0.0  # counters restart at 0 with an interface

    def _count(self) -> int:
        counters = psutil.net_io_counters(pernic=True).get(self._name or "")
        return counters.bytes_sent + counters.bytes_recv if counters is not None else 0


# -- round trips to other machines -------------------------------------------------------------------------------------

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


class RoundTripProbe:
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


# -- all loads ---------------------------------------------------------------------------------------------------------


class HostLoad:
    """Measures the host of an agent, and its containers.

    Parameters
    ----------
    loads : callable
        Returns the load of each container, with its CPU time since its start [s]; it may block.
    network : NetworkLoad
        Network load of the host.
    neighbours : RoundTripProbe
        Round-trip times to other machines.
    work : dict of str to int
        What its containers have done so far.
    """

    def __init__(
        self,
        loads: Callable[[], list[control_link.ContainerLoad]],
        network: NetworkLoad,
        neighbours: RoundTripProbe,
        work: Mapping[str, int],
    ) -> None:
        self._loads = loads
        self._network = network
        self._neighbours = neighbours
        self._work = work
        self._cpu_seconds: dict[str, float] = {}
        self._measured = 0.0
        psutil.cpu_percent()

    @property
    def network(self) -> float:
        """Capacity of the network, both directions together [bytes/s]; 0 if unknown."""
        return self._network.capacity

    async def measure(self) -> control_link.Heartbeat:
        """Return the load since the last call."""
        loads = await asyncio.to_thread(self._loads)
        return control_link.Heartbeat(
            cpu=psutil.cpu_percent() / 100.0 * (psutil.cpu_count() or 1),
            memory_used=psutil.virtual_memory().used,
            containers=self._as_rates(loads),
            network_used=self._network.rate(),
            round_trips=self._neighbours.round_trips,
            work=dict(self._work),
        )

    def _as_rates(self, loads: list[control_link.ContainerLoad]) -> list[control_link.ContainerLoad]:
        now = asyncio.get_running_loop().time()
        seconds, self._measured = now - self._measured, now
        before, self._cpu_seconds = self._cpu_seconds, {load.container: load.cpu for load in loads}
        return [
            control_link.ContainerLoad(
                load.container, (load.cpu - before.get(load.container, load.cpu)) / seconds, load.pss
            )
            for load in loads
        ]
