"""Plans and costs over the floors of a building over REST."""

import json
from typing import Any

import httpx
import pytest

from endpoints.audit.event import AuditQuery
from endpoints.resources.services import Services
from endpoints.rest.buildings.plan_schemas import BuildingPlanAnswer
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.unit.endpoints.conftest import LogIn, Publish
from tests.unit.endpoints.rest.buildings.test_buildings import JSON, TWO, features

START, GOAL = {"floor": "L1", "x": -0.9, "y": -1.9}, {"floor": "L2", "x": -0.9, "y": -1.95, "yaw": 1.0}
REQUEST: dict[str, Any] = {"start": START, "goal": GOAL}
PLANS, COSTS = "/v1/buildings/hq/plans", "/v1/buildings/hq/costs"


async def put_two_floors(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> dict[str, str]:
    """Put a building of ann with two floors and a lift, and return her headers."""
    headers = await log_in("ann")
    for map_id in ("m1", "m2"):
        await publish(headers, map_id)
        body = json.dumps({"type": "FeatureCollection", "features": features()})
        await client.put(f"/v1/maps/{map_id}/zones", headers=headers | JSON, content=body)
    answer = await client.put("/v1/buildings/hq", headers=headers | JSON, content=json.dumps(TWO))
    assert answer.status_code == 201, answer.text
    return headers


@pytest.fixture
async def ann(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> dict[str, str]:
    return await put_two_floors(client, log_in, publish)


async def test_a_route_has_its_legs_and_its_paths_are_stored(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud
) -> None:
    answer = await client.post(PLANS, headers=ann, json=REQUEST | {"robot": {"speed": 0.1}})
    assert answer.status_code == 200, answer.text
    found = answer.json()
    BuildingPlanAnswer.model_validate(found, strict=True)
    assert (found["takes"], found["building"], found["alternatives"]) == (["north"], 1, [])
    assert [(leg["kind"], leg["floor"], leg["to_floor"], leg["map"]) for leg in found["legs"]] == [
        ("drive", "L1", "L1", "m1"), ("lift", "L1", "L2", ""), ("drive", "L2", "L2", "m2"),
    ]  # fmt: skip
    assert found["legs"][1]["seconds"] > 30.0 + 2 * 3.0 + 4.0
    assert found["seconds"] == pytest.approx(sum(leg["seconds"] for leg in found["legs"]), abs=0.01)
    assert found["legs"][2]["poses"][-1] == [-0.9, -1.95, 1.0]
    for leg in (found["legs"][0], found["legs"][2]):
        kept = await client.get(f"/v1/plans/{leg['plan_id']}", headers=ann)
        assert (kept.status_code, kept.json()["map"]) == (200, leg["map"])
    assert {request.parameters["shut_doors"] for _, _, request in cloud.asked} == {True}


async def test_costs_are_times_between_floors(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    request = {"starts": [START, GOAL], "goals": [GOAL], "robot": {"speed": 0.1}}
    answer = await client.post(COSTS, headers=ann, json=request)
    assert answer.status_code == 200, answer.text
    plan = (await client.post(PLANS, headers=ann, json=REQUEST | {"robot": {"speed": 0.1}})).json()
    assert answer.json() == {"seconds": [[plan["seconds"]], [0.0]], "building": 1}


async def test_a_lift_to_avoid_leaves_no_route(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    request = {"starts": [START], "goals": [GOAL], "avoid": ["north"]}
    assert (await client.post(COSTS, headers=ann, json=request)).json()["seconds"] == [[None]]
    answer = await client.post(PLANS, headers=ann, json=REQUEST | {"avoid": ["north"]})
    assert answer.status_code == 422
    assert "without the closed doors and the lifts to avoid" in answer.json()["detail"]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"goal": GOAL | {"floor": "L9"}}, "there is no floor 'L9'"),
        ({"closed": [{"floor": "L1", "door": "gate"}]}, "has no door 'gate'"),
        ({"session": {"lift": "east", "floor": "L1", "inside": True}}, "no lift 'east'"),
        ({"timeout": 1e6}, "at most 60 s"),
        ({"robot": {"speed": 0}}, "greater than 0"),
        ({"alternatives": 11}, "less than or equal to 10"),
    ],
)
async def test_requests_that_make_no_sense_are_refused(
    client: httpx.AsyncClient, ann: dict[str, str], change: dict[str, Any], reason: str
) -> None:
    answer = await client.post(PLANS, headers=ann, json=REQUEST | change)
    assert answer.status_code in (400, 422), answer.text
    assert reason in answer.text


async def test_another_user_gets_no_plan(client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn) -> None:
    bob = await log_in("bob")
    for path, body in ((PLANS, REQUEST), (COSTS, {"starts": [START], "goals": [GOAL]})):
        answer = await client.post(path.replace("hq", "ann:hq"), headers=bob, json=body)
        assert answer.status_code == 404


async def test_plans_and_costs_are_no_changes_in_the_audit_log(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    for path, body in ((PLANS, REQUEST), (COSTS, {"starts": [START], "goals": [GOAL]})):
        assert (await client.post(path, headers=ann, json=body)).status_code == 200
    for action in ("plan_in_building", "compute_building_costs"):
        assert list(services.audit.read(AuditQuery(action=action))) == []
    assert len(list(services.audit.read(AuditQuery(action="put_building")))) == 1
