"""All that requests are served from: the stores, the accounts, the control plane of the cloud, and caches."""

from dataclasses import dataclass, field

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.usage import Holdings
from endpoints.services.control_plane import ControlPlane
from endpoints.services.installed_planners import InstalledPlanners
from endpoints.services.map_cache import MapHeads
from endpoints.services.plan_writer import PlanKeeper
from endpoints.services.request_limits import Settings
from endpoints.services.store_health import Health
from storage.ports import MapStore, Store


@dataclass(frozen=True, slots=True)
class Services:
    """All that a request may need, made once and handed to the application."""

    store: Store
    map_store: MapStore
    accounts: Accounts
    cloud: ControlPlane
    settings: Settings = field(default_factory=Settings)
    health: Health = field(default_factory=Health)
    plan_keeper: PlanKeeper = field(default_factory=PlanKeeper)
    map_heads: MapHeads = field(default_factory=MapHeads)
    holdings: Holdings = field(default_factory=Holdings)
    planners: InstalledPlanners = field(default_factory=InstalledPlanners)
