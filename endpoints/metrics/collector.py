"""The metrics of a cloud, read from its master at each scrape."""

import asyncio
import logging
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import CancelledError
from typing import get_args

from prometheus_client.core import CounterMetricFamily, Metric
from prometheus_client.registry import Collector

from endpoints.metrics.families import by_state, counters, gauge, gauges, histogram
from endpoints.metrics.snapshot import Snapshot, SnapshotSource
from engine.control.counts import REQUEST_SECONDS
from engine.control.master_calls.interface import RequestCounts
from engine.control.views import ContainerView, EndpointViewState, GoalState, MachineState, MachineView
from engine.leadership.leadership import Leadership
from engine.processes.occasional_log import OccasionalLog
from ppaas import __version__
from ppaas.errors import PPaaSError
from ppaas.tasks.records import OPEN
from storage.disk_space import SpaceState

logger = logging.getLogger(__name__)

PATIENCE = 5.0
"""Time that the master has to answer a scrape [s]; stores that are away take `store_health.PATIENCE` of it."""

ENDED: tuple[GoalState, ...] = ("succeeded", "canceled", "aborted", "rejected", "lost")
"""Results of goals."""

STATUSES = "1xx", "2xx", "3xx", "4xx", "5xx"


class CloudCollector(Collector):
    """Collects the metrics of a cloud; for use in any thread, beside the event loop that the master runs on.

    Before this process leads, and while the master does not answer, a scrape has the metrics of its role alone.

    Parameters
    ----------
    loop : AbstractEventLoop
        Loop of the master.
    robots : bool
        Whether robots are listed by name.

    Attributes
    ----------
    robots : bool
        Whether robots are listed by name.
    leadership : Leadership, optional
        Leadership of this process; None until it leads.
    source : SnapshotSource, optional
        Reads the state of the cloud; None until this process leads it.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, *, robots: bool = False) -> None:
        self._loop = loop
        self.robots = robots
        self._faults = OccasionalLog(logger)
        self.leadership: Leadership | None = None
        self.source: SnapshotSource | None = None

    def collect(self) -> Iterator[Metric]:
        """Yield the metrics; blocks."""
        leader = self.leadership
        yield gauges("ppaas_build_info", "Release of the software", ["version"], [([__version__], 1.0)])
        yield gauge("ppaas_leader", "1 if this process leads the cloud", leader is not None and leader.leads())
        yield gauge("ppaas_epoch", "Epoch of this master; 0 before it leads", 0 if leader is None else leader.epoch)
        found = self._read()
        yield gauge("ppaas_scrape_complete", "1 if the scrape has the state of the cloud", found is not None)
        if found is not None:
            yield from _metrics(found)
            if self.robots:
                yield _robots_by_name(found.containers)

    def _read(self) -> Snapshot | None:
        if self.source is None:
            return None
        reading = asyncio.run_coroutine_threadsafe(self.source.read(), self._loop)
        try:
            found = reading.result(PATIENCE)
        except (PPaaSError, TimeoutError, CancelledError) as error:
            reading.cancel()
            self._faults.warning("a scrape lacks the state of the cloud: %s", str(error) or type(error).__name__)
            return None
        self._faults.is_over("scrapes have the state of the cloud again")
        return found


def _metrics(found: Snapshot) -> Iterator[Metric]:
    yield from _stores(found)
    yield from _machines(found.machines)
    yield from _robots(found)
    yield from _endpoints(found)
    yield from _counts(found)


def _stores(found: Snapshot) -> Iterator[Metric]:
    answers = [(["main"], found.store.answers), (["maps"], found.map_store.answers)]
    yield gauges("ppaas_store_up", "1 if the store answers", ["store"], answers)
    yield gauge("ppaas_plans_waiting", "Plans on the disk that wait for the store", found.store.waiting)
    yield gauge("ppaas_audit_up", "1 if the audit log can be written", found.audit)
    if found.disk is not None:
        yield gauge("ppaas_disk_free_bytes", "Free space of the disk of the data folder", found.disk.free)
        yield gauge("ppaas_disk_size_bytes", "Size of the disk of the data folder", found.disk.total)
        state = {found.disk.state: 1.0}
        yield by_state("ppaas_disk_state", "1 for the state of that disk", get_args(SpaceState), state)


def _machines(machines: list[MachineView]) -> Iterator[Metric]:
    states = Counter(one.state for one in machines)
    yield by_state("ppaas_machines", "Machines of the cloud", get_args(MachineState), states)
    listed = (
        ("cores", "CPUs", [one.cores for one in machines]),
        ("load_cores", "CPU in use", [one.load for one in machines]),
        ("capacity_cores", "Size that it may give to containers", [one.capacity for one in machines]),
        ("given_cores", "Sum of the sizes of its containers", [one.given for one in machines]),
        ("containers", "Containers on it", [one.containers for one in machines]),
        ("memory_bytes", "Memory", [one.memory for one in machines]),
        ("memory_used_bytes", "Memory in use", [one.memory_used for one in machines]),
        ("network_bytes_per_second", "Data sent and received", [one.network_used for one in machines]),
    )
    for name, text, values in listed:
        named = (([one.id], value) for one, value in zip(machines, values, strict=True))
        yield gauges(f"ppaas_machine_{name}", f"{text}, by machine", ["machine"], named)


def _robots(found: Snapshot) -> Iterator[Metric]:
    kinds = (([one.kind, one.state], 1.0) for one in found.containers)
    yield gauges("ppaas_containers", "Containers", ["kind", "state"], kinds)
    here = Counter("connected" if one.connected else "away" for one in found.containers if one.kind == "robot")
    states = {**here, "queued": found.queued, "gone": found.gone}
    yield by_state("ppaas_robots", "Robots", ("connected", "away", "queued", "gone"), states)
    groups = Counter(group.state for group in found.people)
    yield by_state("ppaas_people_groups", "Groups of robots", ("refused", "starting", "ready"), groups)
    yield by_state("ppaas_tasks", "Tasks that have not ended", sorted(OPEN), found.tasks)


def _robots_by_name(containers: list[ContainerView]) -> Metric:
    robots = (([one.user, one.robot], float(one.connected)) for one in containers if one.robot is not None)
    return gauges("ppaas_robot_connected", "1 if the robot is connected", ["user", "robot"], robots)


def _endpoints(found: Snapshot) -> Iterator[Metric]:
    endpoints = found.endpoints
    states = Counter(one.state for one in endpoints)
    yield by_state("ppaas_endpoints", "Endpoints", get_args(EndpointViewState), states)
    listed = (
        ("sockets", "Sockets of robots and operators", [one.sockets for one in endpoints]),
        ("frames_per_second", "Frames that clients sent", [one.frames for one in endpoints]),
        ("cpu_cores", "CPU in use", [one.cpu for one in endpoints]),
        ("memory_bytes", "Memory in use", [one.memory for one in endpoints]),
    )
    for name, text, values in listed:
        named = (([one.id], value) for one, value in zip(endpoints, values, strict=True))
        yield gauges(f"ppaas_endpoint_{name}", f"{text}, by endpoint", ["endpoint"], named)
    yield from _requests(found.requests)


def _requests(requests: dict[str, RequestCounts]) -> Iterator[Metric]:
    answers = (
        ([endpoint, status], number)
        for endpoint, counted in requests.items()
        for status, number in zip(STATUSES, counted.statuses, strict=True)
    )
    yield counters("ppaas_requests", "Requests by HTTP that were answered", ["endpoint", "status"], answers)
    times = (([name], (REQUEST_SECONDS, counted.seconds, counted.total)) for name, counted in requests.items())
    yield histogram("ppaas_request_seconds", "Time until the answer to a request began", ["endpoint"], times)


def _counts(found: Snapshot) -> Iterator[Metric]:
    counts = found.counts
    goals = (([result], counts.goals[result]) for result in ENDED)
    yield counters("ppaas_goals", "Goals of REST and of tasks that have ended", ["result"], goals)
    text, placed = "Time from the order to start a container until it answered", counts.placements
    yield histogram("ppaas_placement_seconds", text, [], [([], (placed.limits, placed.counts, placed.total))])
    text = "Containers that were replaced"
    yield CounterMetricFamily("ppaas_containers_lost", text, value=counts.containers_lost)
    text = "Machines that left and were not removed"
    yield CounterMetricFamily("ppaas_machines_lost", text, value=counts.machines_lost)
