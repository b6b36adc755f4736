"""The table of rights in security.md is what the REST service and the topics grant, for every operation and topic.

Roles: a caller without a token; another user; a user with whom the map is shared; the owner; an administrator.
"""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import httpx
import numpy as np
import pytest
from argon2 import PasswordHasher, profiles
from fastapi import FastAPI

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.accounts.tokens import token_id
from endpoints.app import create_app
from endpoints.audit.event import MemoryAuditLog
from endpoints.audit.file_log import PER_KEY
from endpoints.audit.files import FILES, MAX_SIZE
from endpoints.resources.services import Services
from endpoints.retention.kinds import Kept
from endpoints.retention.service import Retention
from endpoints.webhooks.service import Webhooks
from endpoints.webhooks.targets import TargetRules
from engine.control import robot_navigation
from engine.control.fleet_events import FleetEvents
from engine.rights.roles import Role, check_may_publish
from ppaas.buildings.building import Building, Floor
from ppaas.errors import NotPermitted
from ppaas.geometry import Pose2D, poses_along
from ppaas.mapping.serialization.mapping_file import pack_mapping
from ppaas.nodes.topics import TOPICS
from ppaas.tasks.records import Task
from storage.buildings.records import BuildingRecord, BuildingVersion
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from storage.records import MapTask
from storage.sharing_records import Share
from storage.webhooks.records import Webhook, WebhookDelivery
from tests.support.documents import table, text_of
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.fake_journeys import FakeJourneys
from tests.support.endpoints.fuzzed_rest import operations
from tests.support.endpoints.still_place import StillRobot
from tests.support.endpoints.traffic import add_traffic
from tests.support.recordings.kept import RECORDING, kept_recordings
from tests.support.storage import records
from tests.support.world.mappings import room_mapping
from tests.support.world.urdf import example

PAGE = "docs/security.md"
PASSWORD = "correct horse"
ROLES = ("nobody", "another user", "a reader of the map or building", "the owner", "an administrator")
USERS = dict(zip(ROLES[1:], ("bob", "carl", "ann", "admin"), strict=True))
POSES = poses_along(np.stack((np.arange(60) * 0.05, np.zeros(60)), axis=1), 0.0)

BODIES: dict[str, Any] = {
    "acknowledge_alert": {"object": "robots/ann:tb1", "alert": "lost"},
    "make_plan": {"start": [0.1, 0.1], "goal": [0.2, 0.1]},
    "compute_costs": {"starts": [[0.1, 0.1]], "goals": [[0.2, 0.1]]},
    "plan_fleet": {"starts": [[0.1, 0.1]], "goals": [[0.2, 0.1]], "radius": 0.2},
    "log_in": {"user": "ann", "password": PASSWORD},
    "create_user": {"id": "dora", "password": PASSWORD},
    "change_user": {"old_password": PASSWORD, "password": "another password"},
    "change_map": {"readers": ["*"]},
    "put_zones": {"type": "FeatureCollection", "features": []},
    "check_zones": {"type": "FeatureCollection", "features": []},
    "approve_review": {"why": "seen it"},
    "refuse_review": {"why": "it was a person"},
    "roll_back_map": {"version": records.house().version},
    "put_robot": {"map": "house", "initial_pose": [0.1, 0.1, 0.0]},
    "change_robot": {"cores": 0.5},
    "move_robot": {"map": "house", "pose": [0.2, 0.1]},
    "run_node": {"home": "cloud"},
    "send_goal": {"pose": [0.2, 0.1]},
    "share_robot": {"role": "look"},
    "create_token": {"robots": ["tb1"], "role": "look"},
    "put_group": {"members": ["bob"]},
    "publish_robot_map": {"publish": "office-2"},
    "put_people_settings": {"rule": "longest_seen"},
    "change_people_settings": {"history": True},
    "follow_people": {"people": []},
    "add_task": {"kind": "go_to", "places": [[0.2, 0.1]]},
    "put_plan": {"map": "house", "planner": "astar", "poses": POSES.tolist(), "cost": 7.5},
    "change_plan": {"cost": 3.0},
    "change_machine": {"draining": True},
    "resize_container": {"cores": 0.5},
    "merge_map": {"with": "house", "into": "both"},
    "start_recording": {"seconds": 1.0},
    "log_in_by_code": {"code": "c", "verifier": "v" * 43, "nonce": "n" * 43},
    "log_in_by_device": {"device_code": "d", "verifier": "v" * 43},
    "log_in_by_access_token": {"access_token": "a"},
    "put_building": {"floors": [{"name": "L1", "map": "house"}]},
    "check_building": {"floors": [{"name": "L1", "map": "house"}]},
    "change_building": {"readers": ["bob"]},
    "plan_in_building": {"start": {"floor": "L1", "x": 1, "y": 1}, "goal": {"floor": "L1", "x": 2, "y": 1}},
    "compute_building_costs": {"starts": [{"floor": "L1", "x": 1, "y": 1}], "goals": []},
    "create_webhook": {"url": "https://example.org", "events": ["*"]},
    "change_webhook": {"state": "paused"},
    "expire_data": {"dry_run": True},
    **{
        f"{verb}_{scope}": {"reason": "a pallet fell"}
        for verb in ("stop", "release")
        for scope in ("robot", "map", "all")
    },
}
"""A body for each operation that takes JSON."""

HOOK = Webhook(user="ann", id="wh-1", url="https://example.org", events=("*",))
DEAD = WebhookDelivery(user="ann", hook="wh-1", id="msg_1", event="e", body=b"{}", created=1.0, state="dead", ended=2.0)

QUERIES: dict[str, dict[str, str]] = {
    "find_plans": {"map": "house", "start": "0,0", "goal": "2.95,0"},
    "compare_versions": {"old": records.house().version},
}


@dataclass
class Operation:
    """An operation of the REST service."""

    id: str
    method: str
    path: str


@dataclass
class Seeded:
    """Services in which ann has a map, a robot, a plan, a container, a goal and a second token."""

    services: Services
    tokens: dict[str, str]
    names: dict[str, str]


@pytest.fixture(scope="module")
def passwords() -> Iterator[Passwords]:
    hashing = Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=1, waiting=8)
    yield hashing
    hashing.close()


@pytest.fixture(scope="module")
def app() -> FastAPI:
    """Return an application, whose services each request replaces."""
    store = MemoryStore()
    return create_app(Services(store, MemoryMapStore(), Accounts(store), FakeCloud()))


OPERATIONS = [Operation(described["operationId"], method, path) for path, method, described in operations()]


def building_of_the_house() -> BuildingRecord:
    """Return a building of ann with one floor, which carl may read."""
    made = Building(floors=(Floor(name="L1", map="house"),))
    return BuildingRecord(
        user="ann",
        id="hq",
        present=BuildingVersion(number=1, building=made, author="ann", created=1.0),
        readers=("carl",),
    )


async def seeded(passwords: Passwords) -> Seeded:
    store, cloud = MemoryStore(), FakeCloud()
    kept = kept_recordings(cloud, "ann", "tb1")
    audit = MemoryAuditLog()
    services = Services(
        store, MemoryMapStore(), Accounts(store, passwords=passwords), cloud, recordings=kept, audit=audit,
        webhooks=Webhooks(store, FleetEvents(), TargetRules(), audit),
        retention=Retention(Kept(store, audit, kept), audit, {}), journeys=FakeJourneys(),
    )  # fmt: skip
    tokens = {}
    for user in USERS.values():
        await services.accounts.register(user, PASSWORD, "admin" if user == "admin" else "user")
        tokens[user] = await services.accounts.login(user, PASSWORD)
    records.put_map(services.map_store, records.house(readers=("carl",)))
    review = records.propose(services.map_store, records.house(image=records.pgm(value=0)))
    await services.accounts.change("ann", regroup=lambda _: ("hall",))
    store.put_robot(records.robot("tb1", user="ann", shares=(Share("dora", "look"),)))
    store.put_urdf("ann", "tb1", example("turtlebot3_burger"))
    store.add_plan(records.plan("p1", poses=POSES.tobytes(), version=records.house().version))
    store.put_building(building_of_the_house())
    store.put_webhook(HOOK)
    store.put_delivery(DEAD)
    cloud.running = [container()]
    for user in USERS.values():
        add_traffic(cloud, user, "house")
        store.put_task(MapTask(user, "house", Task(id="t1", kind="go_to", places=((0.2, 0.1, 0.0),))))
    cloud.map_file = b"".join(pack_mapping(room_mapping(2)))
    cloud.connect("ann", "tb1", StillRobot())
    goal = await cloud.robots.send_goal("ann", "tb1", Pose2D(0.2, 0.1, 0.0))
    names = {
        "map_id": "house", "version": records.house().version, "robot_id": "tb1", "user_id": "ann", "plan_id": "p1",
        "machine_id": "m1", "container_id": "c1", "planner": "navfn", "node": "amcl", "goal_id": goal.id,
        "endpoint_id": "local-1",
        "number": str(review.number), "grantee": "dora", "group_id": "hall",
        "recording_id": RECORDING, "robot": "tb1", "task_id": "t1",
        "webhook_id": HOOK.id, "delivery_id": DEAD.id,
        "token": token_id(await services.accounts.login("ann", PASSWORD)),
    }  # fmt: skip
    return Seeded(services, tokens, names)


async def answer(app: FastAPI, passwords: Passwords, operation: Operation, role: str) -> httpx.Response:
    """Return the answer to an operation on what ann owns."""
    world = await seeded(passwords)
    app.state.services = world.services
    headers = {"Authorization": f"Bearer {world.tokens[USERS[role]]}"} if role in USERS else {}
    sent: dict[str, Any] = {"params": QUERIES.get(operation.id, {})}
    if operation.id in BODIES:
        # With this spelling path requests do not take the fast path, which has services of its own.
        headers["Content-Type"] = "application/json; charset=utf-8"
        sent["content"] = json.dumps(BODIES[operation.id])
    elif operation.id == "publish_map":
        sent |= {
            "data": {"id": "house"},
            "files": {"yaml": ("h.yaml", records.YAML), "image": ("h.pgm", records.pgm())},
        }
    elif operation.id == "put_urdf":
        headers["Content-Type"] = "application/xml"
        sent["content"] = example("turtlebot3_burger")
    is_own = operation.id == "put_robot" and role != "an administrator"  # who may put a robot on a map that ann reads
    own = {"building_id": "ann:hq"} | ({} if is_own else {"robot_id": "ann:tb1"})
    path = operation.path.format(**world.names | own)
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://cloud") as client:
        found = await client.request(operation.method, path, headers=headers, **sent)
    world.services.cloud.robots.close()  # type: ignore[attr-defined]
    return found


def is_permitted(found: httpx.Response, to_owner: httpx.Response) -> bool:
    """Return whether a caller has the right; what is missing for the owner too is no matter of rights."""
    if found.status_code == 404 and to_owner.status_code == 404:
        return bool(found.json()["detail"] == to_owner.json()["detail"])
    if found.status_code == 409 and to_owner.status_code < 400:
        return False  # the name belongs to somebody else
    assert found.status_code < 400 or found.status_code in (401, 403, 404, 409), found.text
    return found.status_code not in (401, 403, 404)


def documented() -> dict[str, tuple[bool, ...]]:
    rights = {}
    for names, *cells in table(PAGE, "operations", *ROLES):
        for name in re.findall(r"\w+", names):
            assert name not in rights, f"{name} is in two rows"
            rights[name] = tuple(cell == "yes" for cell in cells)
    return rights


def test_the_table_lists_every_operation_once() -> None:
    assert sorted(documented()) == sorted(operation.id for operation in OPERATIONS)


@pytest.mark.parametrize("operation", OPERATIONS, ids=lambda operation: operation.id)
async def test_an_operation_is_permitted_to_the_roles_of_the_table(
    app: FastAPI,
    passwords: Passwords,
    operation: Operation,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(robot_navigation, "POSE_TIMEOUT", 0.01)
    to_owner = await answer(app, passwords, operation, "the owner")
    answers = [to_owner if role == "the owner" else await answer(app, passwords, operation, role) for role in ROLES]
    granted = [is_permitted(found, to_owner) for found in answers]
    assert dict(zip(ROLES, granted, strict=True)) == dict(zip(ROLES, documented()[operation.id], strict=True))


@pytest.mark.parametrize("change", [{"role": "admin"}, {"limits": {"robots": 9}}])
async def test_only_administrators_change_roles_and_limits(
    app: FastAPI, passwords: Passwords, monkeypatch: pytest.MonkeyPatch, change: Any
) -> None:
    monkeypatch.setitem(BODIES, "change_user", change)
    [operation] = [operation for operation in OPERATIONS if operation.id == "change_user"]
    statuses = {role: (await answer(app, passwords, operation, role)).status_code for role in ROLES}
    assert [role for role, status in statuses.items() if status == 200] == ["an administrator"]


def test_topics_may_be_published_by_the_roles_of_the_table() -> None:
    def may(role: Role, topic: str) -> bool:
        try:
            check_may_publish(role, topic)
        except NotPermitted:
            return False
        return True

    rows = table(PAGE, "topics", "a robot publishes", "an operator publishes")
    reserved = {name for names, *cells in rows if cells == ["yes", "no"] for name in re.findall(r"[\w/]+", names)}
    assert {topic for topic in TOPICS if not may("operator", topic)} == reserved
    assert all(may("robot", topic) for topic in TOPICS)
    assert [tuple(cells) for _, *cells in rows] == [("yes", "no"), ("yes", "yes")]


def test_the_numbers_of_the_audit_log_are_those_of_the_code() -> None:
    text = re.sub(r"\s+", " ", text_of(PAGE))
    assert f"{FILES} files of {MAX_SIZE >> 20} MiB" in text
    assert f"more than {PER_KEY} similar events" in text
