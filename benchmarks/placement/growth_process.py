"""Process that grows a simulated cloud, or adopts one; each has its own memory.

``python -m benchmarks.placement.growth_process grow FILE MACHINES ENDPOINTS ROBOTS`` writes the registrations of its
machines to a file, which ``… adopt FILE`` reads. Both print lines of JSON: ``{"done": N}``, and ``{"result": …}`` at
the end.
"""

import gc
import os
import struct
import sys
from collections.abc import Iterator
from itertools import count, islice
from pathlib import Path
from typing import Any

import msgspec

from benchmarks.harness.json_process import tell
from benchmarks.harness.process_usage import memory_of
from benchmarks.placement.arrivals import RobotArrival, events, generated
from benchmarks.placement.simulated_cloud import (
    CORES,
    MEMORY,
    ROUND_TRIP,
    SimulatedCloud,
    Sizes,
    TimedMaster,
    new_master,
    timed_collections,
)
from engine.master.events import (
    MachineJoined,
    MachineLeft,
    MachineMeasured,
    MapChanged,
    PlaceRequested,
    RobotTimed,
    SettingsChanged,
)
from engine.master.master import LOG_SIZE
from engine.master.places import PlaceRequest
from engine.protocols import control_link
from engine.specs.containers import MapVersion
from engine.specs.machine_settings import MachineSettings
from ppaas import __version__
from ppaas.errors import Unavailable

SECRET = "0" * 32
"""Secret of each machine and container; it has the length of a real one."""

LENGTH = struct.Struct("!I")
"""Length before each registration in the file [bytes]."""


def write_registrations(cloud: SimulatedCloud, file: Path) -> None:
    """Write to a file how each machine registers with the next master: with the clones that it runs."""
    with file.open("wb") as out:
        for machine in cloud.timed.master.machines.values():
            carries = tuple(
                control_link.RunningContainer(spec, spec.cores, SECRET, 1) for spec in machine.containers.values()
            )
            register = control_link.Register(machine.id, SECRET, 1, CORES, MEMORY, carries=carries, release=__version__)
            body = msgspec.msgpack.encode(register)
            out.write(LENGTH.pack(len(body)) + body)


def _registrations(file: Path) -> Iterator[bytes]:
    with file.open("rb") as frames:
        while head := frames.read(LENGTH.size):
            yield frames.read(LENGTH.unpack(head)[0])


def adopt(file: Path) -> Iterator[TimedMaster]:
    """Let machines register with a new master; yield it after each of them, and once more when its log is turned over.

    By then its log holds events of robots, like the log of any master that has led for a moment.
    """
    timed, decoder = new_master(), msgspec.msgpack.Decoder(control_link.Register)
    for frame in _registrations(file):
        register = timed.timed("registration, decoding", lambda body=frame: decoder.decode(body))  # type: ignore[misc]
        joined = MachineJoined(
            register.machine, register.cores, register.memory, register.pid, carries=register.carries
        )
        timed.handle("adoption", joined)
        yield timed
    for _ in range(LOG_SIZE):
        timed.master.handle(RobotTimed("robot:none/none", 0.0))
    yield timed


# -- rare events of a cloud --------------------------------------------------------------------------------------------

NEIGHBOURS = 8
"""Number of machines that each machine measures its distance to."""

REFUSED, HEARTBEATS, RELEASES = 100, 200, 100
"""Numbers of requests that find no machine, of heartbeats, and of releases while machines are drained."""

DRAINED = 100
"""Number of machines for each one that is drained."""

NOWHERE = {"zone": "nowhere"}
"""Labels that no machine has."""


def time_rare_events(cloud: SimulatedCloud) -> None:
    """Let the rare events happen to a cloud, one kind after the other."""
    names = list(cloud.timed.master.machines)
    for machine in names[:HEARTBEATS]:
        _beat(cloud, machine, names[:NEIGHBOURS])
    for map_id, kind in (("unused", "map without robots"), ("map0", "map of most robots")):
        cloud.timed.handle(kind, MapChanged(MapVersion(map_id, "v2"), number=1))
    cloud.lose_endpoint()
    cloud.start(cloud.timed.handle("machine lost", MachineLeft(names[-1])))
    cloud.join(names[-1])
    _fill_up(cloud)
    for machine in names[: max(1, len(names) // DRAINED)]:
        cloud.timed.master.handle(SettingsChanged(machine, MachineSettings(draining=True)))
    for key in cloud.connected(RELEASES):
        cloud.go(key, "release while draining")


def _beat(cloud: SimulatedCloud, machine: str, neighbours: list[str]) -> None:
    """Let a machine report the load of its containers."""
    containers = cloud.timed.master.machines[machine].containers
    loads = [control_link.ContainerLoad(container, 0.05, 13 << 20) for container in containers]
    told = control_link.Heartbeat(4.0, MEMORY >> 2, loads, 1e6, dict.fromkeys(neighbours, ROUND_TRIP))
    frame, decoder = msgspec.msgpack.encode(told), msgspec.msgpack.Decoder(control_link.Heartbeat)
    load = cloud.timed.timed("heartbeat, decoding", lambda: decoder.decode(frame))
    cloud.timed.handle("heartbeat", MachineMeasured(machine, load))


def _fill_up(cloud: SimulatedCloud) -> None:
    """Request the largest containers until no machine has room for one; then request more, and with other labels."""
    for request in _large("large"):
        try:
            cloud.start(cloud.timed.master.handle(PlaceRequested(request)))
        except Unavailable:
            break
    for request in islice(_large("late"), REFUSED):
        _refused(cloud, "refusal, no room", request)
    for request in islice(_large("odd", NOWHERE), REFUSED):
        _refused(cloud, "refusal, no labels", request)


def _large(prefix: str, labels: dict[str, str] | None = None) -> Iterator[PlaceRequest]:
    """Yield requests for the largest containers, without end."""
    for number in count():
        spec = RobotArrival(0.0, f"{prefix}-{number}", "map-of-the-large", float(CORES)).spec(0)
        yield PlaceRequest("large", spec.map, spec.cores, spec.robot, labels or {})


def _refused(cloud: SimulatedCloud, kind: str, request: PlaceRequest) -> None:
    try:
        cloud.timed.handle(kind, PlaceRequested(request))
    except Unavailable:
        return
    raise Unavailable(f"the bench expected that no machine has room for {request.key}")


ROBOTS_PER_MAP = 50
"""Mean number of robots of a map."""

TOLD_EVERY = 2000
"""Number of robots between two lines of progress."""


def _grow(file: Path, sizes: Sizes) -> dict[str, Any]:
    """Let all robots come, some roam and half of them go; write the registrations, and time rare events."""
    cloud = SimulatedCloud(sizes)
    with timed_collections() as collections:
        for event in events(generated(sizes.robots, max(1, sizes.robots // ROBOTS_PER_MAP), seed=1)):
            cloud.take(event)
            if event.comes and event.number % TOLD_EVERY == 0:
                tell({"done": event.number})
    cloud.timed.costs["collection"] = collections
    write_registrations(cloud, file)
    places = len(cloud.timed.master.places)
    time_rare_events(cloud)
    return {"costs": cloud.timed.costs, "places": places, "rejected": cloud.rejected}


def _adopt(file: Path) -> dict[str, Any]:
    """Adopt all containers, and weigh the master that has them."""
    before = memory_of(os.getpid()).private
    with timed_collections() as collections:
        for number, timed in enumerate(adopt(file)):  # noqa: B007 - the last one is the result
            if number % 100 == 0:
                tell({"done": number})
    timed.costs["adoption, collection"] = collections
    gc.collect()
    memory = memory_of(os.getpid()).private - before
    return {"costs": timed.costs, "places": len(timed.master.places), "memory_mb": memory}


def main() -> int:
    """Run one of the two."""
    what, file, *numbers = sys.argv[1:]
    result = _adopt(Path(file)) if what == "adopt" else _grow(Path(file), Sizes(*map(int, numbers)))
    tell({"result": result})
    return 0


if __name__ == "__main__":
    sys.exit(main())
