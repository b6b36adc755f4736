"""Planners over REST."""

import httpx
import pytest

from endpoints.resources import installed_planners
from endpoints.resources.services import Services
from endpoints.rest.plans.evaluation import EvaluationAnswer
from ppaas.planners import planner_names
from ppaas.planners.catalogue import entry
from ppaas.plans.history import LinkHistory, compared_row, computed_row, failed_row, found_row
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish


async def test_every_planner_is_listed_with_purpose_and_parameters(client: httpx.AsyncClient, log_in: LogIn) -> None:
    answer = await client.get("/v1/planners", headers=await log_in("ann"))
    assert answer.status_code == 200, answer.text
    listed = answer.json()
    assert listed["next"] is None
    assert [planner["name"] for planner in listed["items"]] == list(planner_names())
    navfn = next(planner for planner in listed["items"] if planner["name"] == "navfn")
    assert navfn["aliases"] == ["navfn/NavfnROS", "nav2_navfn_planner/NavfnPlanner"]
    assert navfn["purpose"] == entry("navfn").purpose
    assert navfn["parameters"] == {"allow_unknown": True, "use_astar": False}
    assert (navfn["optimal"], navfn["any_angle"], navfn["dimensions"]) == ("never", True, 2)


async def test_a_planner_is_shown_by_name(client: httpx.AsyncClient, log_in: LogIn) -> None:
    headers = await log_in("ann")
    shown = await client.get("/v1/planners/dijkstra", headers=headers)
    assert (shown.json()["name"], shown.json()["optimal"]) == ("dijkstra", "always")
    missing = await client.get("/v1/planners/teleport", headers=headers)
    assert missing.status_code == 404
    assert "unknown planner 'teleport'; known: " in missing.json()["detail"]


async def test_listing_planners_requires_a_login(client: httpx.AsyncClient) -> None:
    assert (await client.get("/v1/planners")).status_code == 401


async def test_planners_are_unavailable_if_one_cannot_be_loaded(
    client: httpx.AsyncClient, log_in: LogIn, services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(installed_planners, "PROGRAM", ("-c", "raise ImportError('no such planner')"))
    answer = await client.get("/v1/planners", headers=await log_in("ann"))
    assert answer.status_code == 503
    assert "see the log of the cloud" in answer.json()["detail"]


@pytest.mark.parametrize("name", ["navfn/NavfnROS", "nav2_navfn_planner::NavfnPlanner", "greedy"])
async def test_a_robot_file_may_use_ros_planner_names(client: httpx.AsyncClient, log_in: LogIn, name: str) -> None:
    file = {"map": "nowhere", "base_global_planner": name, "base_local_planner": "dwa_local_planner/DWAPlannerROS"}
    answer = await client.put("/v1/robots/tb1", json=file, headers=await log_in("ann"))
    assert answer.status_code == 404  # of the map; the names are taken


@pytest.mark.parametrize("name", ["a/b/c", "/navfn", "navfn/", "", "x" * 70, "a b"])
async def test_an_invalid_planner_name_is_refused(client: httpx.AsyncClient, log_in: LogIn, name: str) -> None:
    file = {"map": "nowhere", "base_global_planner": name}
    answer = await client.put("/v1/robots/tb1", json=file, headers=await log_in("ann"))
    assert answer.status_code == 422
    assert "package/Class" in answer.text


OLD = "0" * 64


async def test_planners_are_evaluated_by_name_and_map_version(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    ann = await log_in("ann")
    version = (await publish(ann)).json()["version"]
    now, before = ("house", version, "navfn", 10), ("house", OLD, "navfn", 10)
    rows = [computed_row(now, 0.2), found_row(now, "reused"), failed_row(before), compared_row(now, 12.0, 10.0)]
    services.store.add_history(rows)
    services.store.put_link(LinkHistory("local", 0.001, 1e8, 3, 5.0))
    evaluation = (await client.get("/v1/maps/house/evaluation", headers=ann)).json()
    EvaluationAnswer.model_validate(evaluation, strict=True, extra="forbid")
    (navfn,) = evaluation["planners"]
    assert (navfn["queries"], navfn["success"], navfn["reuse_rate"]) == (3, pytest.approx(2 / 3), 0.5)
    assert navfn["over_cheapest"] == pytest.approx(0.2)
    assert evaluation["links"] == [
        {"link": "local", "round_trip": 0.001, "bandwidth": 1e8, "answers": 3, "measured": 5.0}
    ]
    one = (await client.get(f"/v1/maps/house/evaluation?version={version}", headers=ann)).json()
    assert (one["version"], one["planners"][0]["queries"]) == (version, 2)


async def test_a_map_without_read_access_is_not_found(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    await publish(await log_in("ann"))
    answer = await client.get("/v1/maps/house/evaluation", headers=await log_in("bob"))
    problem_of(answer, 404, "not-found")


async def test_an_invalid_version_is_refused(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    ann = await log_in("ann")
    await publish(ann)
    answer = await client.get("/v1/maps/house/evaluation?version=../etc", headers=ann)
    assert answer.status_code == 422
