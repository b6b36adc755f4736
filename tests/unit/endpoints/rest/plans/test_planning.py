"""Path requests over REST."""

import json
from collections.abc import AsyncIterator
from typing import Any, NoReturn

import httpx
import pytest

from endpoints.resources import plan_writer
from endpoints.resources.services import Services
from endpoints.rest.plans.schemas import NewPlanAnswer, PlanAnswer
from engine.specs.containers import MapVersion
from ppaas import errors
from ppaas.plans.path_service import PathRequest
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish

REQUEST: dict[str, Any] = {"start": [0.0, 0.0, 0.0], "goal": [3.0, 4.0, 0.0]}


async def test_a_path_is_planned_returned_and_stored(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud
) -> None:
    ann = await log_in("ann")
    version = (await publish(ann)).json()["version"]
    answer = await client.post("/v1/maps/house/plans", headers=ann, json=REQUEST)
    assert answer.status_code == 201
    NewPlanAnswer.model_validate(answer.json(), strict=True, extra="forbid")
    found = answer.json()
    plan_id, poses = found.pop("plan_id"), found.pop("poses")
    assert [row[:3] for row in poses] == [[0.0, 0.0, 0.0], [3.0, 4.0, 0.0]]
    assert poses[1][3:] == [0.0, 0.0, 0.0, 1.0]
    assert found == {
        "length": 5.0,
        "cost": 50.0,
        "expanded": 2,
        "seconds": 0.001,
        "planner": "dijkstra",
        "origin": "computed",
        "reused": None,
        "conditions": {"smooth": False, "bare_map": True, "robot_radius": 0.18},
        "map": "house",
        "version": version,
        "container": "c9",
        "pid": 4711,
    }
    asked = PathRequest((0.0, 0.0, 0.0), (3.0, 4.0, 0.0), "dijkstra", 0.0, 10.0)
    assert cloud.asked == [("ann", MapVersion("house", version), asked)]
    kept = (await client.get(f"/v1/plans/{plan_id}", headers=ann)).json()
    PlanAnswer.model_validate(kept, strict=True, extra="forbid")
    assert (kept["poses"], kept["user"], kept["goal"]) == (poses, "ann", [3.0, 4.0, 0.0])


async def test_parameters_reach_the_planner(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    given = {"allow_unknown": False, "inflation_radius": 0.3, "footprint": [[0, 0], [1, 0], [0, 1]]}
    answer = await client.post("/v1/maps/house/plans", headers=ann, json=REQUEST | {"parameters": given})
    assert answer.status_code == 201, answer.text
    assert cloud.asked[0][2].parameters == given


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [
        ([], "dictionary"),
        ({"x": "y" * 70_000}, "at most 65536"),
        ({"x": json.loads("[" * 500 + "]" * 500)}, "objects and lists within each other"),
    ],
)
async def test_parameters_that_are_no_small_object_are_refused(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud, parameters: object, reason: str
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    answer = await client.post("/v1/maps/house/plans", headers=ann, json=REQUEST | {"parameters": parameters})
    assert answer.status_code in (400, 413, 422)
    assert reason in answer.text
    assert cloud.asked == []


async def test_all_request_fields_reach_the_planner(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    body = {"start": [1, 2], "goal": [3, 4, 0.5], "planner": "theta_star", "tolerance": 0.3, "timeout": 2}
    body |= {"reuse": False, "labels": {"zone": "a"}}
    assert (await client.post("/v1/maps/house/plans", headers=ann, json=body)).status_code == 201
    asked = PathRequest((1.0, 2.0), (3.0, 4.0, 0.5), "theta_star", 0.3, 2.0, reuse=False, labels={"zone": "a"})
    assert cloud.asked[0][2] == asked


@pytest.mark.parametrize(
    "case",
    [
        (errors.InvalidPlanner("x"), 422, 201),
        (errors.PlanTransformError("x"), 422, 202),
        (errors.StartOutsideMap("x"), 422, 203),
        (errors.GoalOutsideMap("x"), 422, 204),
        (errors.StartOccupied("x"), 422, 205),
        (errors.GoalOccupied("x"), 422, 206),
        (errors.PlanTimeout("x"), 422, 207),
        (errors.NoValidPath("x"), 422, 208),
        (errors.QuotaExceeded("x"), 429, None),
        (errors.Unavailable("x"), 503, None),
        (errors.NotFound("planner", "x"), 404, None),
    ],
)
async def test_planning_errors_are_returned_with_status_and_code(
    client: httpx.AsyncClient,
    log_in: LogIn,
    publish: Publish,
    cloud: FakeCloud,
    case: tuple[errors.PPaaSError, int, int | None],
) -> None:
    error, status, code = case
    ann = await log_in("ann")
    await publish(ann)
    cloud.error = error
    answer = await client.post("/v1/maps/house/plans", headers=ann, json=REQUEST)
    assert problem_of(answer, status, error.slug).get("code") == code


@pytest.mark.parametrize(
    "change",
    [
        {"start": None},
        {"goal": []},
        {"goal": [1, 2, 3, 4]},
        {"goal": [float("nan"), 0]},
        {"start": [float("-inf"), 0]},
        {"tolerance": -0.1},
        {"tolerance": float("nan")},
        {"timeout": 0},
        {"timeout": float("inf")},
        {"planner": ""},
        {"planner": "x" * 65},
        {"unknown": 1},
    ],
)
async def test_invalid_path_requests_never_reach_a_planner(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud, change: dict[str, Any]
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    # Python's JSON encoder writes NaN and Infinity.
    headers = ann | {"Content-Type": "application/json"}
    answer = await client.post("/v1/maps/house/plans", headers=headers, content=json.dumps(REQUEST | change))
    assert problem_of(answer, 422, "invalid-request")["errors"][0]["where"][1] == next(iter(change))
    assert cloud.asked == []


async def test_a_timeout_over_the_maximum_is_refused(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    answer = await client.post("/v1/maps/house/plans", headers=ann, json=REQUEST | {"timeout": 61})
    assert "60 s" in problem_of(answer, 422, "invalid-parameter")["detail"]


async def test_planning_requires_read_access_to_the_map(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    await publish(ann)
    problem_of(await client.post("/v1/maps/house/plans", headers=bob, json=REQUEST), 404, "not-found")
    assert cloud.asked == []


async def test_plan_access_follows_map_access_and_authorship(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, bob, carl = await log_in("ann"), await log_in("bob"), await log_in("carl")
    await publish(ann, readers="bob")
    plan_id = (await client.post("/v1/maps/house/plans", headers=bob, json=REQUEST)).json()["plan_id"]
    path = f"/v1/plans/{plan_id}"
    assert (await client.get(path, headers=ann)).json()["user"] == "bob"
    assert problem_of(await client.get(path, headers=carl), 404, "not-found")["detail"] == f"unknown plan {plan_id!r}"
    await client.patch("/v1/maps/house", headers=ann, json={"readers": []})
    assert (await client.get(path, headers=bob)).status_code == 200, "a user keeps access to the own plan"
    await client.delete("/v1/maps/house", headers=ann)
    for reader in (ann, bob):
        problem_of(await client.get(path, headers=reader), 404, "not-found")


async def _in_pieces(body: bytes) -> AsyncIterator[bytes]:
    for at in range(0, len(body), 7000):
        yield body[at : at + 7000]
        yield b""


@pytest.mark.parametrize(
    "case",
    [
        (json.dumps(REQUEST).encode(), 201),
        (json.dumps(REQUEST).encode() + b" " * 20_000, 201),
        (json.dumps(REQUEST | {"tolerance": "x" * 20_000}).encode(), 422),
        (json.dumps(REQUEST).encode() + b" " * 20_000 + b"!", 400),
        (json.dumps(REQUEST).encode() + b" " * 100_000, 413),
    ],
    ids=["valid", "valid and long", "wrong type", "not JSON", "too large"],
)
async def test_a_request_sent_in_pieces_is_answered_like_a_whole_one(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, case: tuple[bytes, int]
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    body, status = case
    headers = ann | {"Content-Type": "application/json"}
    whole = await client.post("/v1/maps/house/plans", headers=headers, content=body)
    pieces = await client.post("/v1/maps/house/plans", headers=headers, content=_in_pieces(body))
    assert (whole.status_code, pieces.status_code) == (status, status)
    assert status == 201 or pieces.json() == whole.json()


async def test_a_reused_path_is_not_stored_again(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud, services: Services
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    first = (await client.post("/v1/maps/house/plans", headers=ann, json=REQUEST)).json()
    cloud.reused = first["plan_id"]
    again = (await client.post("/v1/maps/house/plans", headers=ann, json=REQUEST | {"tolerance": 1.0})).json()
    assert (again["origin"], again["reused"], again["plan_id"]) == ("reused", first["plan_id"], first["plan_id"])
    await services.plan_writer.settled()
    assert [plan.id for plan in services.store.plans("house")] == [first["plan_id"]]


async def test_paths_wait_for_a_store_that_takes_none_and_have_no_id_when_too_many_do(
    client: httpx.AsyncClient,
    services: Services,
    log_in: LogIn,
    publish: Publish,
    cloud: FakeCloud,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ann = await log_in("ann")
    await publish(ann)

    def full(_records: object) -> NoReturn:
        raise errors.Unavailable("the disk is full")

    with monkeypatch.context() as patch:
        patch.setattr(services.store, "add_plans", full)
        patch.setattr(plan_writer, "MOST_UNSTORED", 2)
        wanted = [REQUEST | {"goal": [3.0, float(y), 0.0]} for y in range(3)]
        made = [await client.post("/v1/maps/house/plans", headers=ann, json=one) for one in wanted[:2]]
        ids = [one.json()["plan_id"] for one in made]
        for name in ids:
            assert (await client.get(f"/v1/plans/{name}", headers=ann)).json()["plan_id"] == name
        more = await client.post("/v1/maps/house/plans", headers=ann, json=wanted[2])
        assert (more.status_code, more.json()["plan_id"]) == (200, "")
        assert more.json()["poses"]
        assert (await client.delete(f"/v1/plans/{ids[0]}", headers=ann)).status_code == 204
        problem_of(await client.get(f"/v1/plans/{ids[0]}", headers=ann), 404, "not-found")
    await services.plan_writer.close()
    assert services.store.plan(ids[1]).id == ids[1]
