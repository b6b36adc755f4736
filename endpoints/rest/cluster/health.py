"""Route of the cloud's health, for monitoring."""

import asyncio

from fastapi import APIRouter, Request

from endpoints.accounts.authentication import authenticate
from endpoints.rest.cluster.schemas import HealthAnswer
from endpoints.rest.dependencies import Provided
from endpoints.services.services import Services
from endpoints.services.store_health import DiskState, StoreState, disk_state
from ppaas import __version__
from ppaas.clock import epoch
from ppaas.errors import PPaaSError

router = APIRouter(prefix="/health", tags=["health"])


@router.get("", response_model=HealthAnswer)
async def show_health(request: Request, services: Provided) -> dict[str, object]:
    """Show whether the stores are reachable and have space. It needs no token; only administrators see reasons.

    While a store is unreachable, the cloud is `degraded`: robots keep driving and paths are planned on maps that are
    cached, and new paths wait on the disk for the store. It is `degraded` too while the disk of its data folder is
    full, when nothing new is stored, and while the audit log cannot be written; its events wait in memory.
    """
    store, map_store = await services.health.stores(services.store, services.map_store)
    disk = await asyncio.to_thread(disk_state, services.disk) if services.disk is not None else None
    reasons = await _may_see_reasons(request, services)
    is_full = disk is not None and disk.state == "full"
    audit = StoreState(services.audit.fault is None, services.audit.fault)
    is_ok = store.answers and map_store.answers and audit.answers and not store.waiting and not is_full
    return {
        "status": "ok" if is_ok else "degraded",
        "version": __version__,
        "time": epoch(),
        "store": _store_health(store, reasons),
        "map_store": _store_health(map_store, reasons),
        "audit": _store_health(audit, reasons),
        "plans_waiting": store.waiting,
        "disk": _disk_health(disk) if reasons and disk is not None else None,
    }


async def _may_see_reasons(request: Request, services: Services) -> bool:
    try:
        return (await authenticate(request, services.accounts)).role == "admin"
    except PPaaSError:
        return False


def _disk_health(disk: DiskState) -> dict[str, object]:
    return {"state": disk.state, "reason": disk.reason, "free": disk.free, "total": disk.total}


def _store_health(state: StoreState, reasons: bool) -> dict[str, object]:
    return {"state": "ok" if state.answers else "away", "reason": state.reason if reasons else None}
