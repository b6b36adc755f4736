"""Simulated machines of the placement benches, all in one process.

``python -m benchmarks.placement.machines_process FOLDER COUNT KEEP_EVERY``.

Each machine has a control link to the socket in the folder, sends a heartbeat once a second, and reports each container
of an order as running. It starts none, since the bench measures the master. For every KEEP_EVERY-th container (0: for
none), a checkpoint is saved in the store of the folder, as a container gateway does. A machine whose link is closed
reconnects, as a joined machine does. ``"told"`` on standard input prints all placements so far, ``"count"`` their
number.
"""

import asyncio
import contextlib
import sys
from pathlib import Path
from typing import Any

import msgspec
import uvloop

from benchmarks.harness.json_process import lines, tell
from benchmarks.placement.master_process import SECRET
from engine.processes.heartbeats import BEAT_PERIOD
from engine.protocols import control_link
from engine.protocols.address import UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.sockets import dial
from engine.specs.checkpoints import marks
from engine.specs.containers import ContainerSpec
from ppaas import __version__
from ppaas.clock import epoch
from ppaas.errors import Unavailable
from storage.ports import Store
from storage.records import CloneCheckpoint
from storage.urls.opening import open_store

CORES, MEMORY = 8, 1 << 35
DIAL_PAUSE = 0.25
KEPT_BY = "bench"
"""Key in a checkpoint of the id of the container that saved it."""


class CarriedContainer(msgspec.Struct):
    """A container that a machine was ordered to start.

    Parameters
    ----------
    machine, container : str
        Names of the machine and the container.
    goes_on : str
        Container whose checkpoint it continues; empty if none.
    kept : bool
        Whether its checkpoint was saved.
    """

    machine: str
    container: str
    goes_on: str
    kept: bool = False


class Machines:
    """All simulated machines.

    Parameters
    ----------
    folder : Path
        Folder of the cloud.
    keep_every : int
        Number of containers for each one with a checkpoint; 0 for no checkpoints.

    Attributes
    ----------
    ordered : dict of str to CarriedContainer
        Containers by the id of their robot.
    """

    def __init__(self, folder: Path, keep_every: int) -> None:
        self._address = UnixAddress(folder / "control.sock")
        self._store: Store = open_store(f"sqlite:///{folder / 'ppaas.sqlite'}")
        self._keep_every = keep_every
        self.orders = 0
        self.ordered: dict[str, CarriedContainer] = {}

    async def be(self, name: str) -> None:
        """Run one machine, which reconnects whenever the master closes the link."""
        while True:
            with contextlib.suppress(Unavailable):
                await self._serve(name, FrameStream(*await dial(self._address), control_link.ToAgent))
            await asyncio.sleep(DIAL_PAUSE)

    async def _serve(self, name: str, stream: FrameStream[control_link.ToAgent]) -> None:
        stream.write(control_link.Register(name, SECRET, 1, CORES, MEMORY, release=__version__))
        beating = asyncio.create_task(_beat(stream))
        while (order := await stream.receive()) is not None:
            if isinstance(order, control_link.StartContainer):
                await self._start(name, order.spec, stream)
        beating.cancel()
        await stream.close()

    async def _start(self, name: str, spec: ContainerSpec, stream: FrameStream[control_link.ToAgent]) -> None:
        self.orders += 1
        assert spec.robot is not None
        ordered = CarriedContainer(name, spec.id, spec.checkpoint.get(KEPT_BY, b"").decode())
        if self._keep_every and self.orders % self._keep_every == 0:
            await asyncio.to_thread(self._keep, spec)
            ordered.kept = True
        self.ordered[spec.robot.id] = ordered
        stream.write(control_link.Launched(spec.id, self.orders))

    def _keep(self, spec: ContainerSpec) -> None:
        assert spec.robot is not None
        nodes = {KEPT_BY: spec.id.encode()} | marks(spec, "bench")
        self._store.save_clone(CloneCheckpoint(spec.user, spec.robot.id, nodes, epoch()))


async def _beat(stream: FrameStream[control_link.ToAgent]) -> None:
    while True:
        await asyncio.sleep(BEAT_PERIOD)
        stream.write(control_link.AgentBeat())


async def _serve(folder: Path, count: int, keep_every: int) -> None:
    machines = Machines(folder, keep_every)
    async with asyncio.TaskGroup() as group:
        carrying = [group.create_task(machines.be(f"m{number:05}")) for number in range(count)]
        async for said in lines():
            tell(_answer(machines, said))
        for task in carrying:
            task.cancel()


def _answer(machines: Machines, said: Any) -> Any:
    return len(machines.ordered) if said == "count" else machines.ordered


def main() -> int:
    """Run until standard input is closed."""
    folder, count, keep_every = sys.argv[1:]
    uvloop.run(_serve(Path(folder), int(count), int(keep_every)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
