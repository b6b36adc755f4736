"""Cost matrices over REST."""

import httpx
import pytest

from ppaas.errors import GoalOutsideMap
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.unit.endpoints.conftest import LogIn, Publish

REQUEST = {"starts": [[0, 0], [1, 2, 0.5]], "goals": [[3, 4], [1, 1], [2, 2]]}


@pytest.fixture
async def headers(publish: Publish, log_in: LogIn) -> dict[str, str]:
    """Return the header of ann, who has a map."""
    ann = await log_in("ann")
    assert (await publish(ann)).status_code == 201
    return ann


async def test_costs_are_returned_in_rows_with_map_and_container(
    client: httpx.AsyncClient, headers: dict[str, str], cloud: FakeCloud
) -> None:
    answer = await client.post("/v1/maps/house/cost_matrix", headers=headers, json=REQUEST)
    assert answer.status_code == 200, answer.text
    matrix = answer.json()
    assert matrix["costs"] == [[None, 50.0, 50.0]] * 2
    assert (matrix["map"], matrix["container"], matrix["pid"], matrix["seconds"]) == ("house", "c9", 4711, 0.001)
    [(user, version, request)] = cloud.costs_asked
    assert (user, version.id, version.version) == ("ann", "house", matrix["version"])
    assert request.starts == ((0.0, 0.0), (1.0, 2.0, 0.5))
    assert len(request.goals) == 3


async def test_parameters_reach_the_planner(
    client: httpx.AsyncClient, headers: dict[str, str], cloud: FakeCloud
) -> None:
    given = {"allow_unknown": False, "robot_radius": 0.3}
    answer = await client.post("/v1/maps/house/cost_matrix", headers=headers, json=REQUEST | {"parameters": given})
    assert answer.status_code == 200, answer.text
    assert cloud.costs_asked[0][2].parameters == given


@pytest.mark.parametrize(
    "change",
    [{"starts": [[0]]}, {"starts": "here"}, {"goals": [[0, 0]] * 1001}, {"timeout": 1e6}, {"timeout": 0}, {"speed": 1}],
)
async def test_invalid_cost_requests_are_refused(
    client: httpx.AsyncClient, headers: dict[str, str], cloud: FakeCloud, change: dict[str, object]
) -> None:
    answer = await client.post("/v1/maps/house/cost_matrix", headers=headers, json=REQUEST | change)
    assert answer.status_code == 422, answer.text
    assert cloud.costs_asked == []


async def test_planner_errors_are_returned_with_their_code(
    client: httpx.AsyncClient, headers: dict[str, str], cloud: FakeCloud
) -> None:
    cloud.error = GoalOutsideMap("the goal lies outside the map")
    answer = await client.post("/v1/maps/house/cost_matrix", headers=headers, json=REQUEST)
    assert (answer.status_code, answer.json()["code"]) == (422, 204)


async def test_a_map_without_read_access_is_not_found(
    client: httpx.AsyncClient, headers: dict[str, str], log_in: LogIn
) -> None:
    answer = await client.post("/v1/maps/house/cost_matrix", headers=await log_in("bob"), json=REQUEST)
    assert answer.status_code == 404
