"""Stored plans over REST."""

import httpx

from endpoints.services.services import Services
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import plan
from tests.unit.endpoints.conftest import LogIn, Publish


async def test_a_plan_is_removed_by_its_user_map_owner_or_administrators(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    headers = {name: await log_in(name) for name in ("ann", "bob", "carl", "dora", "admin")}
    await publish(headers["ann"], readers="bob,carl")
    for plan_id in ("p1", "p2", "p3"):
        services.store.add_plan(plan(plan_id, user="bob", created=2e6))  # later than the users
    problem_of(await client.delete("/v1/plans/p1", headers=headers["carl"]), 403, "not-permitted")
    problem_of(await client.delete("/v1/plans/p1", headers=headers["dora"]), 404, "not-found")
    for user, plan_id in (("bob", "p1"), ("ann", "p2"), ("admin", "p3")):
        assert (await client.delete(f"/v1/plans/{plan_id}", headers=headers[user])).status_code == 204
    assert services.store.plans("house") == []
