"""Containers over REST."""

import httpx
import pytest

from ppaas.errors import QuotaExceeded
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn


async def test_only_its_user_and_administrators_resize_a_container(
    client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud
) -> None:
    cloud.running = [container("c1")]
    for user, cores in (("ann", 1.5), ("admin", 0.25)):
        answer = await client.patch("/v1/containers/c1", headers=await log_in(user), json={"cores": cores})
        assert (answer.status_code, answer.json()["cores"]) == (200, cores)
    bob = await log_in("bob")
    problem_of(await client.patch("/v1/containers/c1", headers=bob, json={"cores": 2}), 404, "not-found")
    assert cloud.running[0].cores == 0.25


@pytest.mark.parametrize("body", [{}, {"cores": 0}, {"cores": -1}, {"cores": "1"}, {"cores": None}, {"size": 1}, 3])
async def test_invalid_container_sizes_are_refused(
    client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud, body: object
) -> None:
    cloud.running = [container("c1")]
    answer = await client.patch("/v1/containers/c1", headers=await log_in("ann"), json=body)
    problem_of(answer, 422, "invalid-request")


async def test_resize_errors_of_the_engine_are_returned(
    client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud
) -> None:
    cloud.running, cloud.error = [container("c1")], QuotaExceeded("user 'ann' may have 1 cores and has 1")
    answer = await client.patch("/v1/containers/c1", headers=await log_in("ann"), json={"cores": 2})
    assert "may have 1 cores" in problem_of(answer, 429, "quota-exceeded")["detail"]


async def test_only_its_user_and_administrators_release_a_container(
    client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud
) -> None:
    cloud.running = [container("c1"), container("c2")]
    ann, bob = await log_in("ann"), await log_in("bob")
    assert (await client.get("/v1/containers/c1", headers=ann)).json()["robot"] == "tb1"
    for method in ("GET", "DELETE"):
        problem_of(await client.request(method, "/v1/containers/c1", headers=bob), 404, "not-found")
    assert (await client.delete("/v1/containers/c1", headers=ann)).status_code == 202
    assert (await client.delete("/v1/containers/c2", headers=await log_in("admin"))).status_code == 202
    assert cloud.given_up == ["c1", "c2"]
    problem_of(await client.delete("/v1/containers/c1", headers=ann), 404, "not-found")


async def test_users_list_their_containers_and_admins_list_all(
    client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud
) -> None:
    cloud.running = [
        container("c1", pss=5 << 20, ready_seconds=0.05, cpu=0.25, age=90.0, clients=1, connected=True),
        container("c2", user="bob", robot=None, kind="planning"),
    ]
    seen = {}
    for user in ("ann", "bob", "carl", "admin"):
        answer = await client.get("/v1/containers", headers=await log_in(user))
        seen[user] = [c["id"] for c in answer.json()["items"]]
    assert seen == {"ann": ["c1"], "bob": ["c2"], "carl": [], "admin": ["c1", "c2"]}
    first = (await client.get("/v1/containers", headers=await log_in("ann"))).json()["items"][0]
    assert first == {
        "id": "c1",
        "kind": "robot",
        "user": "ann",
        "robot": "tb1",
        "map": {"id": "house", "version": "v"},
        "machine": "m1",
        "cores": 1.0,
        "state": "ready",
        "pid": 42,
        "pss": 5 << 20,
        "ready_seconds": 0.05,
        "cpu": 0.25,
        "age": 90.0,
        "clients": 1,
        "connected": True,
        "round_trip": None,
    }
