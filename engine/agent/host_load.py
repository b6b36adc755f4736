"""Host load: CPU, memory and network usage of a host and its containers, for heartbeats."""

import asyncio
from collections.abc import Callable

import psutil

from engine.agent.neighbours import Neighbours
from engine.agent.network_load import NetworkLoad
from engine.protocols import control_link


class HostLoad:
    """Measures the host of an agent, and its containers.

    Parameters
    ----------
    loads : callable
        Returns the load of each container, with its CPU time since its start [s]; it may block.
    network : NetworkLoad
        Network load of the host.
    neighbours : Neighbours
        Round-trip times to other machines.
    """

    def __init__(
        self, loads: Callable[[], list[control_link.ContainerLoad]], network: NetworkLoad, neighbours: Neighbours
    ) -> None:
        self._loads = loads
        self._network = network
        self._neighbours = neighbours
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
