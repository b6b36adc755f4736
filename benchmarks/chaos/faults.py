"""Kinds of faults, their random order, which depends on the seed alone, and their injection."""

import asyncio
import contextlib
import logging
import math
import signal
from collections.abc import Callable, Coroutine, Iterator, Sequence
from pathlib import Path
from random import Random
from typing import Any, Literal, NamedTuple

import msgspec
import psutil

from benchmarks.chaos.cloud_processes import FORKED, CloudProcessInfo, cloud_processes
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError
from ppaas.traffic.taking_part import TRAFFIC
from robots.client.rest import RestClient

How = Literal["kill", "stop", "drain"]


class FaultKind(NamedTuple):
    """A kind of fault: ``kill`` sends SIGKILL, ``stop`` sends SIGSTOP, ``drain`` moves all containers off a machine."""

    victim: str
    how: How

    def __str__(self) -> str:
        return f"{self.victim}, {_IN_WORDS[self.how]}"


_IN_WORDS = {"kill": "killed", "stop": "stopped", "drain": "drained"}

OF_ONE_MACHINE = (
    FaultKind("container", "kill"), FaultKind("container", "kill"), FaultKind("container", "stop"),
    FaultKind("fork server", "kill"), FaultKind("fork server", "stop"),
    FaultKind("router", "kill"), FaultKind("router", "stop"),
    FaultKind("agent", "kill"), FaultKind("agent", "stop"),
    FaultKind("helper", "kill"),
    FaultKind("master", "kill"), FaultKind("master", "stop"),
    FaultKind("endpoint", "kill"), FaultKind("endpoint", "stop"),
)  # fmt: skip
"""Faults of a cloud with one machine; containers are killed twice as often as other processes."""

OF_MORE = (FaultKind("joined machine", "kill"), FaultKind("joined machine", "stop"), FaultKind("machine", "drain"))
"""Additional faults of a cloud with joined machines."""

OF_TWO_MASTERS = (FaultKind("standby", "kill"), FaultKind("standby", "stop"))
"""Additional faults of a cloud with a standby."""

OF_TRAFFIC = (FaultKind("traffic node", "kill"), FaultKind("traffic node", "kill"), FaultKind("traffic node", "stop"))
"""Additional faults of a cloud with robots in traffic."""

PAUSES = {"master": (3.0,), "standby": (3.0, 8.0), "joined machine": (8.0,)}
"""Times after which stopped processes continue, for processes that the cloud itself cannot kill [s]."""

REPLACED_AFTER = 8.0
"""Another such time for a master that a standby replaces meanwhile [s]. The other one is just the standby's patience,
so that the master goes on while it is replaced."""

LONGEST_STOP = 25.0
"""Time after which other stopped processes continue if the cloud has not killed them [s]."""


class CloudSize(NamedTuple):
    """Size of a cloud: the parts that may fail.

    Parameters
    ----------
    machines : int
        Number of its machines.
    standby : bool
        Whether it has a standby.
    traffic : bool
        Whether it has robots in traffic.
    """

    machines: int
    standby: bool = False
    traffic: bool = False


class InjectedFault(msgspec.Struct):
    """An injected fault.

    Parameters
    ----------
    name : str
        Kind of the fault, in words.
    at : float
        Time of the fault [monotonic s].
    home : str
        Name of the machine of the process, or of the drained machine.
    pid : int
        Process id; 0 for a drained machine.
    until : float
        Time when a stopped process continued or had exited; infinite until then, 0 if nothing was stopped.
    """

    name: str
    at: float
    home: str = ""
    pid: int = 0
    until: float = 0.0


def pauses(victim: str, *, standby: bool) -> Sequence[float]:
    """Return the times after which a stopped process may continue [s]; ``standby`` is true in a cloud with one."""
    ordinary = PAUSES.get(victim, (LONGEST_STOP,))
    return (*ordinary, REPLACED_AFTER) if standby and victim == "master" else ordinary


def deck(random: Random, cloud: CloudSize) -> Iterator[FaultKind]:
    """Yield kinds without end: all kinds in random order, then again in another order."""
    kinds = [*OF_ONE_MACHINE, *(OF_MORE if cloud.machines > 1 else ()), *(OF_TWO_MASTERS if cloud.standby else ())]
    kinds += OF_TRAFFIC if cloud.traffic else ()
    while True:
        random.shuffle(kinds)
        yield from kinds


logger = logging.getLogger(__name__)

# -- injects faults one after the other and continues processes that stay stopped --------------------------------------

HELPERS = frozenset((FORKED, "compiler"))
"""Kinds of helper processes: containers that only plan, builders of map layers, compilers of kernels."""

DRAIN = 5.0
"""Time for which a machine is drained [s]."""

SPREAD = 0.5, 1.5
"""Shortest and longest time between two faults, as multiples of the mean."""

LOOK = 0.2
"""Period at which a stopped process is checked [s]."""


class Injector:
    """Injects faults at random times.

    Parameters
    ----------
    rest : RestClient
        Login of an administrator, to list the containers of robots.
    folder : Path
        Folder of the cloud for temporary files.
    random : Random
        Chooses kinds, victims and times.
    cloud : CloudSize
    tell : callable
        Called with a description of each error.
    """

    def __init__(
        self,
        rest: RestClient,
        folder: Path,
        random: Random,
        cloud: CloudSize,
        tell: Callable[[str], None],
    ) -> None:
        self._rest = rest
        self._folder = folder
        self._random = random
        self._standby = cloud.standby
        self._kinds = deck(random, cloud)
        self._tell = tell
        self._over = asyncio.Event()
        self._going_on: set[asyncio.Task[None]] = set()
        self.faults: list[InjectedFault] = []

    async def run(self, seconds: float, every: float) -> None:
        """Inject faults for a while; then continue all stopped processes.

        Parameters
        ----------
        seconds : float
            Duration [s].
        every : float
            Mean time between two faults [s].
        """
        end = monotonic() + seconds
        while (left := end - monotonic()) > 0.0:
            await self._do(next(self._kinds))
            await asyncio.sleep(min(left, every * self._random.uniform(*SPREAD)))
        self._over.set()
        await asyncio.gather(*self._going_on)

    async def _do(self, kind: FaultKind) -> None:
        try:
            if kind.how == "drain":
                await self._drain(kind)
            else:
                await self._signal(kind)
        except (PPaaSError, psutil.Error) as error:  # the cloud is unreachable, or the victim has just exited
            logger.info("no fault (%s): %s", kind, error)

    async def _signal(self, kind: FaultKind) -> None:
        found = await asyncio.to_thread(cloud_processes, self._folder)
        victims = await self._victims(kind, found)
        if not victims:
            logger.info("no fault (%s): no such process runs", kind)
            return
        victim = self._random.choice(sorted(victims, key=lambda member: member.process.pid))
        fault = InjectedFault(str(kind), monotonic(), victim.home, victim.process.pid)
        self.faults.append(fault)
        if kind.how == "kill":
            victim.process.kill()
            return
        victim.process.suspend()
        fault.until = math.inf
        pause = self._random.choice(pauses(kind.victim, standby=self._standby))
        self._later(self._go_on(victim.process, pause, fault))

    async def _victims(self, kind: FaultKind, found: Sequence[CloudProcessInfo]) -> list[CloudProcessInfo]:
        if kind.victim not in ("container", "helper", "traffic node"):
            return [member for member in found if member.kind == kind.victim]
        containers = await self._rest.items("/v1/containers")
        clones = {one["pid"] for one in containers if one["robot"] is not None}
        traffic = {one["pid"] for one in containers if one["kind"] == TRAFFIC}
        if kind.victim == "helper":
            return [one for one in found if one.kind in HELPERS and one.process.pid not in clones | traffic]
        return [one for one in found if one.process.pid in (clones if kind.victim == "container" else traffic)]

    async def _go_on(self, process: psutil.Process, pause: float, fault: InjectedFault) -> None:
        """Continue a stopped process after a pause, or at the end of the run, unless it has exited."""
        end = fault.at + pause
        while _lives(process) and monotonic() < end and not self._over.is_set():
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(LOOK):
                    await self._over.wait()
        with contextlib.suppress(psutil.NoSuchProcess):
            process.send_signal(signal.SIGCONT)
        fault.until = monotonic()

    async def _drain(self, kind: FaultKind) -> None:
        """Drain the machine with the most containers, so that robots move to other machines."""
        machines = await self._rest.items("/v1/machines")
        fullest = max(machines, key=lambda machine: machine["containers"])["id"]
        self.faults.append(InjectedFault(str(kind), monotonic(), fullest))
        await self._rest.patch(f"/v1/machines/{fullest}", {"draining": True})
        self._later(self._undrain(fullest))

    async def _undrain(self, machine: str) -> None:
        """End the drain of a machine; retry while the machine or the cloud is unreachable."""
        await asyncio.sleep(DRAIN)
        for _ in range(60):
            try:
                await self._rest.patch(f"/v1/machines/{machine}", {"draining": False})
                return
            except PPaaSError as error:
                logger.info("machine %s is not undrained yet: %s", machine, error)
                await asyncio.sleep(1.0)
        self._tell(f"machine {machine} did not come back after it was drained")

    def _later(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(work)
        self._going_on.add(task)
        task.add_done_callback(self._going_on.discard)


def _lives(process: psutil.Process) -> bool:
    try:
        return bool(process.status() != psutil.STATUS_ZOMBIE)
    except psutil.NoSuchProcess:
        return False
