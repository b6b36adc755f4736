"""Routes of webhooks: users create, list, change and remove their own, and renew their secrets."""

import secrets
from contextlib import suppress
from typing import Annotated

from fastapi import APIRouter, Body, Path, Request, Response
from msgspec.structs import replace
from starlette.concurrency import run_in_threadpool

from endpoints.audit.requests import note_details, note_object
from endpoints.resources.services import Services
from endpoints.rest.dependencies import Caller, Paged, Provided
from endpoints.rest.names import Name
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute
from endpoints.rest.webhooks.schemas import SecretAnswer, WebhookAnswer, WebhookChange, WebhookFile
from endpoints.webhooks.calls import WebhookCalls
from endpoints.webhooks.messages import OVERLAP, TEST, new_delivery, new_secret
from engine.control.fleet_events import FleetEvent
from ppaas.clock import epoch
from ppaas.errors import QuotaExceeded, Unavailable
from storage.ports import Store
from storage.webhooks.records import Webhook

router = APIRouter(prefix="/webhooks", tags=["webhooks"], route_class=StrictRoute)

MOST_WEBHOOKS = 20
"""Limit of the webhooks of a user."""

WebhookId = Annotated[Name, Path(examples=["wh-9f1c0d6f6c1a"])]


@router.post("", status_code=201, response_model=SecretAnswer, responses=KNOWN | BODY | problems(429))
async def create_webhook(
    file: WebhookFile, request: Request, response: Response, services: Provided, user: Caller
) -> SecretAnswer:
    """Create a webhook. Its secret is returned only here."""
    response.headers["Cache-Control"] = "no-store"
    await calls_of(services).check_target(file.url)
    hook = Webhook(
        user=user.id, id=f"wh-{secrets.token_hex(6)}", url=file.url, events=tuple(file.events),
        robots=tuple(file.robots), maps=tuple(file.maps), description=file.description, state=file.state,
        secret=new_secret(), created=epoch(),
    )  # fmt: skip
    note_object(request.scope, f"webhooks/{hook.id}")
    await services.usage.in_turn(user.id, _add, services.store, hook)
    await told(services, user.id)
    return SecretAnswer.of(hook)


@router.get("", response_model=Page[WebhookAnswer], responses=KNOWN)
async def list_webhooks(services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the caller's webhooks by id."""
    after = paging.key(str, "")
    found = await run_in_threadpool(services.store.webhooks, user.id, after=after, limit=paging.fetch_limit)
    return paging.page([WebhookAnswer.of(hook) for hook in found], lambda hook: hook.id)


@router.get("/{webhook_id}", response_model=WebhookAnswer, responses=KNOWN | problems(404))
async def show_webhook(webhook_id: WebhookId, services: Provided, user: Caller) -> WebhookAnswer:
    """Show a webhook of the caller."""
    return WebhookAnswer.of(await run_in_threadpool(services.store.webhook, user.id, webhook_id))


@router.patch("/{webhook_id}", response_model=WebhookAnswer, responses=KNOWN | BODY | problems(404, 409))
async def change_webhook(
    webhook_id: WebhookId,
    change: Annotated[WebhookChange, Body(media_type=MERGE_PATCH)],
    request: Request,
    services: Provided,
    user: Caller,
) -> WebhookAnswer:
    """Change a webhook: pause it, enable it again, or send other events to another target."""
    hook = await run_in_threadpool(services.store.webhook, user.id, webhook_id)
    given = change.model_dump(exclude_none=True)
    if "url" in given:
        await calls_of(services).check_target(given["url"])
    note_details(request.scope, changed=sorted(given))
    fields = {name: tuple(value) if isinstance(value, list) else value for name, value in given.items()}
    changed = replace(hook, **fields, reason=hook.reason if given.get("state", hook.state) == "disabled" else "")
    await run_in_threadpool(lambda: services.store.put_webhook(changed, instead_of=hook))
    await told(services, user.id)
    return WebhookAnswer.of(changed)


@router.delete("/{webhook_id}", status_code=204, responses=KNOWN | problems(404))
async def remove_webhook(webhook_id: WebhookId, services: Provided, user: Caller) -> None:
    """Remove a webhook with its deliveries."""
    await run_in_threadpool(services.store.remove_webhook, user.id, webhook_id)
    await told(services, user.id)


@router.post("/{webhook_id}/secret", status_code=201, response_model=SecretAnswer, responses=KNOWN | problems(404, 409))
async def renew_webhook_secret(
    webhook_id: WebhookId, response: Response, services: Provided, user: Caller
) -> SecretAnswer:
    """Renew the secret of a webhook. For a day, deliveries are signed by the former secret too."""
    response.headers["Cache-Control"] = "no-store"
    hook = await run_in_threadpool(services.store.webhook, user.id, webhook_id)
    renewed = replace(hook, secret=new_secret(), former_secret=hook.secret, former_until=epoch() + OVERLAP)
    await run_in_threadpool(lambda: services.store.put_webhook(renewed, instead_of=hook))
    await told(services, user.id)
    return SecretAnswer.of(renewed)


@router.post("/{webhook_id}/test", status_code=202, responses=KNOWN | problems(404))
async def send_test_event(webhook_id: WebhookId, services: Provided, user: Caller) -> dict[str, str]:
    """Send an event of the type `webhook.test`, whatever events the webhook is for; return the id of the delivery."""
    hook = await run_in_threadpool(services.store.webhook, user.id, webhook_id)
    delivery = new_delivery(hook, FleetEvent(type=TEST, user=user.id))
    await run_in_threadpool(services.store.put_delivery, delivery)
    await told(services, user.id)
    return {"id": delivery.id}


def calls_of(services: Services) -> WebhookCalls:
    """Return the calls about webhooks; ``Unavailable`` if this process has no master to call."""
    if services.webhooks is None:
        raise Unavailable("no master sends webhooks for this endpoint")
    return services.webhooks


async def told(services: Services, user: str) -> None:
    """Ask the master to read the webhooks of a user; without one, the next leader does."""
    with suppress(Unavailable):
        await calls_of(services).changed(user)


def _add(store: Store, hook: Webhook) -> None:
    if len(store.webhooks(hook.user)) >= MOST_WEBHOOKS:
        raise QuotaExceeded(f"a user may have {MOST_WEBHOOKS} webhooks: remove one")
    store.put_webhook(hook)
