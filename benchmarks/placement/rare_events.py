"""Rare events of a cloud: published maps, lost machines and endpoints, refusals and draining; and heartbeats.

Each is timed a few times at the size that the cloud has.
"""

from collections.abc import Iterator
from itertools import count, islice

import msgspec

from benchmarks.placement.arrivals import RobotArrival
from benchmarks.placement.simulated_cloud import CORES, MEMORY, ROUND_TRIP, SimulatedCloud
from engine.master.events import MachineLeft, MachineMeasured, MapChanged, PlaceRequested, SettingsChanged
from engine.master.places import PlaceRequest
from engine.protocols import control_link
from engine.specs.containers import MapVersion
from engine.specs.machine_settings import MachineSettings
from ppaas.errors import Unavailable

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
