"""REST service on a real socket with objects of every kind, for random requests."""

import asyncio
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from argon2 import PasswordHasher, profiles

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.accounts.tokens import token_id
from endpoints.app import create_app
from endpoints.audit.event import MemoryAuditLog
from endpoints.resources.services import Services
from endpoints.retention.kinds import Kept
from endpoints.retention.service import Retention
from endpoints.webhooks.service import Webhooks
from endpoints.webhooks.targets import TargetRules
from engine.control.fleet_events import FleetEvents
from ppaas.tasks.records import Task
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from storage.records import MapTask, Token, User
from storage.sharing_records import Share
from storage.webhooks.records import Webhook, WebhookDelivery
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.fake_journeys import FakeJourneys
from tests.support.endpoints.people import add_group, person
from tests.support.endpoints.serving import serve
from tests.support.endpoints.still_place import StillRobot
from tests.support.endpoints.traffic import add_traffic
from tests.support.recordings.kept import RECORDING, kept_recordings
from tests.support.storage.records import building, house, pgm, plan, propose, put_map, robot

TOKEN = "of an administrator"
MAP, ROBOT, USER = "office", "tb1", "ann"
PLAN = "9f1c0d6f6c1a4d0c8a52ad2d0cf0e6b1"
ZONES = b"""{"features":[{"type":"Feature","geometry":{"type":"Polygon","coordinates":[[[-1.0,-2.0],[-0.9,-2.0],\
[-0.9,-1.9]]]},"properties":{"kind":"keep_out","name":"stairs"}}],"time_zone":"UTC","type":"FeatureCollection"}"""
OFFICE = house(MAP, owner="root", image=pgm(), zones=ZONES)
KNOWN = {
    "map_id": MAP,
    "planner": "dijkstra",
    "version": OFFICE.version,
    "robot_id": ROBOT,
    "user_id": USER,
    "plan_id": PLAN,
    "token": "current",
    "machine_id": "m1",
    "endpoint_id": "local-1",
    "container_id": "c1",
    "node": "amcl",
    "goal_id": "rest-1",
    "number": "2",
    "grantee": "group:hall",
    "group_id": "hall",
    "recording_id": RECORDING,
    "robot": ROBOT,
    "task_id": "t1",
    "building_id": "hq",
    "webhook_id": "wh-1",
    "delivery_id": "msg_1",
}
"""Ids of existing objects by path parameter."""


@dataclass
class FuzzedService:
    """Service under test, its stores, and counts of its responses."""

    services: Services
    cloud: FakeCloud
    url: str = ""
    answers: Counter[tuple[str, int]] = field(default_factory=Counter)
    known: dict[str, str] = field(default_factory=KNOWN.copy)

    def refill(self) -> None:
        """Restore objects that requests may have removed."""
        store = self.services.store
        for user, role in (("root", "admin"), (USER, "user")):
            if user not in {known.id for known in store.users()}:
                store.add_user(User(user, "", role, groups=("hall",)))  # type: ignore[arg-type]
        store.add_token(Token(token_id(TOKEN), "root", 1e12))
        store.put_robot(robot(ROBOT, user="root", map=MAP, shares=(Share("group:hall", "look"),)))
        if not store.whole_plans([PLAN]):
            store.add_plan(plan(PLAN, user="root", map=MAP))
        self._refill_map()
        self.cloud.running = [container("c1", user="root", robot="tb2")]
        self.cloud.connect("root", ROBOT, StillRobot())
        self.cloud.groups.clear()
        add_group(self.cloud, "root", MAP, person(1))
        add_traffic(self.cloud, "root", MAP)
        if not store.buildings("root"):
            store.put_building(building(owner="root"))
        store.put_webhook(Webhook(user="root", id="wh-1", url="https://example.org", events=("*",)))
        given = {"user": "root", "hook": "wh-1", "event": "goal.reached", "body": b"{}", "created": 1.0}
        store.put_delivery(WebhookDelivery(id="msg_1", state="dead", ended=2.0, **given))  # type: ignore[arg-type]
        store.put_task(MapTask("root", MAP, Task(id="t1", kind="go_to", places=((1.0, 1.0, 0.0),))))

    def _refill_map(self) -> None:
        """Publish the map and propose a version of it, if requests have changed it or closed the review."""
        store = self.services.map_store
        if MAP not in {head.id for head in store.maps()} or store.map_head(MAP).version != KNOWN["version"]:
            put_map(store, OFFICE)
        waiting = [review for review in store.reviews(MAP) if review.state == "waiting"]
        if not waiting:
            waiting = [propose(store, house(MAP, owner="root", image=pgm(value=0), zones=ZONES))]
        self.known["number"] = str(waiting[0].number)

    def summary(self) -> str:
        """Return the number of requests of each operation by status."""
        lines = []
        for operation in sorted({operation for operation, _ in self.answers}):
            counts = sorted((status, n) for (name, status), n in self.answers.items() if name == operation)
            lines.append(f"{operation:48} " + "  ".join(f"{status}: {n}" for status, n in counts))
        return "\n".join([*lines, f"{len(lines)} operations, {sum(self.answers.values())} requests"])


@cache
def description() -> dict[str, Any]:
    """Return the OpenAPI description of the service."""
    store = MemoryStore()
    accounts = Accounts(store)
    try:
        return create_app(Services(store, MemoryMapStore(), accounts, FakeCloud())).openapi()
    finally:
        accounts.close()


def operations() -> list[tuple[str, str, dict[str, Any]]]:
    """Return the path, method and description of each operation."""
    return [
        (path, method, described)
        for path, methods in description()["paths"].items()
        for method, described in methods.items()
    ]


@contextmanager
def fuzzed_service() -> Iterator[FuzzedService]:
    """Serve from a separate thread."""
    store, cloud = MemoryStore(), FakeCloud()
    passwords = Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=2)
    accounts = Accounts(store, passwords=passwords)
    kept = kept_recordings(cloud, "root", ROBOT)
    audit = MemoryAuditLog()
    services = Services(
        store, MemoryMapStore(), accounts, cloud, recordings=kept, audit=audit,
        webhooks=Webhooks(store, FleetEvents(), TargetRules(), audit),
        retention=Retention(Kept(store, audit, kept), audit, {}),
    )  # fmt: skip
    services.journeys = FakeJourneys()
    service = FuzzedService(services, cloud)
    ready = threading.Event()
    loop = asyncio.new_event_loop()
    stop = asyncio.Event()

    async def run() -> None:
        async with serve(create_app(service.services)) as port:
            service.url = f"http://127.0.0.1:{port}"
            ready.set()
            await stop.wait()

    thread = threading.Thread(target=loop.run_until_complete, args=(run(),))
    thread.start()
    try:
        assert ready.wait(30)
        yield service
    finally:
        loop.call_soon_threadsafe(stop.set)
        thread.join(30)
        loop.close()
        accounts.close()
