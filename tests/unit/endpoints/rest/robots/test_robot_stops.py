"""Stops of robots over REST: who stops what, who releases it, what is listed and recorded."""

from typing import Any

import httpx
import pytest

from endpoints.audit.event import AuditQuery
from endpoints.resources.news import Caches
from endpoints.resources.services import Services
from engine.control.robot_stops import RobotStops
from engine.specs.robot_stops import stops_key, store_stops, stored_stops
from ppaas.messages.health.stops import ALL, MAP, ROBOT, RobotStop
from storage.records import CloneCheckpoint
from storage.sharing_records import Share
from tests.support.endpoints.problems import problem_of
from tests.support.storage import records
from tests.unit.endpoints.conftest import LogIn, Publish

Header = dict[str, str]
LONG = "x" * 201


@pytest.fixture
async def ann(log_in: LogIn, publish: Publish, services: Services) -> Header:
    """Return the header of a user with two robots, of which bob drives one."""
    header = await log_in("ann")
    await publish(header)
    services.store.put_robot(records.robot("tb1", shares=(Share("bob", "drive"), Share("carl", "look"))))
    services.store.put_robot(records.robot("tb2"))
    return header


@pytest.fixture
async def bob(log_in: LogIn, services: Services) -> Header:
    """Return the header of a user with a robot."""
    header = await log_in("bob")
    services.store.put_robot(records.robot("tb9", user="bob"))
    return header


async def order(client: httpx.AsyncClient, header: Header, path: str, reason: str = "") -> dict[str, Any]:
    answer = await client.post(f"/v1/{path}", headers=header, json={"reason": reason} if reason else {})
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


async def listed(client: httpx.AsyncClient, header: Header) -> list[tuple[str, str, str, str]]:
    items = (await client.get("/v1/stops", headers=header)).json()["items"]
    return [(one["user"], one["scope"], one["name"], one["by"]) for one in items]


async def test_a_robot_is_stopped_once_and_released_by_name(
    client: httpx.AsyncClient, ann: Header, services: Services
) -> None:
    [stop] = (await order(client, ann, "robots/tb1/stop", "a pallet fell"))["stops"]
    assert (stop["scope"], stop["name"], stop["by"], stop["reason"]) == (ROBOT, "tb1", "ann", "a pallet fell")
    assert (await order(client, ann, "robots/tb1/stop", "later"))["stops"] == [stop]
    shown = (await client.get("/v1/robots/tb1", headers=ann)).json()["stopped"]
    assert shown.startswith("stopped by 'ann' since ") and shown.endswith(": a pallet fell")
    robots = (await client.get("/v1/robots", headers=ann)).json()["items"]
    assert [one["stopped"] for one in robots] == [shown, None]
    assert await order(client, ann, "robots/tb1/release") == {"released": [stop], "left": []}
    assert await order(client, ann, "robots/tb1/release") == {"released": [], "left": []}
    assert stored_stops(services.store, "ann") == ()


async def test_who_drives_a_robot_stops_it_and_releases_only_their_own_stop(
    client: httpx.AsyncClient, ann: Header, bob: Header, log_in: LogIn
) -> None:
    await order(client, ann, "robots/tb1/stop")
    refused = await client.post("/v1/robots/ann:tb1/release", headers=bob, json={})
    assert "stopped by 'ann'" in problem_of(refused, 403, "not-permitted")["detail"]
    await order(client, ann, "robots/tb1/release")
    await order(client, bob, "robots/ann:tb1/stop")
    assert [stop["by"] for stop in (await order(client, bob, "robots/ann:tb1/release"))["released"]] == ["bob"]
    await order(client, bob, "robots/ann:tb1/stop")
    assert [stop["by"] for stop in (await order(client, ann, "robots/tb1/release"))["released"]] == ["bob"]
    carl = await log_in("carl")
    problem_of(await client.post("/v1/robots/ann:tb1/stop", headers=carl, json={}), 403, "not-permitted")
    problem_of(await client.post("/v1/robots/ann:tb2/stop", headers=carl, json={}), 404, "not-found")


async def test_a_stop_of_all_is_for_own_robots_and_those_that_the_caller_drives(
    client: httpx.AsyncClient, ann: Header, bob: Header, services: Services
) -> None:
    answer = await order(client, bob, "stop")
    assert [(one["user"], one["scope"], one["name"]) for one in answer["stops"]] == [
        ("bob", ALL, ""), ("ann", ROBOT, "tb1"),
    ]  # fmt: skip
    assert await listed(client, bob) == [("ann", ROBOT, "tb1", "bob"), ("bob", ALL, "", "bob")]
    assert await listed(client, ann) == [("ann", ROBOT, "tb1", "bob")]
    await order(client, bob, "robots/tb9/stop")
    released = await order(client, bob, "release")
    assert [one["user"] for one in released["released"]] == ["bob", "ann"]
    assert [one["name"] for one in released["left"]] == ["tb9"]
    assert stored_stops(services.store, "ann") == ()


async def test_a_stop_of_a_map_leaves_others_in_force(client: httpx.AsyncClient, ann: Header, bob: Header) -> None:
    await order(client, ann, "maps/house/stop")
    await order(client, ann, "robots/tb1/stop")
    answer = await order(client, ann, "robots/tb1/release")
    assert [(one["scope"], one["name"]) for one in answer["left"]] == [(MAP, "house")]
    assert await listed(client, bob) == [("ann", MAP, "house", "ann")], "it holds a robot that bob drives"
    problem_of(await client.post("/v1/maps/nowhere/stop", headers=ann, json={}), 404, "not-found")
    assert (await order(client, ann, "maps/house/release"))["left"] == []


async def test_a_token_for_some_robots_stops_these(client: httpx.AsyncClient, ann: Header) -> None:
    file = {"robots": ["tb2"], "role": "drive"}
    token = (await client.post("/v1/scoped-tokens", headers=ann, json=file)).json()["token"]
    scoped = {"Authorization": f"Bearer {token}"}
    assert [one["name"] for one in (await order(client, scoped, "stop"))["stops"]] == ["tb2"]
    assert await listed(client, scoped) == [("ann", ROBOT, "tb2", "ann")]
    problem_of(await client.post("/v1/maps/house/stop", headers=scoped, json={}), 403, "not-permitted")
    await order(client, ann, "stop")
    assert [one["name"] for one in (await order(client, scoped, "release"))["released"]] == ["tb2"]
    assert await listed(client, ann) == [("ann", ALL, "", "ann")]


async def test_stops_and_releases_are_recorded_with_their_reasons(
    client: httpx.AsyncClient, ann: Header, bob: Header, services: Services
) -> None:
    await order(client, ann, "robots/tb1/stop", "smoke")
    await client.post("/v1/robots/ann:tb1/release", headers=bob, json={"reason": "I see none"})
    store_stops(services.store, "ann", [RobotStop(ALL, "", "carl", 1.0)], 1.0)
    services.cloud.stops = RobotStops(services.cloud, services.store)  # type: ignore[arg-type]  # has read nothing yet
    await order(client, ann, "release", "clear")
    events = services.audit.read(AuditQuery())
    assert [(one.action, one.user, one.outcome, one.object, one.details) for one in events[:3]] == [
        ("release_all", "ann", "ok", "release", {"reason": "clear", "stopped_by": ["carl"]}),
        ("release_robot", "bob", "refused", "robots/ann:tb1", {"reason": "I see none"}),
        ("stop_robot", "ann", "ok", "robots/tb1", {"reason": "smoke"}),
    ]


@pytest.mark.parametrize("body", [{"reason": LONG}, {"reason": 7}, {"reasons": "x"}, []])
async def test_bad_bodies_are_refused_and_stop_nothing(client: httpx.AsyncClient, ann: Header, body: Any) -> None:
    problem_of(await client.post("/v1/stop", headers=ann, json=body), 422, "invalid-request")
    assert await listed(client, ann) == []


async def test_a_list_reads_the_stops_of_an_owner_once_until_they_change(
    client: httpx.AsyncClient, ann: Header, services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[str] = []
    clone = services.store.clone

    def counted(user: str, robot: str) -> CloneCheckpoint:
        read.append(f"{user}/{robot}")
        return clone(user, robot)

    async def stopped() -> list[bool]:
        items = (await client.get("/v1/robots", headers=ann)).json()["items"]
        return [one["stopped"] is not None for one in items]

    monkeypatch.setattr(services.store, "clone", counted)
    assert [await stopped() for _ in range(3)] == [[False, False]] * 3
    assert read.count(stops_key("ann")) == 1
    await order(client, ann, "robots/tb1/stop")
    assert await stopped() == [True, False]
    await order(client, ann, "robots/tb1/release")
    assert await stopped() == [False, False]
    store_stops(services.store, "ann", [RobotStop(ALL, "", "ann", 1.0)], 2.0)
    Caches(services).hear("robot", stops_key("ann"))  # another process has stopped them
    assert await stopped() == [True, True]
