"""The table of operations by role in sharing.md is what the REST service grants, for every operation."""

import json
import re
from functools import cache
from typing import Any, get_args

import httpx
import pytest
from fastapi import FastAPI

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.tokens import token_id
from endpoints.app import create_app
from endpoints.resources.services import Services
from endpoints.rest.robots.robot_shares import MAX_SHARES
from endpoints.rest.users.schemas import MAX_GROUPS, MAX_LIFETIME
from endpoints.sharing.access import DESCRIPTION, GOALS, LOCALIZATION, PARAMETERS, TOLD
from engine.control import robot_navigation
from engine.rights.access import CONFIGURING, READING
from engine.rights.globs import MAX_GLOBS
from ppaas.geometry import Pose2D
from ppaas.mapping.serialization.mapping_file import pack_mapping
from ppaas.nodes.topics import TOPICS
from ppaas.tasks.records import Task
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from storage.records import MapTask, Token, User
from storage.sharing_records import ALL, SHARE_ROLES, Share, TokenRole, TokenScope
from tests.docs.test_security import BODIES, OPERATIONS, POSES, QUERIES, Operation
from tests.support.documents import table, text_of
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.still_place import StillRobot
from tests.support.engine.at_once import at_once
from tests.support.recordings.kept import RECORDING, kept_recordings
from tests.support.storage import records
from tests.support.world.mappings import room_mapping
from tests.support.world.urdf import example

PAGE = "docs/sharing.md"
SHARED = [f"share: {role}" for role in SHARE_ROLES]
TOKEN_ROLES: tuple[TokenRole, ...] = get_args(TokenRole)
SCOPED = [f"token: {role}" for role in TOKEN_ROLES]
PROGRAMS = {"merge_map"}
"""Operations that start a program, and whose rights are those of reading both maps."""

BODIES = {**BODIES, "put_robot": {"map": "open"}}
FILE = b"".join(pack_mapping(room_mapping(2)))


def publishes(role: str) -> tuple[str, ...]:
    return () if role == "look" else ALL


@cache
def maps() -> MemoryMapStore:
    """Return a store with maps, and a version that waits; no operation that is permitted here changes them."""
    store = MemoryMapStore()
    records.put_map(store, records.house())
    records.put_map(store, records.house("open", readers=("*",)))
    records.propose(store, records.house(image=records.pgm(value=0)))
    return store


def world() -> tuple[Services, dict[str, str]]:
    """Return services in which ann has a robot that is shared in each role, and tokens in each role; and names."""
    store, cloud = MemoryStore(), FakeCloud()
    services = Services(store, maps(), Accounts(store), cloud, recordings=kept_recordings(cloud, "ann", "tb1"))
    store.add_user(User("ann", ""))
    for role in SHARE_ROLES:
        store.add_user(User(role, ""))
        store.add_token(Token(token_id(f"share: {role}"), role, 1e12))
    for kind in TOKEN_ROLES:
        scope = TokenScope(("tb1",), kind, publishes(kind))
        store.add_token(Token(token_id(f"token: {kind}"), "ann", 1e12, scope=scope))
    [review] = services.map_store.reviews("house")
    shares = (Share("dora", "look"), *(Share(role, role, publishes(role)) for role in SHARE_ROLES))
    store.put_robot(records.robot("tb1", user="ann", shares=shares))
    store.put_urdf("ann", "tb1", example("turtlebot3_burger"))
    store.put_task(MapTask("ann", "house", Task(id="t1", kind="go_to", places=((0.2, 0.1, 0.0),))))
    store.add_plan(records.plan("p1", poses=POSES.tobytes(), version=records.house().version))
    cloud.running, cloud.map_file = [container(robot="tb2")], FILE
    cloud.connect("ann", "tb1", StillRobot())
    goal = at_once(cloud.robots.send_goal("ann", "tb1", Pose2D(0.2, 0.1, 0.0)))
    names = {
        "map_id": "house", "version": records.house().version, "robot_id": "ann:tb1", "user_id": "ann", "plan_id": "p1",
        "machine_id": "m1", "container_id": "c1", "planner": "navfn", "node": "amcl", "goal_id": goal.id,
        "endpoint_id": "local-1",
        "number": str(review.number), "grantee": "dora", "group_id": "hall", "token": token_id("token: look"),
        "recording_id": RECORDING, "robot": "tb1", "task_id": "t1",
        "webhook_id": "w1", "delivery_id": "d1", "building_id": "ann:hq",
    }  # fmt: skip
    return services, names


@pytest.fixture(scope="module")
def app() -> FastAPI:
    """Return an application, whose services each world replaces."""
    store = MemoryStore()
    return create_app(Services(store, MemoryMapStore(), Accounts(store), FakeCloud()))


async def statuses(app: FastAPI, operation: Operation, callers: list[str]) -> dict[str, int]:
    """Return the status of the answer to an operation for each caller; a change by one is not seen by the next."""
    found: dict[str, int] = {}
    services = None
    transport = httpx.ASGITransport(app)
    async with httpx.AsyncClient(transport=transport, base_url="http://cloud") as client:
        for caller in callers:
            if services is None:
                services, names = world()
                app.state.services = services
            headers = {"Authorization": f"Bearer {caller}", "Content-Type": "application/json; charset=utf-8"}
            content: Any = json.dumps(BODIES[operation.id]) if operation.id in BODIES else None
            if operation.id == "put_urdf":
                headers["Content-Type"], content = "application/xml", example("turtlebot3_burger")
            path = operation.path.format(**names)
            query = QUERIES.get(operation.id, {})
            answer = await client.request(operation.method, path, headers=headers, params=query, content=content)
            found[caller] = answer.status_code
            if answer.status_code < 400:
                services.cloud.robots.close()
                services.accounts.close()
                services = None
    if services is not None:
        services.cloud.robots.close()
        services.accounts.close()
    return found


def documented() -> dict[str, dict[str, bool]]:
    rights = {}
    for names, *cells in table(PAGE, "operations", *SHARED, *SCOPED):
        for name in re.findall(r"\w+", names):
            assert name not in rights, f"{name} is in two rows"
            rights[name] = {column: cell == "yes" for column, cell in zip([*SHARED, *SCOPED], cells, strict=True)}
    return rights


LOGINS = (
    "log_in", "begin_login", "log_in_by_code", "begin_device_login", "log_in_by_device", "log_in_by_access_token",
    "end_provider_sessions",
)  # fmt: skip
RIGHTS = documented()
ON_ROBOTS = [operation for operation in OPERATIONS if "{robot_id}" in operation.path]


def test_the_table_lists_every_operation_on_robots() -> None:
    assert {operation.id for operation in ON_ROBOTS} <= RIGHTS.keys()


@pytest.mark.parametrize("operation", ON_ROBOTS, ids=lambda operation: operation.id)
async def test_users_with_whom_a_robot_is_shared_may_do_what_the_table_says(
    app: FastAPI, operation: Operation, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robot_navigation, "POSE_TIMEOUT", 0.01)
    found = await statuses(app, operation, SHARED)
    granted = {caller: status not in (401, 403, 404) for caller, status in found.items()}
    assert granted == {caller: RIGHTS[operation.id][caller] for caller in SHARED}, found


@pytest.mark.parametrize(
    "operation", [one for one in OPERATIONS if one.id not in PROGRAMS], ids=lambda operation: operation.id
)
async def test_tokens_with_a_scope_may_do_what_the_table_says_and_nothing_else(
    app: FastAPI, operation: Operation, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robot_navigation, "POSE_TIMEOUT", 0.01)
    if operation.id in LOGINS:
        return  # needs no token, which is not read
    # Routes that take no scopes refuse all alike: the role with the most rights suffices.
    callers = SCOPED if operation.id in RIGHTS else ["token: administer"]
    found = await statuses(app, operation, callers)
    granted = {caller: status not in (401, 403, 404) for caller, status in found.items()}
    assert granted == {caller: RIGHTS.get(operation.id, {}).get(caller, False) for caller in callers}, found
    assert 401 not in found.values()


def told() -> dict[str, set[str]]:
    """Return the names of topics and services that each operation needs, as the page lists them."""
    rows: dict[str, set[str]] = {}
    for operations, names in table(PAGE, "operations that read", "need the right to"):
        for name in re.findall(r"\w+", operations):
            assert name not in rows, f"{name} is in two rows"
            rows[name] = set(re.findall(r"`([^`]+)`", names))
    return rows


READS = [one for one in ON_ROBOTS if RIGHTS[one.id]["share: look"]]


def test_each_route_that_reads_a_robot_names_the_topics_that_it_tells() -> None:
    assert {operation.id for operation in READS} | {"unshare_robot"} == TOLD.keys()
    assert {operation.method for operation in READS} == {"get"}
    others = [one.id for one in ON_ROBOTS if one.method == "get" and one not in READS]
    assert others == ["list_shares"], "it needs the role administer"
    assert told() == {name: set(names) for name, names in TOLD.items() if name != "unshare_robot"}


def test_all_that_routes_tell_are_topics_or_services_that_only_read() -> None:
    assert all(name in READING or name in TOPICS for names in TOLD.values() for name in names)


async def _read(app: FastAPI, operation: Operation, subscribe: tuple[str, ...], *, token: bool) -> httpx.Response:
    """Return the answer to one who has the role look, and some topics, by a share or by a token."""
    services, names = world()
    if token:
        scope = TokenScope(("tb1",), "look", (), subscribe)
        services.store.add_token(Token(token_id("some topics"), "ann", 1e12, scope=scope))
    else:
        record = services.store.robot("ann", "tb1")
        services.store.change_shares(record, (Share("look", "look", (), subscribe),))
        services.store.add_token(Token(token_id("some topics"), "look", 1e12))
    app.state.services = services
    transport = httpx.ASGITransport(app)
    async with httpx.AsyncClient(transport=transport, base_url="http://cloud") as client:
        answer = await client.get(
            operation.path.format(**names),
            headers={"Authorization": "Bearer some topics"},
            params=QUERIES.get(operation.id, {}),
        )
    services.cloud.robots.close()
    services.accounts.close()
    return answer


@pytest.mark.parametrize("token", [False, True], ids=["share", "token"])
@pytest.mark.parametrize("operation", READS, ids=lambda operation: operation.id)
async def test_who_may_subscribe_to_some_topics_reads_by_rest_what_these_tell(
    app: FastAPI, operation: Operation, monkeypatch: pytest.MonkeyPatch, token: bool
) -> None:
    monkeypatch.setattr(robot_navigation, "POSE_TIMEOUT", 0.01)
    needed = TOLD[operation.id]
    assert (await _read(app, operation, needed or ("nothing",), token=token)).status_code < 300
    everything = sorted({name for names in TOLD.values() for name in names} | {"scan", "map", "cmd_vel"})
    for lacking in needed:
        answer = await _read(app, operation, tuple(name for name in everything if name != lacking), token=token)
        assert answer.status_code == 403 and repr(lacking) in answer.json()["detail"], (lacking, answer.text)


async def test_parts_of_an_answer_that_topics_do_not_tell_are_null(
    app: FastAPI, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robot_navigation, "POSE_TIMEOUT", 0.01)
    by_id = {operation.id: operation for operation in READS}
    state = by_id["show_state"]
    little = (await _read(app, state, ("amcl_pose",), token=False)).json()
    assert (little["connected"], little["goals"], little["localization"]) == (True, None, None)
    more = (await _read(app, state, ("amcl_pose", *GOALS), token=True)).json()
    assert len(more["goals"]) == 1 and more["localization"] is None
    assert (await _read(app, state, ("amcl_pose", *LOCALIZATION), token=False)).json()["localization"] == ""
    robot = by_id["show_robot"]
    little = (await _read(app, robot, ("map",), token=True)).json()
    assert (little["map"], little["urdf"], little["parameters"]) == ("house", None, None)
    more = (await _read(app, robot, (*DESCRIPTION, *PARAMETERS), token=False)).json()
    assert more["urdf"]["links"] > 0 and more["parameters"] == {}


def test_limits_of_the_page_are_those_of_the_code() -> None:
    text = re.sub(r"\s+", " ", text_of(PAGE))
    assert f"at most {MAX_SHARES} users and groups, each with at most {MAX_GLOBS} globs" in text
    assert f"at most {MAX_GROUPS} groups" in text
    assert f"at most {MAX_LIFETIME / 86400:g} days" in text
    listed = text.split("configure the clone need the role `administer`:")[1].split(".")[0]
    patterns = [re.escape(name).replace(r"\*", ".*") for name in re.findall(r"`([^`]+)`", listed)]
    assert all(any(re.fullmatch(pattern, service) for pattern in patterns) for service in CONFIGURING)
