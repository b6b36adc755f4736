"""Groups of users over REST."""

import asyncio

import httpx
import pytest

from endpoints.resources.services import Services
from endpoints.rest.users.schemas import MAX_GROUPS
from storage.sharing_records import Share
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import robot
from tests.unit.endpoints.conftest import PASSWORD, LogIn

Header = dict[str, str]


@pytest.fixture
async def admin(log_in: LogIn) -> Header:
    for user in ("ann", "bob", "carl"):
        await log_in(user)
    return await log_in("admin")


async def members(client: httpx.AsyncClient, header: Header, group: str = "hall") -> list[str]:
    found: list[str] = (await client.get(f"/v1/groups/{group}", headers=header)).json()["members"]
    return found


async def test_a_group_is_created_changed_listed_and_removed(client: httpx.AsyncClient, admin: Header) -> None:
    created = await client.put("/v1/groups/hall", headers=admin, json={"members": ["bob", "ann", "bob"]})
    assert (created.status_code, created.json()) == (201, {"id": "hall", "members": ["ann", "bob"]})
    changed = await client.put("/v1/groups/hall", headers=admin, json={"members": ["carl", "bob"]})
    assert (changed.status_code, await members(client, admin)) == (200, ["bob", "carl"])
    await client.patch("/v1/users/ann", headers=admin, json={"groups": ["night", "hall"]})
    listed = (await client.get("/v1/groups", headers=admin)).json()["items"]
    assert listed == [{"id": "hall", "members": ["ann", "bob", "carl"]}, {"id": "night", "members": ["ann"]}]
    assert (await client.get("/v1/users/ann", headers=admin)).json()["groups"] == ["hall", "night"]
    assert (await client.delete("/v1/groups/hall", headers=admin)).status_code == 204
    problem_of(await client.get("/v1/groups/hall", headers=admin), 404, "not-found")
    assert (await client.get("/v1/users/ann", headers=admin)).json()["groups"] == ["night"]
    await client.patch("/v1/users/ann", headers=admin, json={"groups": None})
    assert (await client.get("/v1/groups", headers=admin)).json()["items"] == []


async def test_a_group_of_unknown_users_or_of_nobody_is_refused(client: httpx.AsyncClient, admin: Header) -> None:
    refused = await client.put("/v1/groups/hall", headers=admin, json={"members": ["ann", "nobody", "bbo"]})
    assert problem_of(refused, 404, "not-found")["detail"].startswith("unknown users 'bbo, nobody'; check the spelling")
    problem_of(await client.get("/v1/groups/hall", headers=admin), 404, "not-found")
    problem_of(await client.put("/v1/groups/hall", headers=admin, json={"members": []}), 422, "invalid-parameter")


async def test_members_see_their_group_and_nobody_else_does(
    client: httpx.AsyncClient, admin: Header, log_in: LogIn
) -> None:
    await client.put("/v1/groups/hall", headers=admin, json={"members": ["ann", "bob"]})
    assert await members(client, await log_in("bob")) == ["ann", "bob"]
    problem_of(await client.get("/v1/groups/hall", headers=await log_in("carl")), 404, "not-found")


async def test_only_administrators_change_groups(client: httpx.AsyncClient, admin: Header, log_in: LogIn) -> None:
    ann = await log_in("ann")
    for method, url, body in (
        ("GET", "/v1/groups", None),
        ("PUT", "/v1/groups/hall", {"members": ["ann"]}),
        ("DELETE", "/v1/groups/hall", None),
        ("PATCH", "/v1/users/me", {"groups": ["hall"]}),
    ):
        problem_of(await client.request(method, url, headers=ann, json=body), 403, "not-permitted")


async def test_rights_follow_the_group_at_once_and_end_with_it(
    client: httpx.AsyncClient, admin: Header, log_in: LogIn, services: Services
) -> None:
    services.store.put_robot(robot("tb1", user="ann", shares=(Share("group:hall", "look"),)))
    bob, url = await log_in("bob"), "/v1/robots/ann:tb1"
    problem_of(await client.get(url, headers=bob), 404, "not-found")
    await client.put("/v1/groups/hall", headers=admin, json={"members": ["bob"]})
    assert (await client.get(url, headers=bob)).status_code == 200
    await client.delete("/v1/groups/hall", headers=admin)
    problem_of(await client.get(url, headers=bob), 404, "not-found")
    await client.put("/v1/groups/hall", headers=admin, json={"members": ["bob"]})
    problem_of(await client.get(url, headers=bob), 404, "not-found")  # a later group of the name gets nothing


async def test_a_user_is_created_in_groups(client: httpx.AsyncClient, admin: Header) -> None:
    new = {"id": "dora", "password": PASSWORD, "groups": ["night", "hall"]}
    assert (await client.post("/v1/users", headers=admin, json=new)).json()["groups"] == ["hall", "night"]
    assert await members(client, admin) == ["dora"]


async def test_racing_requests_put_a_user_in_no_more_groups_than_allowed(
    client: httpx.AsyncClient, admin: Header, services: Services
) -> None:
    most = [f"g{number}" for number in range(MAX_GROUPS - 1)]
    await services.accounts.change("ann", regroup=lambda _: tuple(most))
    puts = [client.put(f"/v1/groups/new{number}", headers=admin, json={"members": ["ann"]}) for number in range(6)]
    answers = await asyncio.gather(*puts)
    assert sorted(answer.status_code for answer in answers) == [201, 422, 422, 422, 422, 422]
    assert len(services.store.user("ann").groups) == MAX_GROUPS
