"""The Path Plan Database over REST."""

from typing import Any

import httpx
import numpy as np
import pytest

from endpoints.resources.services import Services
from endpoints.rest.plans.schemas import FoundPlans, Parts, PlanSummary, StatisticsAnswer
from ppaas.geometry import poses_along
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import plan
from tests.unit.endpoints.conftest import LogIn, Publish

POSES = poses_along(np.stack((np.arange(60) * 0.05, np.zeros(60)), axis=1), 0.0)
FILE: dict[str, Any] = {"map": "house", "planner": "astar", "poses": POSES.tolist(), "cost": 7.5}
QUERY = {"map": "house", "start": "0,0", "goal": "2.95,0"}


@pytest.fixture
async def ann(log_in: LogIn, publish: Publish, services: Services) -> dict[str, str]:
    header = await log_in("ann")
    version = (await publish(header)).json()["version"]
    for number in range(2):
        kept = plan(f"p{number}", poses=POSES.tobytes(), length=2.95 + number, version=version)
        services.store.add_plan(kept)
    services.store.add_plan(plan("old", poses=POSES.tobytes(), version="v0"))
    return header


async def test_paths_are_found_by_start_and_goal(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    found = await client.get("/v1/plans", headers=ann, params=QUERY | {"start": "0.1,-0.1", "tolerance": 0.2})
    assert found.status_code == 200
    FoundPlans.model_validate(found.json(), strict=True)
    assert [each["plan_id"] for each in found.json()["items"]] == ["p0", "p1"]
    for less in ({"limit": 1}, {"tolerance": 0.0}, {"planner": "dijkstra", "limit": 1}):
        [first, *_] = (await client.get("/v1/plans", headers=ann, params=QUERY | less)).json()["items"]
        assert first["plan_id"] == "p0"
    for none in ({"start": "1,0"}, {"planner": "jps"}):
        assert (await client.get("/v1/plans", headers=ann, params=QUERY | none)).json()["items"] == []


@pytest.mark.parametrize(
    "wrong",
    [
        {"start": "1"},
        {"start": "nan,1"},
        {"goal": "a,b"},
        {"goal": "1e99,0"},
        {"tolerance": 9},
        {"limit": 0},
        {"map": ""},
    ],
)
async def test_invalid_path_queries_are_refused(
    client: httpx.AsyncClient, ann: dict[str, str], wrong: dict[str, Any]
) -> None:
    answer = await client.get("/v1/plans", headers=ann, params=QUERY | wrong)
    problem_of(answer, 422, "invalid-request")


async def test_a_path_is_stored_under_an_id_and_replaced(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    answer = await client.put("/v1/plans/mine", headers=ann, json=FILE)
    assert answer.status_code == 201
    PlanSummary.model_validate(answer.json(), strict=True)
    kept = services.store.plan("mine")
    assert (kept.user, kept.planner, kept.cost, kept.poses) == ("ann", "astar", 7.5, POSES.tobytes())
    assert kept.length == pytest.approx(2.95)
    assert (kept.start, kept.goal[:2]) == ((0.0, 0.0, 0.0), (59 * 0.05, 0.0))
    shorter = FILE | {"poses": POSES[:2].tolist(), "parameters": {"a": 1}}
    assert (await client.put("/v1/plans/mine", headers=ann, json=shorter)).status_code == 200
    assert services.store.plan("mine").poses == POSES[:2].tobytes()


async def test_a_patch_changes_only_the_given_fields_of_a_path(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    before = services.store.plan("p0")
    answer = await client.patch("/v1/plans/p0", headers=ann, json={"cost": 3.0, "parameters": {"weight": 2}})
    assert answer.status_code == 200
    after = services.store.plan("p0")
    assert (after.cost, after.parameters) == (3.0, {"weight": 2})
    assert (after.poses, after.created, after.version) == (before.poses, before.created, before.version)
    assert (await client.patch("/v1/plans/p0", headers=ann, json={"poses": POSES[5:].tolist()})).status_code == 200
    assert services.store.plan("p0").poses == POSES[5:].tobytes()
    assert services.store.plan("p0").cost == 3.0


async def test_paths_written_by_clients_have_the_origin_given(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    conditions = {"bare_map": True, "robot_radius": 0.18}
    answer = await client.put("/v1/plans/mine", headers=ann, json=FILE | {"parameters": conditions})
    assert answer.json()["origin"] == services.store.plan("mine").origin == "given"
    assert services.store.plan("p0").origin == services.store.plan("p1").origin == "computed"
    await client.put("/v1/plans/p0", headers=ann, json=FILE)
    await client.patch("/v1/plans/p1", headers=ann, json={"cost": 1.0})
    assert services.store.plan("p0").origin == services.store.plan("p1").origin == "given"
    problem_of(
        await client.put("/v1/plans/mine", headers=ann, json=FILE | {"origin": "computed"}), 422, "invalid-request"
    )
    problem_of(await client.patch("/v1/plans/p1", headers=ann, json={"origin": "computed"}), 422, "invalid-request")


@pytest.mark.parametrize(
    "wrong", [{"poses": []}, {"poses": [[0.0] * 6]}, {"poses": [[1e300] * 7]}, {"cost": -1}, {"map": None}, {"x": 1}]
)
async def test_invalid_paths_are_refused_and_the_stored_path_stays(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, wrong: dict[str, Any]
) -> None:
    before = services.store.plan("p0")
    for send in (client.put, client.patch):
        body = FILE | wrong if send == client.put else wrong
        problem_of(await send("/v1/plans/p0", headers=ann, json=body), 422, "invalid-request")
    assert services.store.plan("p0") == before


async def test_only_users_who_may_remove_a_path_may_replace_it(
    client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn
) -> None:
    bob = await log_in("bob")
    await client.patch("/v1/maps/house", headers=ann, json={"readers": ["bob"]})
    problem_of(await client.put("/v1/plans/p0", headers=bob, json=FILE), 403, "not-permitted")
    problem_of(await client.patch("/v1/plans/p0", headers=bob, json={"cost": 1.0}), 403, "not-permitted")
    eve = await log_in("eve")
    problem_of(await client.patch("/v1/plans/p0", headers=eve, json={"cost": 1.0}), 404, "not-found")
    problem_of(await client.get("/v1/plans", headers=eve, params=QUERY), 404, "not-found")
    problem_of(await client.get("/v1/plans/p0/parts", headers=eve), 404, "not-found")
    problem_of(await client.get("/v1/maps/house/plan_statistics", headers=eve), 404, "not-found")


async def test_shared_parts_and_plan_statistics_are_returned(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    parts = (await client.get("/v1/plans/p0/parts", headers=ann)).json()
    Parts.model_validate(parts, strict=True)
    assert sum(part["count"] for part in parts["items"]) == 57
    assert {part["plans"] for part in parts["items"]} == {2}
    statistics = (await client.get("/v1/maps/house/plan_statistics", headers=ann)).json()
    StatisticsAnswer.model_validate(statistics, strict=True)
    assert (statistics["plans"], statistics["waypoints"]) == (3, 180)
    assert statistics["kept"] == 9 + 2 * 57


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
