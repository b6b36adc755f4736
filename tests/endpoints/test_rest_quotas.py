"""What each user may have, over REST."""

from collections.abc import Callable

import httpx
import msgspec
import pytest

from endpoints.services import Services
from storage.records import Limits
from tests.endpoints.conftest import LogIn, Publish
from tests.support.problems import problem_of

PATH = {"start": [0.0, 0.0], "goal": [1.0, 1.0]}


@pytest.fixture
def limit(services: Services) -> Callable[..., None]:
    """Return a call that gives a user limits of the user's own, as it stands in the store."""

    def give(user: str, **limits: float) -> None:
        changed = msgspec.structs.replace(services.store.user(user), limits=Limits(**limits))  # type: ignore[arg-type]
        services.store.change_user(changed)

    return give


@pytest.mark.parametrize("content_type", ["application/json", "application/json; charset=utf-8"])
async def test_paths_over_the_rate_are_refused_with_the_time_to_ask_again(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None], content_type: str
) -> None:
    ann = await log_in("ann")
    limit("ann", plans_per_minute=2)
    await publish(ann)
    headers = ann | {"Content-Type": content_type}
    for _ in range(2):
        assert (await client.post("/v1/maps/house/plans", headers=headers, json=PATH)).status_code == 201
    refused = await client.post("/v1/maps/house/plans", headers=headers, json=PATH)
    told = problem_of(refused, 429, "quota-exceeded")["detail"]
    assert "'ann' may ask for 2 paths a minute, of which 2 are used" in told and "plans_per_minute" in told
    assert 25 <= int(refused.headers["retry-after"]) <= 30
    bob = await log_in("bob")
    problem_of(await client.post("/v1/maps/house/plans", headers=bob, json=PATH), 404, "not-found")


async def test_a_cost_matrix_counts_as_many_paths_as_it_has_starts(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None]
) -> None:
    ann = await log_in("ann")
    limit("ann", plans_per_minute=5)
    await publish(ann)
    matrix = {"starts": [[0.0, 0.0]] * 4, "goals": [[1.0, 1.0]]}
    assert (await client.post("/v1/maps/house/cost_matrix", headers=ann, json=matrix)).status_code == 200
    problem_of(await client.post("/v1/maps/house/cost_matrix", headers=ann, json=matrix), 429, "quota-exceeded")
    assert (await client.post("/v1/maps/house/plans", headers=ann, json=PATH)).status_code == 201


async def test_what_no_time_helps_says_no_time(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, limit: Callable[..., None]
) -> None:
    ann = await log_in("ann")
    limit("ann", plans_per_minute=0)
    await publish(ann)
    refused = await client.post("/v1/maps/house/plans", headers=ann, json=PATH)
    problem_of(refused, 429, "quota-exceeded")
    assert "retry-after" not in refused.headers
