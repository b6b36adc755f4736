"""Changes of maps: readers and description."""

from typing import Any

import httpx
import pytest

from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish

MERGE = {"Content-Type": "application/merge-patch+json"}


async def test_the_owner_changes_readers_and_description(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    made = (await publish(ann, description="the ground floor")).json()
    changed = await client.patch("/v1/maps/house", headers=ann | MERGE, content='{"readers": ["bob", "bob"]}')
    assert (changed.json()["readers"], changed.json()["description"]) == (["bob"], "the ground floor")
    assert changed.json()["version"] == made["version"]
    problem_of(await client.patch("/v1/maps/house", headers=bob, json={"readers": ["*"]}), 403, "not-permitted")
    emptied = await client.patch("/v1/maps/house", headers=ann, json={"readers": None, "description": None})
    assert (emptied.json()["readers"], emptied.json()["description"]) == ([], "")
    problem_of(await client.patch("/v1/maps/house", headers=bob, json={"readers": ["*"]}), 404, "not-found")


@pytest.mark.parametrize(
    "change",
    [
        {"readers": ["../x"]},
        {"readers": "bob"},
        {"readers": ["u"] * 257},
        {"description": "x" * 1001},
        {"owner": "bob"},
    ],
)
async def test_invalid_map_changes_are_refused(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, change: dict[str, Any]
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    before = (await client.get("/v1/maps/house", headers=ann)).json()
    answer = await client.patch("/v1/maps/house", headers=ann, json=change)
    assert problem_of(answer, 422, "invalid-request")["errors"][0]["where"][:2] == ["body", next(iter(change))]
    assert (await client.get("/v1/maps/house", headers=ann)).json() == before
