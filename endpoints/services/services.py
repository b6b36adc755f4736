"""Services that requests use: the stores, the accounts, the control plane of the cloud, and caches."""

from dataclasses import dataclass, field

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.usage import Usage
from endpoints.audit.data_folder import DataFolder, DataFolderCalls
from endpoints.audit.event import AuditLog, MemoryAuditLog
from endpoints.robot_checks.clone_checker import CloneChecker
from endpoints.services.heavy_work import HeavyWork
from endpoints.services.installed_planners import InstalledPlanners
from endpoints.services.joint_maps import JointMaps
from endpoints.services.map_cache import MapHeadCache
from endpoints.services.plan_writer import PlanWriter
from endpoints.services.publications import Publications
from endpoints.services.refused_connects import RefusedConnects
from endpoints.services.request_limits import RequestLimits
from endpoints.services.robot_files import PosegraphReader
from endpoints.services.store_health import StoreHealthCheck
from endpoints.sharing.shared_robots import ShareCache
from engine.service.endpoints.control_plane import ControlPlane
from storage.disk_space.reserve import DiskReserve
from storage.ports import MapStore, Store
from storage.recordings.folder import RecordingsFolder


@dataclass(frozen=True, slots=True)
class Services:
    """Services of the application, created once."""

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
    joint_maps: JointMaps = field(default_factory=JointMaps)
    publications: Publications = field(default_factory=Publications)
    posegraphs: PosegraphReader = field(default_factory=PosegraphReader)
    shares: ShareCache = field(default_factory=ShareCache)
    refused_connects: RefusedConnects = field(default_factory=RefusedConnects)
    clones: CloneChecker | None = None
    """Check of robot files by building their clones; without it, their containers report what they refuse."""
    disk: DiskReserve | None = None
    recordings: RecordingsFolder | None = None
    far_folder: DataFolderCalls | None = None
    """Data folder of the cloud, on an endpoint of another host, which has no folder of recordings."""
    keep_versions: int | None = None
    audit: AuditLog = field(default_factory=MemoryAuditLog)
    endpoint: str = ""
    """Name of this endpoint; empty in the process of the master, which serves no REST."""

    @property
    def data_folder(self) -> DataFolderCalls:
        """Data folder of the cloud."""
        return self.far_folder or DataFolder(self.audit, self.recordings)
