"""Map follower of a container: lets its clone go on with the layers that its machine offers, and answers."""

import asyncio
import logging
from dataclasses import dataclass

from engine.container.container import Container
from engine.container.current_map import CurrentMap
from engine.container.executor import NodeExecutor
from engine.container.fleet_bridge import FleetBridge
from engine.container.machine_client import MachineClient
from engine.container.monitor.setup import ContainerMonitor
from engine.container.shared_plans import PlanningNotes
from engine.protocols import machine_link
from ppaas.clock import epoch
from ppaas.errors import PPaaSError

logger = logging.getLogger(__name__)

LOOK = 10.0
"""Longest time between two looks at the zones of the map, which a new version may have changed [s]."""


@dataclass(frozen=True, slots=True)
class MapFollower:
    """Handler of ``UseLayers`` frames: all parts of a container that know its map version change together."""

    current: CurrentMap
    home: NodeExecutor
    container: Container
    machine: MachineClient
    outside: FleetBridge
    notes: PlanningNotes
    monitoring: ContainerMonitor | None

    async def attend_zones(self) -> None:
        """Move the nodes to other zones of the map whenever others come into force."""
        while True:
            await asyncio.sleep(max(min(self.current.next_change - epoch(), LOOK), 0.01))
            try:
                self.current.follow_zones(self.home.graph, self.monitoring)
            except PPaaSError as error:
                logger.error("the zones of map %r are not changed: %s", self.current.spec.map.id, error)
            self.home.attend()

    def __call__(self, frame: machine_link.UseLayers) -> None:
        """Use the layers; what was sent before the answer is of the version before."""
        self.notes.tell(self.machine)
        try:
            if self.current.use(frame, self.home.graph, self.monitoring):
                self.container.map_replaced()
        except PPaaSError as error:
            self.machine.map_in_use(frame.map, error)
        else:
            self.outside.use_spec(self.current.spec)
            self.machine.map_in_use(frame.map)
        self.home.attend()
