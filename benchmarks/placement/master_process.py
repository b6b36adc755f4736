"""A master at work, the engine of a cloud without a web, in a process of its own.

``python -m benchmarks.placement.master_process FOLDER BALANCER ROBOTS``.

It is the service of the cloud with its master, its store and its file of settings in a folder; machines dial its
control socket. It does what it is told by lines of JSON: ``{"do": "wait", "machines": N}``, ``{"do": "configure",
"machines": N}``, ``{"do": "place", "robots": N}``, ``{"do": "state"}``, and answers each with one. The balancer
``none`` is a yardstick: no master, no store; the same orders are written to the machines in turn.
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

from benchmarks.harness.json_lines import lines, tell
from benchmarks.placement.arrivals import RobotArrival, generated
from engine.master.balancers.registry import BALANCERS
from engine.master.master import Master
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota, Quotas
from engine.protocols import control_link
from engine.service.links.control_server import ControlServer
from engine.service.master_driver import CloudService
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.machine_settings import MachineSettings
from ppaas.clock import epoch, monotonic
from ppaas.errors import InvalidInput
from storage.urls.opening import open_store

SECRET = "bench"
MAPS = 1000
USER = "fleet"
NO_BALANCER = "none"

WITHIN = 600.0
"""Seconds for which a checkpoint of a process that was killed is good, and in which a container must answer: here none
does, since what is measured is where they are placed."""

LOOK_PERIOD = 0.02
"""Seconds between two looks at how far it is: each goes over all places."""

AT_A_TIME = 50
"""Places that are opened before anything else is seen to."""


class Placement(Protocol):
    """What robots are placed by."""

    async def start(self) -> None:
        """Listen for machines."""
        ...

    def open(self, arrival: RobotArrival) -> None:
        """Have a container started for a robot."""
        ...

    @property
    def machines(self) -> int:
        """How many machines are here."""
        ...

    @property
    def launched(self) -> int:
        """Of how many containers their machines said that they run."""
        ...


class MasterPlacement:
    """By a master.

    Parameters
    ----------
    folder : Path
        For all that is kept.
    balancer : str
        Chooses machines.
    """

    def __init__(self, folder: Path, balancer: str) -> None:
        self._master = Master(BALANCERS.create(balancer, {}), Quotas(Quota(1 << 30, float(1 << 30))))
        store = open_store(f"sqlite:///{folder / 'ppaas.sqlite'}")
        checkpoints = CheckpointSelection(store, f"bench-{epoch()}", WITHIN)
        self._service = CloudService(self._master, checkpoints, folder, SECRET, start_timeout=WITHIN)
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
        """How many machines are here."""
        return len(self._master.machines)

    @property
    def launched(self) -> int:
        """Of how many containers their machines said that they run."""
        return sum(place.pid is not None for place in self._master.places.values())

    def configure(self, machines: int) -> None:
        """Say something of the first machines, and remove the last of them."""
        names = sorted(self._master.machines)[:machines]
        for number, name in enumerate(names[:-1]):
            settings = MachineSettings({"bench": f"n{number}"}, max_containers=number, draining=number % 2 == 1)
            self._service.administration.configure(name, settings)
        self._service.administration.remove(names[-1], force=True)

    def state(self) -> dict[str, Any]:
        """Return what is said of machines."""
        return {"settings": self._master.settings, "removed": sorted(self._master.removed)}


class RoundRobinPlacement:
    """By nobody: each machine in its turn, without a master or a store."""

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
        """How many machines are here."""
        return len(self._machines)

    async def machine_registered(self, register: control_link.Register) -> None:
        """Take a machine in."""
        self._machines.append(register.machine)

    def machine_said(self, machine: str, event: control_link.FromAgent) -> None:
        """Count what runs."""
        self.launched += isinstance(event, control_link.Launched)

    def machine_gone(self, machine: str) -> None:
        """Count it no more."""
        self._machines.remove(machine)


async def _until(holds: Callable[[], bool]) -> None:
    while True:
        if holds():
            return
        await asyncio.sleep(LOOK_PERIOD)


async def _place(places: Placement, arrivals: list[RobotArrival]) -> dict[str, Any]:
    """Open places until all machines have said that what they were ordered runs."""
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
            places.configure(count)
            return places.state()
        case {"do": "state"} if isinstance(places, MasterPlacement):
            return places.state()
    raise InvalidInput(f"this cannot be done: {said}")


def main() -> int:
    """Serve until whoever started this hangs up."""
    logging.basicConfig(level=logging.ERROR)  # that machines go is part of what is measured
    folder, balancer, robots = sys.argv[1:]
    uvloop.run(_serve(Path(folder), balancer, int(robots)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
