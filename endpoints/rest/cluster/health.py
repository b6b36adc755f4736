"""How the cloud does, for whoever watches over it."""

from fastapi import APIRouter, Request

from endpoints.accounts.authentication import authenticate
from endpoints.rest.cluster.schemas import HealthAnswer
from endpoints.rest.dependencies import Provided
from endpoints.services.services import Services
from endpoints.services.store_health import StoreState
from ppaas.errors import PPaaSError

router = APIRouter(prefix="/health", tags=["health"])


@router.get("", response_model=HealthAnswer)
async def show_health(request: Request, services: Provided) -> dict[str, object]:
    """Show whether the stores answer; nobody needs a token for it. Why one does not is told to administrators.

    While a store is away the cloud is `degraded`: robots are driven and paths planned on maps that are known already,
    and paths wait on the disk for the store to come back.
    """
    store, map_store = await services.health.stores(services.store, services.map_store)
    reasons = await _may_know_why(request, services)
    return {
        "status": "ok" if store.answers and map_store.answers and not store.waiting else "degraded",
        "store": _told(store, reasons),
        "map_store": _told(map_store, reasons),
        "plans_waiting": store.waiting,
    }


async def _may_know_why(request: Request, services: Services) -> bool:
    try:
        return (await authenticate(request, services.accounts)).role == "admin"
    except PPaaSError:
        return False


def _told(state: StoreState, reasons: bool) -> dict[str, object]:
    return {"state": "ok" if state.answers else "away", "reason": state.reason if reasons else None}
