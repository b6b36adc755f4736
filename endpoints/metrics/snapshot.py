"""State of a cloud at one moment, as the master knows it and scrapes report it."""

import asyncio
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from endpoints.metrics.robot_watch import RobotSeen, RobotWatch
from endpoints.resources.services import Services
from endpoints.resources.store_health import DiskState, StoreState, disk_state
from endpoints.webhooks.service import WebhookNumbers, Webhooks
from engine.control.counts import ControlCounts
from engine.control.master_calls.cloud import Cloud
from engine.control.master_calls.interface import RequestCounts
from engine.control.tasks.runner import TaskRunner
from engine.control.views import ContainerView, EndpointView, MachineView, PeopleGroupView
from ppaas.clock import epoch
from ppaas.tasks.records import TaskState

GONE = 900.0
"""Time for which a robot that disconnected counts as gone [s]; after that it was switched off."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """State of a cloud.

    Parameters
    ----------
    store, map_store : StoreState
    audit : bool
        Whether the audit log can be written.
    disk : DiskState, optional
        None if it is not watched, or cannot be measured.
    machines, containers, endpoints, people : list
    robots : list of RobotSeen
        Robots that have a container.
    longest_wait : float
        Time for which the robot that has waited longest was found waiting [s].
    requests : dict of str to RequestCounts
        Requests that each endpoint has answered.
    queued : int
        Number of places that wait for their turn.
    gone : int
        Number of robots that disconnected within `GONE` and did not come back.
    tasks : Counter of TaskState
        Tasks that have not ended.
    counts : ControlCounts
        What happened since the process of the master started.
    webhooks : WebhookNumbers
        What is known of webhooks, and what became of attempts.
    certificate_ends : float, optional
        End of the certificate of the cloud [s since the epoch]; None without TLS, or if it cannot be read.
    """

    store: StoreState
    map_store: StoreState
    audit: bool
    disk: DiskState | None
    machines: list[MachineView]
    containers: list[ContainerView]
    endpoints: list[EndpointView]
    people: list[PeopleGroupView]
    robots: list[RobotSeen]
    longest_wait: float
    requests: dict[str, RequestCounts]
    queued: int
    gone: int
    tasks: Counter[TaskState]
    counts: ControlCounts
    webhooks: WebhookNumbers
    certificate_ends: float | None


class SnapshotSource(Protocol):
    """Reader of the state of a cloud."""

    async def read(self) -> Snapshot:
        """Return the present state."""
        ...


class CloudSnapshots:
    """Reads the state of a cloud in the process of its master; implements ``SnapshotSource``.

    Parameters
    ----------
    services : Services
        Has the stores, the disk and the audit log.
    cloud : Cloud
        Has machines, containers, endpoints and robots.
    tasks : TaskRunner
        Leads the tasks.
    webhooks : Webhooks
        Sends events.
    certificate : Path, optional
        Certificate of the cloud in PEM.
    """

    def __init__(
        self, services: Services, cloud: Cloud, tasks: TaskRunner, webhooks: Webhooks, certificate: Path | None
    ) -> None:
        self._services = services
        self._cloud = cloud
        self._tasks = tasks
        self._webhooks = webhooks
        self._certificate = certificate
        self._robots = RobotWatch(cloud.containers, cloud.driver.place)

    async def read(self) -> Snapshot:
        """Return the present state; the states of the stores are cached, and waited for no longer than their limit."""
        services, cloud = self._services, self._cloud
        store, map_store = await services.health.stores(services.store, services.map_store)
        robots, longest_wait = await self._robots.read()
        return Snapshot(
            store=store,
            map_store=map_store,
            audit=services.audit.fault is None,
            disk=await asyncio.to_thread(disk_state, services.disk) if services.disk is not None else None,
            machines=await cloud.machines.views(),
            containers=await cloud.containers.views(None),
            endpoints=await cloud.endpoints.views(),
            people=await cloud.people.views(),
            robots=robots,
            longest_wait=longest_wait,
            requests=cloud.neighbours.requests(),
            queued=cloud.driver.queued(),
            gone=cloud.driver.presence.gone_since(epoch() - GONE),
            tasks=self._tasks.open_tasks(),
            counts=cloud.driver.counts,
            webhooks=self._webhooks.numbers(),
            certificate_ends=await asyncio.to_thread(_end_of, self._certificate) if self._certificate else None,
        )


def _end_of(certificate: Path) -> float | None:
    """Return when the first certificate of a file ends; None while the file cannot be read, as while it is replaced."""
    from cryptography import x509  # noqa: PLC0415 - for clouds with TLS alone

    try:
        return x509.load_pem_x509_certificate(certificate.read_bytes()).not_valid_after_utc.timestamp()
    except (OSError, ValueError):
        return None
