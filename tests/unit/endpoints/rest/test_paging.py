"""Pagination, equal for all lists."""

from typing import Any

import httpx
import pytest

from endpoints.resources.services import Services
from endpoints.rest.paging import DEFAULT_LIMIT, MAX_LIMIT
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import house, pgm, plan, put_map, robot, user
from tests.unit.endpoints.conftest import LogIn, Publish

LISTS = ["users", "tokens", "maps", "maps/m0/versions", "maps/m0/plans", "robots", "machines", "containers"]


@pytest.fixture
async def admin(services: Services, cloud: FakeCloud, log_in: LogIn) -> dict[str, str]:
    """Return the header of an administrator who has five objects of each kind."""
    header = await log_in("admin")
    for number in range(5):
        services.store.add_user(user(f"u{number}"))
        services.store.put_robot(robot(f"tb{number}", user="admin"))
        services.store.add_plan(plan(f"p{number}", map="m0", created=float(number // 2)))
        put_map(services.map_store, house(f"m{number}"))
        put_map(services.map_store, house("m0", image=pgm(value=number), created=float(number)))
        await services.accounts.login("admin", "correct horse")
    cloud.running = [container(f"c{number}") for number in (11, 2, 1, 10, 3)]
    return header


async def all_pages(client: httpx.AsyncClient, path: str, headers: dict[str, str], limit: int) -> list[Any]:
    items: list[Any] = []
    cursor: dict[str, str] = {}
    while True:
        answer = await client.get(f"/v1/{path}", headers=headers, params={"limit": limit} | cursor)
        page = answer.json()
        assert (answer.status_code, set(page)) == (200, {"items", "next"}), page
        assert len(page["items"]) <= limit
        items += page["items"]
        if page["next"] is None:
            return items
        cursor = {"cursor": page["next"]}


@pytest.mark.parametrize("path", LISTS)
async def test_pages_together_contain_the_whole_list(
    client: httpx.AsyncClient, admin: dict[str, str], path: str
) -> None:
    [whole, *others] = [await all_pages(client, path, admin, limit) for limit in (MAX_LIMIT, 5, 2, 1)]
    assert others == [whole] * 3
    assert len(whole) == {"machines": 1, "users": 6, "tokens": 6, "maps/m0/versions": 6}.get(path, 5)
    assert len({str(item) for item in whole}) == len(whole)


async def test_each_list_is_sorted(client: httpx.AsyncClient, admin: dict[str, str]) -> None:
    containers = await all_pages(client, "containers", admin, 2)
    assert [one["id"] for one in containers] == ["c1", "c2", "c3", "c10", "c11"]
    plans = await all_pages(client, "maps/m0/plans", admin, 2)
    assert [one["plan_id"] for one in plans] == ["p4", "p3", "p2", "p1", "p0"]
    versions = await all_pages(client, "maps/m0/versions", admin, 2)
    assert [one["number"] for one in versions] == sorted((one["number"] for one in versions), reverse=True)
    assert [one["present"] for one in versions] == [True, *[False] * 5]


async def test_changes_between_pages_cause_no_gaps_or_repeats(
    client: httpx.AsyncClient, admin: dict[str, str], services: Services
) -> None:
    first = (await client.get("/v1/robots", headers=admin, params={"limit": 2})).json()
    services.store.remove_robot("admin", "tb1")
    services.store.put_robot(robot("tb0a", user="admin"))
    rest = (await client.get("/v1/robots", headers=admin, params={"cursor": first["next"]})).json()
    assert [one["id"] for one in first["items"] + rest["items"]] == ["tb0", "tb1", "tb2", "tb3", "tb4"]


async def test_unreadable_maps_leave_no_gaps_in_pages(
    client: httpx.AsyncClient, admin: dict[str, str], services: Services, log_in: LogIn
) -> None:
    put_map(services.map_store, house("m2", readers=("bob",)))
    put_map(services.map_store, house("m4", readers=("bob",)))
    page = (await client.get("/v1/maps", headers=await log_in("bob"), params={"limit": 2})).json()
    assert ([one["id"] for one in page["items"]], page["next"]) == (["m2", "m4"], None)


@pytest.mark.parametrize("limit", ["0", "-1", str(MAX_LIMIT + 1), "many", "1.5", "NaN", "9" * 5000])
async def test_an_invalid_limit_is_refused(client: httpx.AsyncClient, admin: dict[str, str], limit: str) -> None:
    answer = await client.get("/v1/robots", headers=admin, params={"limit": limit})
    assert problem_of(answer, 422, "invalid-request")["errors"][0]["where"] == ["query", "limit"]


@pytest.mark.parametrize("cursor", ["", "x", "....", "ä", "\x00", "bnVsbA", "WzEsMl0", "InVuZmluaXNoZWQ", "_" * 256])
@pytest.mark.parametrize("path", LISTS)
async def test_an_invalid_cursor_is_refused(
    client: httpx.AsyncClient, admin: dict[str, str], path: str, cursor: str
) -> None:
    answer = await client.get(f"/v1/{path}", headers=admin, params={"cursor": cursor})
    assert "start again without a cursor" in problem_of(answer, 422, "invalid-parameter")["detail"]


@pytest.mark.parametrize("path", LISTS)
async def test_an_unknown_query_parameter_is_refused(
    client: httpx.AsyncClient, admin: dict[str, str], path: str
) -> None:
    answer = await client.get(f"/v1/{path}", headers=admin, params={"limt": 1})
    assert "'limt'" in problem_of(answer, 422, "invalid-parameter")["detail"]


async def test_a_page_has_the_default_limit(
    client: httpx.AsyncClient, admin: dict[str, str], services: Services
) -> None:
    for number in range(DEFAULT_LIMIT):
        services.store.put_robot(robot(f"x{number}", user="admin"))
    page = (await client.get("/v1/robots", headers=admin)).json()
    assert len(page["items"]) == DEFAULT_LIMIT
    assert page["next"] is not None


async def test_plans_and_versions_are_listed_to_readers_of_the_map(
    client: httpx.AsyncClient, admin: dict[str, str], services: Services, log_in: LogIn, publish: Publish
) -> None:
    bob = await log_in("bob")
    problem_of(await client.get("/v1/maps/m0/plans", headers=bob), 404, "not-found")
    problem_of(await client.get("/v1/maps/m0/versions", headers=bob), 404, "not-found")
    changed = await client.patch("/v1/maps/m0", json={"readers": ["bob"]}, headers=admin)
    assert changed.status_code == 200, changed.text
    [first, *_] = (await client.get("/v1/maps/m0/plans", headers=bob)).json()["items"]
    assert (first["plan_id"], first["user"]) == ("p4", "ann")
    assert "poses" not in first
