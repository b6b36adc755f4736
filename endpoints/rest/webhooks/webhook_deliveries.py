"""Routes of deliveries of webhooks: those that wait, and those that were given up, which can be replayed."""

from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Query
from msgspec.structs import replace
from starlette.concurrency import run_in_threadpool

from endpoints.rest.dependencies import Caller, Provided
from endpoints.rest.names import Name
from endpoints.rest.openapi import KNOWN, problems
from endpoints.rest.paging import Page, StatePaging
from endpoints.rest.strict_json import StrictRoute
from endpoints.rest.webhooks.schemas import DeliveryAnswer, ReplayAnswer
from endpoints.rest.webhooks.webhooks import WebhookId, told
from ppaas.clock import epoch
from ppaas.errors import Conflict
from storage.migration.copying import one_by_one
from storage.ports import Store
from storage.webhooks.records import DeliveryState, WebhookDelivery

router = APIRouter(prefix="/webhooks/{webhook_id}", tags=["webhooks"], route_class=StrictRoute)

READ_AT_ONCE = 128
"""Deliveries that are read from the store at once."""

DeliveryId = Annotated[Name, Path(examples=["msg_0193f1c0d6f6-5e1c9a02"])]


@router.get("/deliveries", response_model=Page[DeliveryAnswer], responses=KNOWN | problems(404))
async def list_deliveries(
    webhook_id: WebhookId,
    services: Provided,
    user: Caller,
    paging: Annotated[StatePaging, Depends()],
    state: Annotated[DeliveryState | None, Query(description="Only deliveries in this state")] = None,
) -> dict[str, Any]:
    """List the deliveries of a webhook that wait, and those that were given up (`dead`), oldest first."""
    await run_in_threadpool(services.store.webhook, user.id, webhook_id)
    read = partial(_read, services.store, (user.id, webhook_id))
    found = await run_in_threadpool(paging.sought, read, lambda one: state in {None, one.state}, _id_of)
    return paging.page([DeliveryAnswer.of(record) for record in found], lambda answer: answer.id)


@router.post("/deliveries/{delivery_id}/replay", response_model=DeliveryAnswer, responses=KNOWN | problems(404, 409))
async def replay_delivery(
    webhook_id: WebhookId, delivery_id: DeliveryId, services: Provided, user: Caller
) -> DeliveryAnswer:
    """Send a delivery that was given up again, with the same id."""
    record = await run_in_threadpool(services.store.delivery, user.id, webhook_id, delivery_id)
    if record.state != "dead":
        raise Conflict(f"delivery {delivery_id!r} waits already")
    again = _again(record)
    await run_in_threadpool(services.store.put_delivery, again)
    await told(services, user.id)
    return DeliveryAnswer.of(again)


@router.post("/replay", response_model=ReplayAnswer, responses=KNOWN | problems(404))
async def replay_deliveries(webhook_id: WebhookId, services: Provided, user: Caller) -> ReplayAnswer:
    """Send all deliveries of a webhook that were given up again, with the same ids."""
    await run_in_threadpool(services.store.webhook, user.id, webhook_id)
    replayed = await run_in_threadpool(_replay_all, services.store, (user.id, webhook_id))
    await told(services, user.id)
    return ReplayAnswer(replayed=replayed)


@router.delete("/deliveries/{delivery_id}", status_code=204, responses=KNOWN | problems(404, 409))
async def remove_delivery(webhook_id: WebhookId, delivery_id: DeliveryId, services: Provided, user: Caller) -> None:
    """Remove a delivery that was given up."""
    record = await run_in_threadpool(services.store.delivery, user.id, webhook_id, delivery_id)
    if record.state != "dead":
        raise Conflict(f"delivery {delivery_id!r} waits: pause or remove the webhook")
    await run_in_threadpool(services.store.remove_delivery, user.id, webhook_id, delivery_id)


def _again(record: WebhookDelivery) -> WebhookDelivery:
    return replace(record, state="waiting", attempts=0, due=epoch(), ended=None)


def _replay_all(store: Store, key: tuple[str, str]) -> int:
    replayed = 0
    for record in one_by_one(partial(_read, store, key), "", _id_of):
        if record.state == "dead":
            store.put_delivery(_again(record))
            replayed += 1
    return replayed


def _read(store: Store, key: tuple[str, str], after: str) -> list[WebhookDelivery]:
    return store.deliveries(*key, after=after, limit=READ_AT_ONCE)


def _id_of(record: WebhookDelivery) -> str:
    return record.id
