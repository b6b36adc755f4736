"""Endpoints over REST, for administrators."""

import httpx
import pytest

from tests.support.endpoints.fake_cloud import FakeCloud, endpoint
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn


async def test_endpoints_are_listed_by_id_in_pages(client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud) -> None:
    cloud.serving = [endpoint("hall-1", state="silent"), endpoint("local-2"), endpoint("local-1")]
    admin = await log_in("admin")
    first = (await client.get("/v1/endpoints", params={"limit": 2}, headers=admin)).json()
    rest = (await client.get("/v1/endpoints", params={"limit": 2, "cursor": first["next"]}, headers=admin)).json()
    assert [one["id"] for one in (*first["items"], *rest["items"])] == ["hall-1", "local-1", "local-2"]
    assert (rest["next"], first["items"][0]["state"]) == (None, "silent")


async def test_an_endpoint_is_shown_with_its_load(client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud) -> None:
    admin = await log_in("admin")
    shown = (await client.get("/v1/endpoints/local-1", headers=admin)).json()
    assert shown == {
        "id": "local-1", "machine": "m1", "pid": 4711, "url": "http://127.0.0.1:8500", "release": "0.2.0",
        "state": "ready", "sockets": 3, "frames": 60.0, "cpu": 0.25, "memory": 90 << 20,
    }  # fmt: skip
    cloud.serving.clear()
    problem_of(await client.get("/v1/endpoints/local-1", headers=admin), 404, "not-found")


@pytest.mark.parametrize("path", ["/v1/endpoints", "/v1/endpoints/local-1"])
async def test_only_administrators_see_endpoints(client: httpx.AsyncClient, log_in: LogIn, path: str) -> None:
    problem_of(await client.get(path, headers=await log_in("ann")), 403, "not-permitted")
    problem_of(await client.get(path), 401, "not-authenticated")
