"""Evaluation of planners over REST."""

import httpx
import pytest

from endpoints.rest.plans.evaluation import EvaluationAnswer
from endpoints.services.services import Services
from ppaas.plans.history import LinkHistory, compared_row, computed_row, failed_row, found_row
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish

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
