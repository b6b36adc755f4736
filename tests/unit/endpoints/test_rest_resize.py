"""Containers of another size, over REST."""

import httpx
import pytest

from ppaas.errors import QuotaExceeded
from tests.endpoints.conftest import LogIn
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.problems import problem_of


async def test_a_container_is_resized_by_its_user_and_administrators_alone(
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
async def test_a_size_that_cannot_be_is_refused(
    client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud, body: object
) -> None:
    cloud.running = [container("c1")]
    answer = await client.patch("/v1/containers/c1", headers=await log_in("ann"), json=body)
    problem_of(answer, 422, "invalid-request")


async def test_what_the_engine_refuses_is_told(client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud) -> None:
    cloud.running, cloud.error = [container("c1")], QuotaExceeded("user 'ann' may have 1 cores and has 1")
    answer = await client.patch("/v1/containers/c1", headers=await log_in("ann"), json={"cores": 2})
    assert "may have 1 cores" in problem_of(answer, 429, "quota-exceeded")["detail"]
