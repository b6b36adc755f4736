"""Process with the master of a cloud, without its web server.

``python -m benchmarks.placement.master_process FOLDER BALANCER ROBOTS``.

It runs the service of the cloud with its master, its store and its file of settings in a folder; machines connect to
its control socket. It executes requests in lines of JSON: ``{"do": "wait", "machines": N}``, ``{"do": "configure",
"machines": N}``, ``{"do": "place", "robots": N}`` and ``{"do": "state"}``, and answers each with a line. The balancer
``none`` is a baseline without master and store, which sends the same orders to the machines in turn.
"""

import asyncio
import itertools
import logging
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import uvloop

from benchmarks.harness.json_process import lines, tell
from benchmarks.placement.arrivals import RobotArrival, generated
from engine.control.master_driver import MasterDriver
from engine.links.control_server import ControlServer
from engine.master.balancers.registry import BALANCERS
from engine.master.master import Master
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota, Quotas
from engine.protocols import control_link
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.machine_settings import MachineSettings
from engine.specs.start_state import KernelProgress
from ppaas.clock import epoch, monotonic
from ppaas.errors import InvalidInput
from storage.urls.opening import open_store

SECRET = "bench"
MAPS = 1000
USER = "fleet"
NO_BALANCER = "none"

WITHIN = 600.0
"""Lifetime of the checkpoint of a killed process, and start timeout of a container [s]: long, as none starts."""

LOOK_PERIOD = 0.02
"""Period at which the progress is checked [s]: each check visits all places."""

AT_A_TIME = 50
"""Number of places that are opened between two runs of the event loop."""


class Placement(Protocol):
    """Interface of placements under test."""

    async def start(self) -> None:
        """Listen for machines."""
        ...

    def open(self, arrival: RobotArrival) -> None:
        """Order a container for a robot."""
        ...

    @property
    def machines(self) -> int:
        """Number of connected machines."""
        ...

    @property
    def launched(self) -> int:
        """Number of containers that machines have reported as running."""
        ...


class MasterPlacement:
    """Placement by a master with its store.

    Parameters
    ----------
    folder : Path
        Folder of the store and the settings.
    balancer : str
        Name of the balancer.
    """

    def __init__(self, folder: Path, balancer: str) -> None:
        self._master = Master(BALANCERS.create(balancer, {}), Quotas(Quota(1 << 30, float(1 << 30))))
        store = open_store(f"sqlite:///{folder / 'ppaas.sqlite'}")
        checkpoints = CheckpointSelection(store, f"bench-{epoch()}", WITHIN)
        self._service = MasterDriver(self._master, checkpoints, folder, SECRET, start_timeout=WITHIN)
        self._service.administration.keep_in(folder / "machine-settings.json")

    async def start(self) -> None:
        """Listen for machines."""
        await self._service.start()

    def open(self, arrival: RobotArrival) -> None:
        """Open the place of a robot."""
        spec = arrival.spec(0)
        self._service.open_place(PlaceRequest(USER, spec.map, spec.cores, spec.robot))

    @property
    def machines(self) -> int:
        """Number of connected machines."""
        return len(self._master.machines)

    @property
    def launched(self) -> int:
        """Number of containers that machines have reported as running."""
        return sum(place.pid is not None for place in self._master.places.values())

    async def configure(self, machines: int) -> None:
        """Configure the first machines, and remove the last of them."""
        names = sorted(self._master.machines)[:machines]
        for number, name in enumerate(names[:-1]):
            settings = MachineSettings({"bench": f"n{number}"}, max_containers=number, draining=number % 2 == 1)
            await self._service.administration.configure(name, settings)
        await self._service.administration.remove(names[-1], force=True)

    def state(self) -> dict[str, Any]:
        """Return the settings of machines and the names of removed machines."""
        return {"settings": dict(self._master.settings), "removed": sorted(self._master.removed)}


class RoundRobinPlacement:
    """Placement on the machines in turn, without master and store."""

    def __init__(self, folder: Path) -> None:
        self._server = ControlServer(folder / "control.sock", SECRET, self)
        self._machines: list[str] = []
        self._numbers = itertools.count()
        self.launched = 0

    async def start(self) -> None:
        """Listen for machines."""
        await self._server.start()

    def open(self, arrival: RobotArrival) -> None:
        """Order a container."""
        number = next(self._numbers)
        machine = self._machines[number % len(self._machines)]
        self._server.order(machine, control_link.StartContainer(arrival.spec(number), SECRET, ""))

    @property
    def machines(self) -> int:
        """Number of connected machines."""
        return len(self._machines)

    def machine_starting(self, machine: str, kernels: KernelProgress | None) -> None:
        """Do nothing: its machines are played by this bench."""

    def machine_start_ended(self, machine: str) -> None:
        """Do nothing, as above."""

    async def machine_registered(self, register: control_link.Register) -> None:
        """Add a machine."""
        self._machines.append(register.machine)

    def machine_said(self, machine: str, event: control_link.FromAgent) -> None:
        """Count running containers."""
        self.launched += isinstance(event, control_link.Launched)

    def machine_gone(self, machine: str) -> None:
        """Remove a machine."""
        self._machines.remove(machine)


async def _until(holds: Callable[[], bool]) -> None:
    while True:
        if holds():
            return
        await asyncio.sleep(LOOK_PERIOD)


async def _place(places: Placement, arrivals: list[RobotArrival]) -> dict[str, Any]:
    """Open places, and wait until machines have reported all containers as running."""
    before, began, used = places.launched, monotonic(), sum(os.times()[:2])
    for number, arrival in enumerate(arrivals):
        places.open(arrival)
        if number % AT_A_TIME == 0:
            await asyncio.sleep(0)
    await _until(lambda: places.launched - before >= len(arrivals))
    return {"seconds": monotonic() - began, "cpu": sum(os.times()[:2]) - used}


async def _serve(folder: Path, balancer: str, robots: int) -> None:
    places: Placement = RoundRobinPlacement(folder) if balancer == NO_BALANCER else MasterPlacement(folder, balancer)
    arrivals = list(generated(robots, MAPS, seed=1))
    await places.start()
    tell({"listens": True})
    async for said in lines():
        tell(await _done(places, arrivals, said))


async def _done(places: Placement, arrivals: list[RobotArrival], said: dict[str, Any]) -> dict[str, Any]:
    match said:
        case {"do": "wait", "machines": int(count)}:
            await _until(lambda: places.machines >= count)
            return {"machines": places.machines}
        case {"do": "place", "robots": int(count)}:
            return await _place(places, arrivals[:count])
        case {"do": "configure", "machines": int(count)} if isinstance(places, MasterPlacement):
            await places.configure(count)
            return places.state()
        case {"do": "state"} if isinstance(places, MasterPlacement):
            return places.state()
    raise InvalidInput(f"unknown request to the master process: {said}")


def main() -> int:
    """Run until standard input is closed."""
    logging.basicConfig(level=logging.ERROR)  # lost machines are part of the bench
    folder, balancer, robots = sys.argv[1:]
    uvloop.run(_serve(Path(folder), balancer, int(robots)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
