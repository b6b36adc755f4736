"""Routes of the cloud's health, for monitoring and for load balancers."""

import asyncio

import msgspec
from fastapi import APIRouter, Request

from endpoints.accounts.authentication import authenticate
from endpoints.resources.services import Services
from endpoints.resources.store_health import DiskState, StoreState, disk_state
from endpoints.rest.cluster.schemas import HealthAnswer, ReadyAnswer
from endpoints.rest.dependencies import Provided
from endpoints.rest.openapi import problems
from engine.leadership.leadership import MASTER
from engine.specs.start_state import StartState
from ppaas import __version__
from ppaas.clock import epoch
from ppaas.errors import PPaaSError, Unavailable

AWAY = 3.0
"""Time since the master answered after which it counts as away [s]; it is asked once a second."""

GRACE = 10.0
"""Time since the master answered after which an endpoint should get no new connections [s].

A master that was killed is restarted, or a standby leads, within less.
"""

router = APIRouter(prefix="/health", tags=["health"])


@router.get("", response_model=HealthAnswer)
async def show_health(request: Request, services: Provided) -> dict[str, object]:
    """Show whether the stores are reachable and have space. It needs no token; only administrators see reasons.

    The cloud is `starting` while none of its machines can start containers, as on the first start on a computer, which
    compiles the kernels of planners and nodes. `kernels` shows the progress, also afterwards, while kernels are
    compiled of planners that not every robot uses; requests that need them wait for them.

    While a store is unreachable, the cloud is `degraded`: robots keep driving and paths are planned on maps that are
    cached, and new paths wait on the disk for the store. It is `degraded` too while the disk of its data folder is
    full, when nothing new is stored, and while the audit log cannot be written; its events wait in memory.

    While the `master` is away, the cloud is `degraded` as well: robots that have a container drive on, with the
    operators that are connected. New connections, paths, and requests about machines and containers wait for the next
    master, and are `unavailable` after 15 s.
    """
    store, map_store = await services.health.stores(services.store, services.map_store)
    disk = await asyncio.to_thread(disk_state, services.disk) if services.disk is not None else None
    reasons = await _may_see_reasons(request, services)
    is_full = disk is not None and disk.state == "full"
    audit = StoreState(services.audit.fault is None, services.audit.fault)
    start = services.cloud.start
    is_led = services.cloud.master_silence < AWAY
    is_stored = store.answers and map_store.answers and audit.answers and not store.waiting and not is_full
    return {
        "status": "starting" if not start.ready else "ok" if is_stored and is_led else "degraded",
        "endpoint": services.endpoint,
        "master": "ok" if is_led else "away",
        "kernels": _kernels(start),
        "leader": await _leader(services) if reasons and store.answers else None,
        "version": __version__,
        "time": epoch(),
        "store": _store_health(store, reasons),
        "map_store": _store_health(map_store, reasons),
        "audit": _store_health(audit, reasons),
        "plans_waiting": store.waiting,
        "disk": _disk_health(disk) if reasons and disk is not None else None,
    }


@router.get("/ready", response_model=ReadyAnswer, responses=problems(503))
async def show_ready(services: Provided) -> dict[str, object]:
    """Return whether a load balancer should send this endpoint new connections: 200 if so, 503 if not. Needs no token.

    It should not while no master has answered it for 10 s, as long as a store has never answered it, and as long as no
    machine of the cloud can start containers, with `Retry-After`: on the first start on a computer, kernels are
    compiled. A store that is away later is no reason, since every endpoint would say the same: robots then drive on.
    """
    silence = services.cloud.master_silence
    if silence > GRACE:
        raise Unavailable("this endpoint has no master: connect to another one, or try again")
    if not services.health.have_answered:
        await services.health.stores(services.store, services.map_store)
        if not services.health.have_answered:
            raise Unavailable("a store has not answered this endpoint yet: connect to another one, or try again")
    start = services.cloud.start
    if not start.ready and (reason := start.refusal()) is not None:
        raise reason
    return {"ready": True}


def _kernels(start: StartState) -> dict[str, object] | None:
    progress: dict[str, object] | None = msgspec.to_builtins(start.kernels)
    return progress


async def _leader(services: Services) -> dict[str, object] | None:
    try:
        lease = await asyncio.to_thread(services.store.lease, MASTER)
    except PPaaSError:
        return None  # the store has just become unreachable
    return {"holder": lease.holder, "epoch": lease.epoch} if lease.holder else None


async def _may_see_reasons(request: Request, services: Services) -> bool:
    try:
        return (await authenticate(request, services.accounts)).role == "admin"
    except PPaaSError:
        return False


def _disk_health(disk: DiskState) -> dict[str, object]:
    return {"state": disk.state, "reason": disk.reason, "free": disk.free, "total": disk.total}


def _store_health(state: StoreState, reasons: bool) -> dict[str, object]:
    return {"state": "ok" if state.answers else "away", "reason": state.reason if reasons else None}
