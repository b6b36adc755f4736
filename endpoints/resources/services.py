"""Services that requests use: the stores, the accounts, the control plane of the cloud, limits and caches."""

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from starlette.concurrency import run_in_threadpool

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.usage import Usage
from endpoints.audit.data_folder import DataFolder, DataFolderCalls
from endpoints.audit.event import AuditLog, MemoryAuditLog
from endpoints.resources.heavy_work import HeavyWork
from endpoints.resources.installed_planners import InstalledPlanners
from endpoints.resources.joint_maps import JoinSchedule
from endpoints.resources.plan_writer import PlanWriter
from endpoints.resources.publications import Publications
from endpoints.resources.robot_files import PosegraphReader
from endpoints.resources.store_health import StoreHealthCheck
from endpoints.retention.calls import RetentionCalls
from endpoints.robot_checks.clone_checker import CloneChecker
from endpoints.sharing.shared_robots import ShareCache
from endpoints.webhooks.calls import WebhookCalls
from engine.control.journeys.calls import JourneyCalls
from engine.control.master_calls.control_plane import ControlPlane
from engine.control.planning.building_requests import KeptLengths
from engine.specs.robot_stops import in_words, stops_key, stored_stops
from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError
from ppaas.messages.health.stops import RobotStop
from storage.disk_space import DiskReserve
from storage.ports import CloneStore, MapStore, Store
from storage.recordings import RecordingsFolder
from storage.records import MapRecord, RobotRecord
from storage.store_cache import LIFETIME, PATIENCE, SIZE, StoreCache

if TYPE_CHECKING:
    from endpoints.oidc.logins import OidcLogins

MIB = 1 << 20


@dataclass(frozen=True, slots=True)
class RequestLimits:
    """Limits of the REST service.

    Parameters
    ----------
    max_body : int
        Largest body of a request except uploads and logins [bytes].
    max_login : int
        Largest body of a login [bytes]: the only body that is read before its caller is authenticated.
    max_upload : int
        Largest body of a map upload: its files and the form [bytes].
    max_body_seconds, max_upload_seconds : float
        Time limit for receiving such a body [s].
    max_plan_seconds : float
        Largest time limit of a path request [s].
    """

    max_body: int = 1 * MIB
    max_login: int = 16 << 10
    max_upload: int = 260 * MIB  # a binary PGM of 16384 x 16384 cells, zones and YAML
    max_body_seconds: float = 30.0
    max_upload_seconds: float = 300.0
    max_plan_seconds: float = 60.0


class MapHeadCache(StoreCache[MapRecord]):
    """Heads of recently requested maps.

    Parameters
    ----------
    size, lifetime, patience
        As of ``StoreCache``.
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(
        self,
        size: int = SIZE,
        lifetime: float = LIFETIME,
        clock: Clock = monotonic,
        patience: float = PATIENCE,
    ) -> None:
        super().__init__(size, lifetime, patience)
        self._clock = clock

    async def head(self, store: MapStore, map_id: str) -> MapRecord:
        """Return a map without its files; ``NotFound`` if it does not exist.

        While the store is unreachable, the last known head is returned, if there is one.
        """

        async def load() -> tuple[MapRecord, float]:
            return await run_in_threadpool(store.map_head, map_id), math.inf

        return await self.read(map_id, self._clock(), load)


FRESH_STOPS = 5.0
"""Time for which stops are valid [s]: a master of the release before does not report that it has changed them."""


class StopCache(StoreCache[tuple[RobotStop, ...]]):
    """Stops of robots by owner, so that lists of robots, which consoles read all the time, do not read the store.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        super().__init__(lifetime=FRESH_STOPS)
        self._clock = clock

    async def why_stopped(self, store: CloneStore, robots: Sequence[RobotRecord]) -> list[str | None]:
        """Return for each of some robots the stops that apply, in words; None if there are none."""
        owners = {robot.user for robot in robots}
        return in_words({owner: await self._stops(store, owner) for owner in owners}, robots)

    def forget_users(self, users: Iterable[str]) -> None:
        """Read the stops of the robots of users again, because they were changed; the master reports it to others."""
        self.drop(*map(stops_key, users))

    async def _stops(self, store: CloneStore, owner: str) -> tuple[RobotStop, ...]:
        async def load() -> tuple[tuple[RobotStop, ...], float]:
            return await run_in_threadpool(stored_stops, store, owner), math.inf

        return await self.read(stops_key(owner), self._clock(), load)


# Refused connects: why the last attempt of a robot to connect failed, for its diagnosis.

MOST_ROBOTS = 1000
"""Largest number of robots whose last refusal is kept."""

MOST_TEXT = 400
"""Length of the reason that is kept [characters]."""


class RefusedConnect(NamedTuple):
    """Refusal of an attempt to connect: its reason, and the time since then [s]."""

    reason: str
    ago: float


class RefusedConnects:
    """Last refusals by user and robot.

    They belong to this endpoint: a diagnosis by way of another endpoint does not name them, and a connect by way of
    another endpoint does not end them.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._refused: BoundedDict[tuple[str, str], tuple[float, str]] = BoundedDict(MOST_ROBOTS)

    @contextmanager
    def attempt(self, user: str, robot: str, role: str) -> Iterator[None]:
        """Note the error with which an attempt of a robot fails in the block; a success forgets the one before."""
        try:
            yield
        except PPaaSError as error:
            if role == "robot":
                self._refused[user, robot] = self._clock(), f"{error.slug}: {error.public}"[:MOST_TEXT]
            raise
        if role == "robot":
            self._refused.pop((user, robot), None)

    def last(self, user: str, robot: str) -> RefusedConnect | None:
        """Return the last refusal of a robot; None if it connected since, or never tried."""
        refused = self._refused.get((user, robot))
        return None if refused is None else RefusedConnect(refused[1], self._clock() - refused[0])


@dataclass(slots=True, eq=False)
class Services:
    """Services of the application, created once; only ``keep_versions`` and ``oidc`` change while it runs."""

    store: Store
    map_store: MapStore
    accounts: Accounts
    cloud: ControlPlane
    limits: RequestLimits = field(default_factory=RequestLimits)
    health: StoreHealthCheck = field(default_factory=StoreHealthCheck)
    plan_writer: PlanWriter = field(default_factory=PlanWriter)
    map_cache: MapHeadCache = field(default_factory=MapHeadCache)
    usage: Usage = field(default_factory=Usage)
    planners: InstalledPlanners = field(default_factory=InstalledPlanners)
    heavy_work: HeavyWork = field(default_factory=HeavyWork)
    copies: HeavyWork = field(default_factory=HeavyWork)
    """Turns of requests that hold a large temporary file until their response has been sent."""
    joint_maps: JoinSchedule = field(default_factory=JoinSchedule)
    publications: Publications = field(default_factory=Publications)
    posegraphs: PosegraphReader = field(default_factory=PosegraphReader)
    shares: ShareCache = field(default_factory=ShareCache)
    stops: StopCache = field(default_factory=StopCache)
    floor_lengths: KeptLengths = field(default_factory=KeptLengths)
    refused_connects: RefusedConnects = field(default_factory=RefusedConnects)
    clones: CloneChecker | None = None
    """Check of robot files by building their clones; without it, their containers report what they refuse."""
    disk: DiskReserve | None = None
    recordings: RecordingsFolder | None = None
    far_folder: DataFolderCalls | None = None
    """Data folder of the cloud, on an endpoint of another host, which has no folder of recordings."""
    webhooks: WebhookCalls | None = None
    """Webhooks in the process of the master; None if there is none to call."""
    retention: RetentionCalls | None = None
    """Retention in the process of the master; None if there is none to call."""
    journeys: JourneyCalls | None = None
    """Leader of journeys in the process of the master; None if there is none to call."""
    keep_versions: int | None = None
    audit: AuditLog = field(default_factory=MemoryAuditLog)
    oidc: "OidcLogins | None" = None
    """Logins with the identity provider of the cloud, if it has one."""
    endpoint: str = ""
    """Name of this endpoint; empty in the process of the master, which serves no REST."""

    @property
    def data_folder(self) -> DataFolderCalls:
        """Data folder of the cloud."""
        return self.far_folder or DataFolder(self.audit, self.recordings)
