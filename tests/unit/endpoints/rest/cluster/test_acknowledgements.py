"""Acknowledged alerts over REST: who may acknowledge which, and who sees it."""

from typing import Any

import httpx
import pytest

from endpoints.audit.event import AuditQuery
from endpoints.resources.services import Services
from storage.sharing_records import Share
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import building, robot
from tests.unit.endpoints.conftest import LogIn, Publish

PATH = "/v1/acknowledgements"
Header = dict[str, str]


@pytest.fixture
async def ann(log_in: LogIn, services: Services) -> Header:
    """Return the header of the owner of a robot, which bob may drive and carl may look at."""
    headers = {user: await log_in(user) for user in ("ann", "bob", "carl")}
    services.store.put_robot(robot("tb1", user="ann", shares=(Share("bob", "drive"), Share("carl", "look"))))
    services.store.put_robot(robot("tb2", user="ann"))
    return headers["ann"]


async def acknowledge(client: httpx.AsyncClient, header: Header, name: str, alert: str = "lost") -> httpx.Response:
    return await client.post(PATH, headers=header, json={"object": name, "alert": alert})


async def seen(client: httpx.AsyncClient, header: Header) -> list[tuple[str, str, str]]:
    items: list[dict[str, Any]] = (await client.get(PATH, headers=header)).json()["items"]
    return [(one["object"], one["alert"], one["by"]) for one in items]


async def test_all_who_reach_a_robot_see_that_one_of_them_has_acknowledged_its_alert(
    client: httpx.AsyncClient, ann: Header, log_in: LogIn
) -> None:
    answer = await acknowledge(client, await log_in("bob"), "robots/ann:tb1")
    assert answer.status_code == 201 and answer.json()["by"] == "bob"
    assert answer.json()["object"] == "robots/ann:tb1"
    await acknowledge(client, ann, "robots/tb2", "goal 7")
    assert await seen(client, ann) == [("robots/tb1", "lost", "bob"), ("robots/tb2", "goal 7", "ann")]
    for other in ("bob", "carl"):
        assert await seen(client, await log_in(other)) == [("robots/ann:tb1", "lost", "bob")]
    assert await seen(client, await log_in("dora")) == []


@pytest.mark.usefixtures("ann")
async def test_alerts_of_the_cloud_are_acknowledged_by_administrators_for_all(
    client: httpx.AsyncClient, log_in: LogIn
) -> None:
    for name, alert in (("cloud", "store"), ("endpoints/e1", "silent")):
        problem_of(await acknowledge(client, await log_in("bob"), name, alert), 403, "not-permitted")
        assert (await acknowledge(client, await log_in("admin"), name, alert)).status_code == 201
    expected = [("cloud", "store", "admin"), ("endpoints/e1", "silent", "admin")]
    assert await seen(client, await log_in("bob")) == expected
    page = (await client.get(f"{PATH}?limit=1", headers=await log_in("bob"))).json()
    rest = (await client.get(f"{PATH}?limit=1&cursor={page['next']}", headers=await log_in("bob"))).json()
    assert [one["object"] for one in (*page["items"], *rest["items"])] == ["cloud", "endpoints/e1"]


async def test_the_alert_of_a_task_is_acknowledged_by_its_owner(
    client: httpx.AsyncClient, ann: Header, log_in: LogIn, publish: Publish
) -> None:
    await publish(ann, readers="*")
    task = await client.post("/v1/maps/house/tasks", headers=ann, json={"kind": "go_to", "places": [[1.0, 2.0]]})
    name = f"maps/house/tasks/{task.json()['id']}"
    problem_of(await acknowledge(client, await log_in("bob"), name, "failed"), 404, "not-found")
    assert (await acknowledge(client, ann, name, "failed")).status_code == 201
    assert await seen(client, ann) == [(name, "failed", "ann")]


async def test_the_fault_of_a_lift_is_acknowledged_by_the_owner_of_the_building(
    client: httpx.AsyncClient, ann: Header, services: Services, log_in: LogIn
) -> None:
    services.store.put_building(building("hq"))
    problem_of(await acknowledge(client, await log_in("bob"), "buildings/hq", "lift north"), 404, "not-found")
    assert (await acknowledge(client, ann, "buildings/hq", "lift north")).status_code == 201
    assert await seen(client, ann) == [("buildings/hq", "lift north", "ann")]


@pytest.mark.usefixtures("ann")
@pytest.mark.parametrize(
    ("user", "name", "status", "slug"),
    [
        ("carl", "robots/ann:tb1", 403, "not-permitted"),
        ("bob", "robots/ann:tb2", 404, "not-found"),
        ("ann", "robots/tb9", 404, "not-found"),
        ("ann", "robots", 422, "invalid-parameter"),
        ("ann", "cloud/store", 422, "invalid-parameter"),
        ("ann", "", 422, "invalid-request"),
    ],
)
async def test_others_and_what_does_not_exist_are_refused(
    client: httpx.AsyncClient, log_in: LogIn, user: str, name: str, status: int, slug: str
) -> None:
    header = await log_in(user)
    problem_of(await acknowledge(client, header, name), status, slug)
    assert await seen(client, header) == []


async def test_it_is_recorded_who_acknowledged_what(client: httpx.AsyncClient, ann: Header, services: Services) -> None:
    await acknowledge(client, ann, "robots/tb1")
    (event,) = services.audit.read(AuditQuery(action="acknowledge_alert"))
    assert (event.user, event.object, event.details) == ("ann", "robots/tb1", {"alert": "lost"})
