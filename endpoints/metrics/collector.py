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
from endpoints.metrics.robot_watch import RobotSeen
from endpoints.metrics.snapshot import Snapshot, SnapshotSource
from endpoints.webhooks.service import WebhookNumbers
from engine.control.counts import REQUEST_SECONDS, ControlCounts
from engine.control.master_calls.interface import RequestCounts
from engine.control.views import EndpointViewState, GoalState, MachineState, MachineView
from engine.leadership.leadership import Leadership
from engine.processes.occasional_log import OccasionalLog
from engine.specs.work_counts import PLAN_SECONDS
from ppaas import __version__
from ppaas.errors import PPaaSError
from ppaas.tasks.records import OPEN
from storage.disk_space import SpaceState
from storage.webhooks.records import DeliveryState, WebhookState

logger = logging.getLogger(__name__)

PATIENCE = 5.0
"""Time that the master has to answer a scrape [s]; stores that are away take `store_health.PATIENCE` of it."""

ENDED: tuple[GoalState, ...] = ("succeeded", "canceled", "aborted", "rejected", "lost")
"""Results of goals."""

LOW_BATTERY = 0.2
"""Charge below which a battery is low."""

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
                yield from _robots_by_name(found.robots)

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
    yield from _containers(found)
    yield from _endpoints(found)
    yield from _webhooks(found.webhooks)
    yield from _counts(found.counts)


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
    if found.certificate_ends is not None:
        yield gauge("ppaas_certificate_end_seconds", "End of the certificate of the cloud", found.certificate_ends)


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
    robots = found.robots
    here = Counter("connected" if one.connected else "away" for one in robots)
    states = {**here, "queued": found.queued, "gone": found.gone}
    yield by_state("ppaas_robots", "Robots", ("connected", "away", "queued", "gone"), states)
    connected = [one for one in robots if one.connected]
    yield gauge("ppaas_robots_stopped", "Connected robots that a stop holds", sum(one.stopped for one in connected))
    yield gauge("ppaas_robots_waiting", "Connected robots that stand with a goal", sum(one.waits for one in connected))
    yield gauge("ppaas_longest_wait_seconds", "Time for which one of them has been found waiting", found.longest_wait)
    low = sum(one.report.battery is not None and one.report.battery < LOW_BATTERY for one in connected)
    yield gauge("ppaas_robots_battery_low", f"Connected robots with a charge below {LOW_BATTERY:g}", low)


def _robots_by_name(robots: list[RobotSeen]) -> Iterator[Metric]:
    labels = ["user", "robot"]
    connected = (([one.user, one.robot], float(one.connected)) for one in robots)
    yield gauges("ppaas_robot_connected", "1 if the robot is connected", labels, connected)
    known = [(one, one.report.battery) for one in robots]
    charges = (([one.user, one.robot], charge) for one, charge in known if charge is not None)
    yield gauges("ppaas_robot_battery_ratio", "Charge of the battery, from 0 to 1", labels, charges)


def _containers(found: Snapshot) -> Iterator[Metric]:
    kinds = (([one.kind, one.state], 1.0) for one in found.containers)
    yield gauges("ppaas_containers", "Containers", ["kind", "state"], kinds)
    groups = Counter(group.state for group in found.people)
    yield by_state("ppaas_people_groups", "Groups of robots", ("refused", "starting", "ready"), groups)
    yield by_state("ppaas_tasks", "Tasks that have not ended", sorted(OPEN), found.tasks)


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


def _webhooks(found: WebhookNumbers) -> Iterator[Metric]:
    yield by_state("ppaas_webhooks", "Webhooks", get_args(WebhookState), found.states)
    text = "Deliveries of webhooks in the store"
    yield by_state("ppaas_webhook_deliveries", text, get_args(DeliveryState), found.deliveries)
    attempts = (([result], number) for result, number in found.attempts.items())
    yield counters("ppaas_webhook_attempts", "Attempts to deliver by what became of them", ["result"], attempts)
    text = "Events that no webhook got, as the store was away"
    yield CounterMetricFamily("ppaas_webhook_events_lost", text, value=found.lost)


def _counts(counts: ControlCounts) -> Iterator[Metric]:
    goals = (([result], counts.goals[result]) for result in ENDED)
    yield counters("ppaas_goals", "Goals that have ended", ["result"], goals)
    text, (classes, total) = "Time in which a plan was computed", counts.plans()
    yield histogram("ppaas_plan_seconds", text, [], [([], (PLAN_SECONDS, classes, total))])
    origins = (([origin], number) for origin, number in counts.plan_origins().items())
    yield counters("ppaas_plans", "Requests for plans by how they ended", ["result"], origins)
    text, placed = "Time from the order to start a container until it answered", counts.placements
    yield histogram("ppaas_placement_seconds", text, [], [([], (placed.limits, placed.counts, placed.total))])
    text, waited = "Time from the request for a lift until the robot boards", counts.lift_waits
    yield histogram("ppaas_lift_wait_seconds", text, [], [([], (waited.limits, waited.counts, waited.total))])
    text = "Containers that were replaced"
    yield CounterMetricFamily("ppaas_containers_lost", text, value=counts.containers_lost)
    text = "Machines that left and were not removed"
    yield CounterMetricFamily("ppaas_machines_lost", text, value=counts.machines_lost)
